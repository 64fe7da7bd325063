# SPDX-License-Identifier: Apache-2.0
"""The planner as a ROS node: `ros2 run rocsafe_planner planner`."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future

from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_interfaces.action import PlanSurvey
from rocsafe_interfaces.msg import SurveyPlan
from rocsafe_planner.checked_planning import checked_plan
from rocsafe_planner.conversions import (
    feedback,
    message_of_plan,
    request_of_goal,
    result_of_error,
    result_of_plan,
    result_of_stopped,
    situation_of_goal,
)
from rocsafe_planner.errors import PlannerError
from rocsafe_planner.export.plan_files import write_plan
from rocsafe_planner.options import PlannerOptions
from rocsafe_planner.plan.plan import SurveyPlan as PlanValue
from rocsafe_planner.plan.plan_reading import exported_plan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.planning import UNKNOWN, Figures
from rocsafe_planner.replanning import remaining_request
from rocsafe_ros.background_job import BackgroundJob
from rocsafe_ros.calls import PLAN_SURVEY
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.run import run
from rocsafe_ros.topics import PLAN, create_publisher

# How often a running job is looked at, on the wall clock: simulated time may stand still.
WATCH_PERIOD_S = 0.1


@dataclass(frozen=True, slots=True)
class _Search:
    """A search under way, and the goals that wait for it: one that is sent twice is one search."""

    asked: str
    job: BackgroundJob[SurveyPlan, Figures]
    goals: list[ServerGoalHandle]

    def serves(self, asked: str) -> bool:
        """Return whether its plan answers a request, too."""
        return asked == self.asked and not self.job.is_done and not self.is_cancelled

    @property
    def first(self) -> ServerGoalHandle | None:
        """The first goal that waits for it, None if all are cancelled."""
        return next((goal for goal in self.goals if not goal.is_cancel_requested), None)

    @property
    def is_cancelled(self) -> bool:
        """Whether no goal waits for it any more."""
        return self.first is None


def _load_solver(_report: Callable[[None], bool]) -> None:
    from rocsafe_planner.solver.precompile import load_kernels

    load_kernels()


class PlannerNode(Node):
    """Plans surveys on request.

    Actions: `plan_survey`. Publishes: `plan` (latched), the newest plan. Parameters: see
    `PlannerOptions`. A goal is planned in a thread of its own; a timer reports its progress. When
    it is cancelled, or a newer goal takes its place, it ends with the best plan so far. A goal
    that asks for what is being planned waits for the same plan.
    """

    def __init__(self, **kwargs: object) -> None:
        super().__init__('planner', **kwargs)
        self._options = declare_options(self, PlannerOptions)
        self._plan_publisher = create_publisher(self, PLAN)
        self._plans: dict[str, PlanValue] = {}
        self._newest: _Search | None = None
        self._wall_clock = Clock(clock_type=ClockType.STEADY_TIME)
        # While the other nodes start: the first goal need not wait for it.
        BackgroundJob(_load_solver, 'loading', None)
        self._server = ActionServer(
            self,
            PlanSurvey,
            PLAN_SURVEY.name,
            execute_callback=self._execute,
            cancel_callback=lambda _goal: CancelResponse.ACCEPT,
        )

    def destroy_node(self) -> None:
        """Take down the action server with the node."""
        self._server.destroy()
        super().destroy_node()

    async def _execute(self, goal: ServerGoalHandle) -> PlanSurvey.Result:
        """Plan in a thread, wait for it without blocking, publish the plan."""
        search: _Search | None = None
        try:
            search = self._search(goal)
            await self._ended(search, goal)
            message = search.job.result()
        except (PlannerError, ValueError) as error:
            return self._refuse(goal, error, is_replaced=search not in (None, self._newest))
        message.header.stamp = self.get_clock().now().to_msg()
        if goal.is_cancel_requested:
            goal.canceled()
            return result_of_stopped('cancelled', message)
        if search is not self._newest:
            goal.abort()
            return result_of_stopped('a newer goal took its place', message)
        if goal is search.first:
            self._plan_publisher.publish(message)
            self.get_logger().info(
                f'plan {message.plan_id}: {message.makespan_s:.0f} s, '
                f'no plan is below {message.lower_bound_s:.0f} s'
            )
        goal.succeed()
        return result_of_plan(message)

    def _request(self, goal: PlanSurvey.Goal) -> SurveyRequest:
        """Return what a goal asks for: a new plan, or the rest of one made before."""
        if not goal.rest_of:
            return request_of_goal(goal, self._options)
        situation = situation_of_goal(goal)
        terrain = read_terrain(goal.terrain_file) if goal.terrain_file else None
        plan = self._plans.get(goal.rest_of)
        return remaining_request(
            plan or exported_plan(self._options.exported(goal.rest_of), goal.rest_of, terrain),
            situation,
        )

    def _search(self, goal: ServerGoalHandle) -> _Search:
        """Return the search for a goal: a new one, or one under way for the same request."""
        asked = repr(goal.request)
        if self._newest is not None and self._newest.serves(asked):
            self._newest.goals.append(goal)
            return self._newest
        request = self._request(goal.request)
        job = BackgroundJob(partial(self._plan, request), 'planning', UNKNOWN)
        self._newest = _Search(asked, job, [goal])
        return self._newest

    async def _ended(self, search: _Search, goal: ServerGoalHandle) -> None:
        """Wait until a search has ended; tell a goal its progress."""
        done = Future()
        timer = self.create_timer(
            WATCH_PERIOD_S, partial(self._watch, search, goal, done), clock=self._wall_clock
        )
        await done
        self.destroy_timer(timer)

    def _plan(self, request: SurveyRequest, report: Callable[[Figures], bool]) -> SurveyPlan:
        """Plan, check and export; runs in the thread of the job."""
        plan = checked_plan(request, lambda *figures: report(figures))
        self._plans[plan.plan_id] = plan
        if plan.left_out:
            self.get_logger().warning(
                f'plan {plan.plan_id}: the batteries do not do for {len(plan.left_out)} viewpoints'
            )
        is_wanted = report((plan.makespan_s, plan.lower_bound_s))
        if self._options.export_directory and is_wanted:
            folder = self._options.export_folder(
                plan.plan_id, bool(request.continuation.viewpoints)
            )
            write_plan(plan, folder)
        return message_of_plan(plan)

    def _watch(self, search: _Search, goal: ServerGoalHandle, done: Future) -> None:
        """Report the progress of a goal; wake the goal when its search has ended."""
        if done.done():
            return
        if search.is_cancelled or search is not self._newest:
            search.job.cancel()
        goal.publish_feedback(feedback(search.job.elapsed_s, *search.job.progress))
        if search.job.is_done:
            done.set_result(None)

    def _refuse(
        self, goal: ServerGoalHandle, error: PlannerError | ValueError, *, is_replaced: bool
    ) -> PlanSurvey.Result:
        """Say why there is no plan: a search that was stopped may not have had one yet."""
        if goal.is_cancel_requested:
            goal.canceled()
            return result_of_stopped('cancelled')
        goal.abort()
        if is_replaced:
            return result_of_stopped('a newer goal took its place')
        self.get_logger().error(str(error))
        return result_of_error(error)


def main() -> int:
    """Run the planner until it is asked to stop."""
    return run(PlannerNode)


if __name__ == '__main__':
    raise SystemExit(main())
