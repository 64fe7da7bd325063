# SPDX-License-Identifier: Apache-2.0
"""The planner as a ROS node: `ros2 run rocsafe_planner planner`."""

from collections.abc import Callable
from functools import partial

from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node

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
from rocsafe_ros.goal_jobs_node import GoalJob, GoalJobs
from rocsafe_ros.interfaces.calls import PLAN_SURVEY
from rocsafe_ros.interfaces.topics import PLAN, create_publisher
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.process.run import run

Search = GoalJob[SurveyPlan, Figures]


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
        # While the other nodes start: the first goal need not wait for it.
        BackgroundJob(_load_solver, 'loading', None)
        self._searches = GoalJobs(
            self, PLAN_SURVEY, self._start, self._answer, _feedback, replaces=True
        )

    def destroy_node(self) -> None:
        """Take down the action server with the node."""
        self._searches.destroy()
        super().destroy_node()

    def _answer(self, goal: ServerGoalHandle, search: Search) -> PlanSurvey.Result:
        """End a goal whose search has ended; publish its plan."""
        try:
            message = search.result()
        except (PlannerError, ValueError) as error:
            return self._refuse(goal, error, is_replaced=search.is_replaced)
        message.header.stamp = self.get_clock().now().to_msg()
        if goal.is_cancel_requested:
            goal.canceled()
            return result_of_stopped('cancelled', message)
        if search.is_replaced:
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

    def _start(self, goal: ServerGoalHandle) -> BackgroundJob[SurveyPlan, Figures]:
        """Start the search for what a goal asks for."""
        request = self._request(goal.request)
        return BackgroundJob(partial(self._plan, request), 'planning', UNKNOWN)

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


def _feedback(job: BackgroundJob[SurveyPlan, Figures]) -> PlanSurvey.Feedback:
    return feedback(job.elapsed_s, *job.progress)


def main() -> int:
    """Run the planner until it is asked to stop."""
    return run(PlannerNode)


if __name__ == '__main__':
    raise SystemExit(main())
