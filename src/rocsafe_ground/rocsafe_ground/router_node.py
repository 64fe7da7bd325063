# SPDX-License-Identifier: Apache-2.0
"""The router as a ROS node: `ros2 run rocsafe_ground router`."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future

from rocsafe_ground.conversions import (
    costs_message,
    path_message,
    request_of_goal,
    result_of_error,
    route_message,
)
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveRequest
from rocsafe_ground.drive.ground_map import GroundMap, MapReader
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.errors import GroundError
from rocsafe_ground.options import RouterOptions
from rocsafe_ground.products.files import write_drive
from rocsafe_interfaces.action import PlanGroundRoute
from rocsafe_interfaces.msg import EvidencePointArray, GroundRoute
from rocsafe_ros.background_job import BackgroundJob
from rocsafe_ros.calls import PLAN_GROUND_ROUTE
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.run import run
from rocsafe_ros.topics import (
    EVIDENCE,
    GROUND_COSTS,
    GROUND_PATH,
    GROUND_ROUTE,
    create_publisher,
)

# How often a running job is looked at, on the wall clock: simulated time may stand still.
WATCH_PERIOD_S = 0.1

Planned = tuple[DrivePlan, GroundMap]
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
        self._wall_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._count = 0
        self._reader = MapReader()
        self._server = ActionServer(
            self,
            PlanGroundRoute,
            PLAN_GROUND_ROUTE.name,
            execute_callback=self._execute,
            cancel_callback=lambda _goal: CancelResponse.ACCEPT,
        )

    def destroy_node(self) -> None:
        """Take down the action server with the node."""
        self._server.destroy()
        super().destroy_node()

    async def _execute(self, goal: ServerGoalHandle) -> PlanGroundRoute.Result:
        """Plan in a thread, wait for it without blocking, publish the route."""
        try:
            request = request_of_goal(goal.request, self._options)
            job = Job(partial(self._plan, request, goal.request.products), 'routing', 'map')
            await self._ended(job, goal)
            plan, ground = job.result()
        except (GroundError, ValueError, OSError) as error:
            goal.abort()
            self.get_logger().error(str(error))
            return result_of_error(error)
        if goal.is_cancel_requested:
            goal.canceled()
            return PlanGroundRoute.Result(
                error_code=PlanGroundRoute.Result.CANCELLED, error_msg='cancelled'
            )
        result = PlanGroundRoute.Result(route=self._published(goal.request, plan, ground))
        goal.succeed()
        return result

    async def _ended(self, job: Job, goal: ServerGoalHandle) -> None:
        """Wait until a job has ended; tell its stage."""
        done = Future()
        timer = self.create_timer(
            WATCH_PERIOD_S, partial(_watch, job, goal, done), clock=self._wall_clock
        )
        await done
        self.destroy_timer(timer)

    def _plan(self, request: DriveRequest, folder: str, report: Callable[[str], bool]) -> Planned:
        """Read the map and plan; runs in the thread of the job."""
        options = self._options
        ground = self._reader.read(
            options.files(folder), request.vehicle, options.cell_m, request.turn_back_usvh
        )
        report('routes')
        plan = plan_drive(request, ground)
        if options.export_directory:
            first = Path(options.export_directory)
            write_drive(first / f'again-{self._count}' if self._count else first, plan, ground)
        return plan, ground

    def _published(
        self, goal: PlanGroundRoute.Goal, plan: DrivePlan, ground: GroundMap
    ) -> GroundRoute:
        """Publish a route and return its message."""
        stamp = self.get_clock().now().to_msg()
        self._count += 1
        route = route_message(plan, goal.vehicle, f'drive-{self._count}')
        evidence = EvidencePointArray(points=goal.evidence)
        evidence.header.stamp = stamp
        self._evidence.publish(evidence)
        self._route.publish(route)
        self._path.publish(path_message(plan, stamp))
        self._costs.publish(costs_message(ground, stamp))
        self.get_logger().info(
            f'{route.route_id}: {plan.length_m:.0f} m, {plan.time_s:.0f} s, '
            f'{plan.forecast.mean_usv:.4g} uSv'
        )
        return route


def _watch(job: Job, goal: ServerGoalHandle, done: Future) -> None:
    """Report the progress of a goal; wake the goal when its job has ended."""
    if done.done():
        return
    goal.publish_feedback(PlanGroundRoute.Feedback(elapsed_s=job.elapsed_s, stage=job.progress))
    if job.is_done:
        done.set_result(None)


def main() -> int:
    """Run the router until it is asked to stop."""
    return run(RouterNode)


if __name__ == '__main__':
    raise SystemExit(main())
