# SPDX-License-Identifier: Apache-2.0
"""Taking part in lock-step simulation.

The world publishes a time on ``/clock`` and waits until every participant has reported that time
done before it publishes the next. So time never runs ahead of a participant's work, and a run
gives the same result at every speed. Time that stands still is published again, and a report that
brings nothing new is repeated: neither a lost message nor a restarted process stops the run.
"""

from collections.abc import Callable

from rclpy.clock import Clock, ClockType, JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter

from rocsafe_interfaces.msg import StepDone
from rocsafe_ros import topics
from rocsafe_ros.conversions import stamp_of_ns

# Wall time after which a report is repeated; the world repeats its time as often.
REPEAT_S = 0.5
# So many repetitions of the first report are held back, at most, for who is not ready.
MOST_HELD_BACK = 20


class Participant:
    """Calls `on_step` once a step of simulated time and reports the step done.

    Parameters
    ----------
    node
        The node that takes part; it is made to use simulated time.
    name
        How the world knows the participant.
    on_step
        Gets the time in nanoseconds, does all the work of that step, publishing included,
        and returns whether it is idle, that is, has nothing to do until somebody asks.
    is_ready
        Tells whether the participant hears all that it works with; until it does, but for
        no longer than ten seconds, its first report is held back and so is simulated time.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        on_step: Callable[[int], bool],
        is_ready: Callable[[], bool] = lambda: True,
    ) -> None:
        node.set_parameters([Parameter('use_sim_time', Parameter.Type.BOOL, True)])
        self._node = node
        self._name = name
        self._on_step = on_step
        self._is_ready = is_ready
        self._has_begun = False
        self._held_back = 0
        self._last: StepDone | None = None
        self._has_news = False
        self._done = topics.create_publisher(node, topics.STEP_DONE)
        threshold = JumpThreshold(
            min_forward=Duration(nanoseconds=1), min_backward=None, on_clock_change=False
        )
        self._jumps = node.get_clock().create_jump_callback(threshold, post_callback=self._on_jump)
        self._repeats = node.create_timer(
            REPEAT_S, self._repeat, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        heard_ns = node.get_clock().now().nanoseconds
        if heard_ns > 0:
            # Time that the node has heard already does not jump when it is published again.
            self._work(heard_ns)

    def report(self, *, is_idle: bool) -> None:
        """Report the current step again with a new idleness, for instance on a new request."""
        if self._last is None or self._last.is_idle == is_idle:
            return
        self._last.is_idle = is_idle
        self._tell(self._last)

    def _on_jump(self, _jump: TimeJump) -> None:
        self._work(self._node.get_clock().now().nanoseconds)

    def _work(self, time_ns: int) -> None:
        is_idle = self._on_step(time_ns)
        self._last = StepDone(step=stamp_of_ns(time_ns), participant=self._name, is_idle=is_idle)
        self._has_news = True
        self._tell(self._last)

    def _repeat(self) -> None:
        if self._last is not None and not self._has_news:
            self._held_back += not self._has_begun
            self._tell(self._last)
        self._has_news = False

    def _tell(self, report: StepDone) -> None:
        if not self._has_begun:
            self._has_begun = self._is_ready() or self._held_back >= MOST_HELD_BACK
            if self._has_begun and not self._is_ready():
                self._node.get_logger().warning(f'{self._name}: begins though not all are heard')
        if self._has_begun:
            self._done.publish(report)
