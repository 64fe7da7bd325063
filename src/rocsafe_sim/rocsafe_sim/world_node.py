# SPDX-License-Identifier: Apache-2.0
"""The node ``world``: simulated time in lock-step, and markers of the scene."""

import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage
from std_srvs.srv import SetBool

from rocsafe_interfaces.msg import StepDone
from rocsafe_ros.conversions import diagnostic, ns_of_stamp, stamp_of_ns
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.process.run import run
from rocsafe_scene.flat_ground.ground_photograph import read_boxes
from rocsafe_sim.clock.clockwork import Clockwork, Pace
from rocsafe_sim.messages.marker_conversions import scene_markers
from rocsafe_sim.options import WorldOptions

# Wall period of the check whether the next time is due.
TICK_S = 0.1


class WorldNode(Node):
    """Publishes /clock: the next time when all participants have finished the last one.

    Subscribes: sim/step_done. Publishes: /clock, scene/markers. Service: world/run.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('world', **node_options)
        options = declare_options(self, WorldOptions)
        self._clockwork = Clockwork(
            Pace(start_ns=options.start_ns, step_ns=options.step_ns, speed=options.speed),
            options.participants,
            time.monotonic(),
            is_running=options.autostart,
            pauses_when_idle=options.pause_when_idle,
            pauses_on_news=options.pause_on_news,
        )
        self._missing: list[str] = []
        self._clocks_out = [topics.create_publisher(self, topics.CLOCK)]
        self._markers = topics.create_publisher(self, topics.SCENE_MARKERS)
        self._markers.publish(scene_markers(read_boxes(options.scene)))
        topics.create_subscription(self, topics.STEP_DONE, self._on_step_done)
        self.create_service(calls.WORLD_RUN.call_type, calls.WORLD_RUN.name, self._on_run)
        self._public = self._open_to_the_public()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        tick_s = min(TICK_S, options.step_s / options.speed) if options.speed else TICK_S
        self.create_timer(tick_s, self._advance, clock=steady)

    def _open_to_the_public(self) -> Node | None:
        """Return a node with the names that viewers know, None if this node has them itself.

        The nodes of a mission keep their time under names of their own, so that no other clock
        and no other mission can move or stop it.
        """
        if self.resolve_topic_name(topics.CLOCK.name) == topics.CLOCK.name:
            return None
        public = Node(
            'world_public',
            context=self.context,
            namespace=self.get_namespace(),
            use_global_arguments=False,
            start_parameter_services=False,
            enable_rosout=False,
        )
        self._clocks_out.append(topics.create_publisher(public, topics.CLOCK))
        public.create_service(calls.WORLD_RUN.call_type, calls.WORLD_RUN.name, self._on_run)
        return public

    @property
    def nodes(self) -> list[Node]:
        """The node itself, and the one for the public where there is one."""
        return [self] if self._public is None else [self, self._public]

    def _on_step_done(self, report: StepDone) -> None:
        if report.has_left:
            self._clockwork.dismiss(report.participant)
            self._advance()
            return
        self._clockwork.take(
            report.participant,
            ns_of_stamp(report.step),
            is_idle=report.is_idle,
            has_news=report.has_news,
        )
        self._advance()

    def _advance(self) -> None:
        due_ns = self._clockwork.due(time.monotonic())
        if due_ns is not None:
            message = ClockMessage(clock=stamp_of_ns(due_ns))
            for clock in self._clocks_out:
                clock.publish(message)

    def _on_run(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        was_running = self._clockwork.is_running
        self._clockwork.run(is_running=request.data)
        response.success = True
        response.message = 'time runs' if request.data else 'time is paused'
        if was_running != request.data:
            self.get_logger().info(response.message)
        self._advance()
        return response

    def health(self) -> list[DiagnosticStatus]:
        """Return whether time runs, and who holds it up."""
        missing = self._clockwork.missing(time.monotonic())
        if missing and missing != self._missing:
            self.get_logger().warning(f'time waits for {", ".join(missing)}')
        self._missing = missing
        text = 'time runs' if self._clockwork.is_running else 'time is paused'
        waiting = f'waits for {", ".join(missing)}'
        values = {'simulated_time_ns': self._clockwork.time_ns}
        return [diagnostic(waiting if missing else text, is_warning=bool(missing), values=values)]


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(lambda: WorldNode().nodes)


if __name__ == '__main__':
    raise SystemExit(main())
