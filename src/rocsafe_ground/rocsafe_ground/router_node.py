# SPDX-License-Identifier: Apache-2.0
"""The router as a ROS node: `ros2 run rocsafe_ground router`."""

from collections.abc import Callable
from functools import partial
from itertools import count, takewhile
from pathlib import Path

from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node

from rocsafe_ground.conversions import (
    costs_message,
    evidence_message,
    path_message,
    request_of_goal,
    result_of_error,
    route_message,
)
from rocsafe_ground.drive.drive_plan import DrivePlan
from rocsafe_ground.drive.ground_map import GroundMap, MapReader
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.errors import GroundError
from rocsafe_ground.options import RouterOptions
from rocsafe_ground.products.files import ROUTE_FILE, write_drive
from rocsafe_interfaces.action import PlanGroundRoute
from rocsafe_interfaces.msg import EvidencePointArray, GroundRoute
from rocsafe_ros.background_job import BackgroundJob
from rocsafe_ros.goal_jobs_node import GoalJob, GoalJobs
from rocsafe_ros.interfaces.calls import PLAN_GROUND_ROUTE
from rocsafe_ros.interfaces.topics import (
    EVIDENCE,
    GROUND_COSTS,
    GROUND_PATH,
    GROUND_ROUTE,
    create_publisher,
)
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.process.run import run

# A drive, the map that it was planned on, and its number from 0.
Planned = tuple[DrivePlan, GroundMap, int]
Job = BackgroundJob[Planned, str]


class RouterNode(Node):
    """Plans drives of ground vehicles on request.

    Actions: `plan_ground_route`. Publishes (latched): `evidence`, `ground/route`, `ground/path`,
    `ground/costs`, of the newest route. Parameters: see `RouterOptions`. A goal is planned in a
    thread of its own.
    """

    def __init__(self, **kwargs: object) -> None:
        super().__init__('router', **kwargs)
        self._options = declare_options(self, RouterOptions)
        self._evidence = create_publisher(self, EVIDENCE)
        self._route = create_publisher(self, GROUND_ROUTE)
        self._path = create_publisher(self, GROUND_PATH)
        self._costs = create_publisher(self, GROUND_COSTS)
        # A router that is started again keeps the drives of the one before.
        self._numbers = count(_written(self._options.export_directory))
        self._reader = MapReader()
        self._jobs = GoalJobs(self, PLAN_GROUND_ROUTE, self._start, self._answer, _feedback)

    def destroy_node(self) -> None:
        """Take down the action server with the node."""
        self._jobs.destroy()
        super().destroy_node()

    def _answer(
        self, goal: ServerGoalHandle, job: GoalJob[Planned, str]
    ) -> PlanGroundRoute.Result:
        """End a goal whose job has ended; publish its route."""
        try:
            plan, ground, number = job.result()
        except (GroundError, ValueError, OSError) as error:
            goal.abort()
            self.get_logger().error(str(error))
            return result_of_error(error)
        if goal.is_cancel_requested:
            goal.canceled()
            return PlanGroundRoute.Result(
                error_code=PlanGroundRoute.Result.CANCELLED, error_msg='cancelled'
            )
        asked = goal.request
        route = route_message(plan, asked.vehicle, f'drive-{number + 1}')
        if goal is job.first:
            self._publish(plan, ground, route)
        goal.succeed()
        objects = plan.request.evidence[len(asked.evidence) :]
        return PlanGroundRoute.Result(route=route, objects=list(map(evidence_message, objects)))

    def _start(self, goal: ServerGoalHandle) -> Job:
        """Start to plan what a goal asks for."""
        return Job(partial(self._plan, goal.request), 'routing', 'map')

    def _plan(self, goal: PlanGroundRoute.Goal, report: Callable[[str], bool]) -> Planned:
        """Read the map and plan; runs in the thread of the job."""
        options = self._options
        request = request_of_goal(goal, options)
        ground = self._reader.read(
            options.files(goal.products),
            request.vehicle,
            options.cell_m,
            request.turn_back_usvh,
            request.turn_back_ppm,
        )
        report('routes')
        plan = plan_drive(request, ground)
        number = next(self._numbers)
        if options.export_directory:
            write_drive(_folder(options.export_directory, number), plan, ground)
        return plan, ground, number

    def _publish(self, plan: DrivePlan, ground: GroundMap, route: GroundRoute) -> None:
        """Publish a route."""
        stamp = self.get_clock().now().to_msg()
        evidence = EvidencePointArray(points=list(map(evidence_message, plan.request.evidence)))
        evidence.header.stamp = stamp
        self._evidence.publish(evidence)
        self._route.publish(route)
        self._path.publish(path_message(plan, stamp))
        self._costs.publish(costs_message(ground, stamp))
        self.get_logger().info(
            f'{route.route_id}: {plan.length_m:.0f} m, {plan.time_s:.0f} s, '
            f'{plan.forecast.mean_usv:.4g} uSv'
        )


def _folder(exports: str, number: int) -> Path:
    """Return where the drive of a number is written, the first in the folder of all."""
    return Path(exports, f'again-{number}') if number else Path(exports)


def _written(exports: str) -> int:
    """Return how many drives a folder has; none if there is no folder."""
    found = takewhile(lambda number: (_folder(exports, number) / ROUTE_FILE).exists(), count())
    return len(list(found)) if exports else 0


def _feedback(job: Job) -> PlanGroundRoute.Feedback:
    return PlanGroundRoute.Feedback(elapsed_s=job.elapsed_s, stage=job.progress)


def main() -> int:
    """Run the router until it is asked to stop."""
    return run(RouterNode)


if __name__ == '__main__':
    raise SystemExit(main())
