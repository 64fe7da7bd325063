# SPDX-License-Identifier: Apache-2.0
"""Long work of a server of an action: a job for each goal, one for goals that are equal."""

from collections.abc import Callable
from functools import partial
from typing import Any, Generic

from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future

from rocsafe_ros.background_job import BackgroundJob, ProgressT, ResultT

# How often a running job is looked at, on the wall clock: simulated time may stand still.
WATCH_PERIOD_S = 0.1


class GoalJob(Generic[ResultT, ProgressT]):
    """A job under way, and the goals that wait for it.

    Attributes
    ----------
    is_replaced
        Whether a newer goal took its place.
    """

    def __init__(
        self, asked: str, job: BackgroundJob[ResultT, ProgressT], goal: ServerGoalHandle
    ) -> None:
        self._asked, self._job = asked, job
        self._goals = [goal]
        self.is_replaced = False

    @property
    def is_done(self) -> bool:
        """Whether it has ended."""
        return self._job.is_done

    @property
    def first(self) -> ServerGoalHandle | None:
        """The first goal that waits for it, None if all are cancelled."""
        return next((goal for goal in self._goals if not goal.is_cancel_requested), None)

    def result(self) -> ResultT:
        """Return what its work returned, or raise what it raised."""
        return self._job.result()

    def serves(self, asked: str) -> bool:
        """Return whether its result answers a request, too."""
        return asked == self._asked and not self.is_done and self.first is not None

    def join(self, goal: ServerGoalHandle) -> None:
        """Let one more goal wait for it."""
        self._goals.append(goal)

    def replace(self) -> None:
        """End it: a newer goal takes its place."""
        self.is_replaced = True
        self._job.cancel()

    def look(self) -> BackgroundJob[ResultT, ProgressT]:
        """Return the job; it is cancelled if no goal waits for it any more."""
        if self.first is None:
            self._job.cancel()
        return self._job


class GoalJobs(Generic[ResultT, ProgressT]):
    """The jobs of a server: a goal that asks for what is under way waits for the same job.

    A goal is sent again if its acceptance comes late.

    Parameters
    ----------
    node
        Node of the server.
    feedback
        Makes the feedback of a goal from its job.
    replaces
        Whether a new job ends those before it.
    """

    def __init__(
        self,
        node: Node,
        feedback: Callable[[BackgroundJob[ResultT, ProgressT]], Any],
        *,
        replaces: bool = False,
    ) -> None:
        self._node, self._feedback, self._replaces = node, feedback, replaces
        self._jobs: list[GoalJob[ResultT, ProgressT]] = []
        self._wall_clock = Clock(clock_type=ClockType.STEADY_TIME)

    def begin(
        self, goal: ServerGoalHandle, start: Callable[[], BackgroundJob[ResultT, ProgressT]]
    ) -> GoalJob[ResultT, ProgressT]:
        """Return the job for a goal: one under way, or what `start` starts; raises as it does."""
        asked = repr(goal.request)
        self._jobs = [job for job in self._jobs if not job.is_done]
        for job in self._jobs:
            if job.serves(asked):
                job.join(goal)
                return job
        begun = GoalJob(asked, start(), goal)
        if self._replaces:
            for job in self._jobs:
                job.replace()
            self._jobs.clear()
        self._jobs.append(begun)
        return begun

    async def ended(self, job: GoalJob[ResultT, ProgressT], goal: ServerGoalHandle) -> None:
        """Wait until a job has ended, without blocking; tell a goal its progress."""
        done = Future()
        timer = self._node.create_timer(
            WATCH_PERIOD_S, partial(self._watch, job, goal, done), clock=self._wall_clock
        )
        await done
        self._node.destroy_timer(timer)

    def _watch(
        self, job: GoalJob[ResultT, ProgressT], goal: ServerGoalHandle, done: Future
    ) -> None:
        """Report the progress of a goal; wake the goal when its job has ended."""
        if done.done():
            return
        goal.publish_feedback(self._feedback(job.look()))
        if job.is_done:
            done.set_result(None)
