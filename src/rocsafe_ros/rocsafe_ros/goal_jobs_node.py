# SPDX-License-Identifier: Apache-2.0
"""Server of an action with long work: a job for each goal, one for goals that are equal."""

from collections.abc import Callable
from typing import Any, Generic

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.timer import Timer

from rocsafe_ros.background_job import BackgroundJob, ProgressT, ResultT
from rocsafe_ros.interfaces.interface_spec import CallSpec

# How often a running job is looked at, on the wall clock: simulated time may stand still.
WATCH_PERIOD_S = 0.1


class GoalJob(Generic[ResultT, ProgressT]):
    """A job under way, and the goals that wait for it.

    Parameters
    ----------
    asked
        What its goals ask for.
    job
        The job, or why it could not be started.
    goal
        The first goal.

    Attributes
    ----------
    is_replaced
        Whether a newer goal took its place.
    """

    def __init__(
        self,
        asked: str,
        job: BackgroundJob[ResultT, ProgressT] | Exception,
        goal: ServerGoalHandle,
    ) -> None:
        self._asked, self._job = asked, job
        self.goals = [goal]
        self.is_replaced = False

    @property
    def is_done(self) -> bool:
        """Whether it has ended."""
        return isinstance(self._job, Exception) or self._job.is_done

    @property
    def first(self) -> ServerGoalHandle | None:
        """The first goal that waits for it, None if all are cancelled."""
        return next((goal for goal in self.goals if not goal.is_cancel_requested), None)

    def result(self) -> ResultT:
        """Return what its work returned, or raise what it, or its start, raised."""
        if isinstance(self._job, Exception):
            raise self._job
        return self._job.result()

    def serves(self, asked: str) -> bool:
        """Return whether its result answers a request, too."""
        return asked == self._asked and not self.is_done and self.first is not None

    def replace(self) -> None:
        """End it: a newer goal takes its place."""
        self.is_replaced = True
        self._cancel()

    def report(self, feedback: Callable[[BackgroundJob[ResultT, ProgressT]], Any]) -> None:
        """Tell its goals how far it is; it is cancelled if none waits for it any more."""
        if self.first is None:
            self._cancel()
        if not isinstance(self._job, Exception):
            message = feedback(self._job)
            for goal in self.goals:
                goal.publish_feedback(message)

    def _cancel(self) -> None:
        if not isinstance(self._job, Exception):
            self._job.cancel()


class GoalJobs(Generic[ResultT, ProgressT]):
    """Serves an action; a goal that asks for what is under way waits for the same job.

    A goal is sent again if its acceptance comes late. A goal is executed, in the terms of rclpy,
    when its job has ended: no coroutine waits for that, because the executors of rclpy resume a
    waiting coroutine all the time, which takes half of a core from the job.

    Parameters
    ----------
    node
        Node of the server.
    spec
        The action.
    start
        Starts the job of a goal. What it raises ends that goal alone.
    answer
        Ends a goal whose job has ended, and returns its result.
    feedback
        Makes the feedback of a goal from its job.
    replaces
        Whether a new job ends those before it.
    """

    def __init__(
        self,
        node: Node,
        spec: CallSpec,
        start: Callable[[ServerGoalHandle], BackgroundJob[ResultT, ProgressT]],
        answer: Callable[[ServerGoalHandle, GoalJob[ResultT, ProgressT]], Any],
        feedback: Callable[[BackgroundJob[ResultT, ProgressT]], Any],
        *,
        replaces: bool = False,
    ) -> None:
        self._node, self._feedback, self._replaces = node, feedback, replaces
        self._start, self._answer = start, answer
        self._jobs: list[GoalJob[ResultT, ProgressT]] = []
        self._ended: dict[bytes, GoalJob[ResultT, ProgressT]] = {}
        self._wall_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer: Timer | None = None
        self._server = ActionServer(
            node,
            spec.call_type,
            spec.name,
            execute_callback=self._execute,
            handle_accepted_callback=self._on_goal,
            cancel_callback=lambda _goal: CancelResponse.ACCEPT,
        )

    def destroy(self) -> None:
        """Take down the server."""
        self._server.destroy()

    def _on_goal(self, goal: ServerGoalHandle) -> None:
        """Begin the job of a goal, or let the goal wait for one under way."""
        asked = repr(goal.request)
        under_way = next((job for job in self._jobs if job.serves(asked)), None)
        if under_way is not None:
            under_way.goals.append(goal)
            return
        try:
            job = GoalJob(asked, self._start(goal), goal)
        except Exception as error:  # noqa: BLE001 - `answer` gets it with the result
            self._end(GoalJob(asked, error, goal))
            return
        if self._replaces:
            for before in self._jobs:
                before.replace()
        self._jobs.append(job)
        if self._timer is None:
            self._timer = self._node.create_timer(
                WATCH_PERIOD_S, self._watch, clock=self._wall_clock
            )

    def _watch(self) -> None:
        """Tell goals the progress of their jobs; end those whose jobs have ended."""
        for job in self._jobs:
            job.report(self._feedback)
        ended = [job for job in self._jobs if job.is_done]
        self._jobs = [job for job in self._jobs if job not in ended]
        for job in ended:
            self._end(job)
        if not self._jobs and self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None

    def _end(self, job: GoalJob[ResultT, ProgressT]) -> None:
        for goal in job.goals:
            self._ended[bytes(goal.goal_id.uuid)] = job
            goal.execute()

    def _execute(self, goal: ServerGoalHandle) -> Any:
        return self._answer(goal, self._ended.pop(bytes(goal.goal_id.uuid)))
