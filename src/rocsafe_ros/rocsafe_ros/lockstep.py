# SPDX-License-Identifier: Apache-2.0
"""Participation in lock-step simulation.

The world publishes a time on ``/clock`` and waits until every participant has reported that the
step is done; only then it publishes the next time. Therefore time never runs ahead of the work of
a participant, and a run gives the same result at every speed. While time stands still, the world
repeats its time and the participants repeat their reports, so neither a lost message nor a
restarted process stops the run.
"""

from collections.abc import Callable

from rclpy.clock import Clock, ClockType, JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter

from rocsafe_interfaces.msg import StepDone
from rocsafe_ros.conversions import stamp_of_ns
from rocsafe_ros.interfaces import topics

# Wall time after which a report is repeated; the world uses the same interval.
REPEAT_S = 0.5
# Most repetitions of the first report that wait for `is_ready`.
MOST_HELD_BACK = 20


class Participant:
    """Calls `on_step` once per step of simulated time and reports the step as done.

    Parameters
    ----------
    node
        The node that takes part; its parameter `use_sim_time` is set.
    name
        Name of the participant, as the world expects it.
    on_step
        Called with the time in nanoseconds; does all the work of the step, publishing included,
        and returns whether the participant is idle, that is, has nothing to do until a request.
        None: it still waits for an answer to what it published; `finish` reports the step.
    is_ready
        Returns whether the participant is connected to all nodes that it works with. Until then,
        but at most for ten seconds, its first report waits, and so does simulated time.
    has_news
        Returns whether something happened in the step that others are to answer at its time.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        on_step: Callable[[int], bool | None],
        is_ready: Callable[[], bool] = lambda: True,
        has_news: Callable[[], bool] = lambda: False,
    ) -> None:
        node.set_parameters([Parameter('use_sim_time', Parameter.Type.BOOL, True)])
        self._node = node
        self._name = name
        self._on_step = on_step
        self._is_ready = is_ready
        self._says_news = has_news
        self._has_begun = False
        self._held_back = 0
        self._last: StepDone | None = None
        self._open_ns: int | None = None
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
            # A time that the node knows already causes no jump when it is published again.
            self._work(heard_ns)

    def report(self, *, is_idle: bool) -> None:
        """Report the current step again if idleness has changed, for example by a new request."""
        if self._last is None or self._last.is_idle == is_idle:
            return
        self._last.is_idle = is_idle
        self._tell(self._last)

    def _on_jump(self, _jump: TimeJump) -> None:
        self._work(self._node.get_clock().now().nanoseconds)

    def _work(self, time_ns: int) -> None:
        self._open_ns, self._last = time_ns, None
        is_idle = self._on_step(time_ns)
        if is_idle is not None:
            self.finish(is_idle=is_idle)

    def finish(self, *, is_idle: bool) -> None:
        """Report the step that waits for an answer, if one does."""
        if self._open_ns is None:
            return
        time_ns, self._open_ns = self._open_ns, None
        self._last = StepDone(
            step=stamp_of_ns(time_ns),
            participant=self._name,
            is_idle=is_idle,
            has_news=self._says_news(),
        )
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
