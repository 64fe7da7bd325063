# SPDX-License-Identifier: Apache-2.0
"""The action drive_route of a simulated ground vehicle."""

from collections.abc import Callable
from typing import Any

from rclpy.action import ActionServer, CancelResponse

from rocsafe_interfaces.action import DriveRoute
from rocsafe_ros import topics
from rocsafe_ros.control_lease import LeaseRefusedError
from rocsafe_ros.lease_server_node import LeaseServer
from rocsafe_ros.vehicle_scope import VehicleScopeNode
from rocsafe_sim.clock.cadence import Cadence
from rocsafe_sim.driving.rgv import Rgv
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.messages.drive_conversions import (
    drive_feedback,
    drive_refusal,
    drive_result,
    drive_route_of,
)

FEEDBACK_PERIOD_NS = 1_000_000_000


class DriveRouteServer:
    """Serves drive_route. Several goals of one route join one drive and end with it.

    A goal is executed, in the terms of rclpy, when its drive has ended, as of `FlyRouteServer`.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    rgv
        The vehicle.
    lease
        Judges who may send goals.
    on_command
        Called after the vehicle got a command.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        rgv: Rgv,
        lease: LeaseServer,
        on_command: Callable[[], None],
    ) -> None:
        self._node, self._rgv, self._lease = node, rgv, lease
        self._on_command = on_command
        self._has_time = False
        self._feedbacks = Cadence(FEEDBACK_PERIOD_NS)
        self._early: list[Any] = []
        self._driving: list[Any] = []
        self._results: dict[bytes, DriveRoute.Result] = {}
        self._server = ActionServer(
            node,
            DriveRoute,
            topics.DRIVE_ROUTE.name,
            execute_callback=self._result,
            handle_accepted_callback=self._on_goal,
            cancel_callback=self._on_cancel,
        )

    def after_step(self, time_ns: int) -> None:
        """Begin accepted goals, publish feedback, and end the goals of an ended drive."""
        self._has_time = True
        while self._early:
            self._on_goal(self._early.pop(0))
        self.end_goals()
        if self._feedbacks.is_due(time_ns) and self._driving:
            feedback = drive_feedback(self._rgv)
            for goal in self._driving:
                goal.publish_feedback(feedback)

    def end_goals(self) -> None:
        """End the goals if the drive has ended and the vehicle stands."""
        if self._rgv.rover.is_over and self._rgv.rover.is_idle:
            ended, self._driving = self._driving, []
            for goal in ended:
                self._end(goal, drive_result(self._rgv))

    def _on_goal(self, goal: Any) -> None:
        if self._lease.is_for_another(goal.request.lease):
            return  # that node executes it
        if not self._has_time:
            self._early.append(goal)
            return
        refusal = self._begin(goal.request)
        if refusal is not None:
            self._end(goal, refusal)
            return
        self._driving.append(goal)
        self.end_goals()

    def _begin(self, request: DriveRoute.Goal) -> DriveRoute.Result | None:
        """Command the drive; return the reason if it is refused."""
        name, rover = self._rgv.name, self._rgv.rover
        if request.route.vehicle not in ('', name):
            return drive_refusal(f'{name}: the route is for {request.route.vehicle}')
        try:
            self._lease.require(request.lease)
            route = drive_route_of(request.route, self._rgv.frame)
            replaced = None if rover.is_over or rover.state.route is None else rover.state.route
            rover.drive(route, replaces=request.replace)
        except (LeaseRefusedError, CommandRefusedError, ValueError) as error:
            return drive_refusal(f'{name}: {error}')
        if replaced is not None and replaced.route_id != route.route_id:
            text = f'route {route.route_id} is driven in its place'
            ended, self._driving = self._driving, []
            for goal in ended:
                aborted = DriveRoute.Result(outcome=DriveRoute.Result.ABORTED, error_msg=text)
                self._end(goal, aborted)
        self._on_command()
        return None

    def _end(self, goal: Any, result: DriveRoute.Result) -> None:
        self._results[bytes(goal.goal_id.uuid)] = result
        goal.execute()

    def _result(self, goal: Any) -> DriveRoute.Result:
        result = self._results.pop(bytes(goal.goal_id.uuid))
        if goal.is_cancel_requested:
            goal.canceled()
        elif result.outcome == DriveRoute.Result.COMPLETED:
            goal.succeed()
        else:
            goal.abort()
        return result

    def _on_cancel(self, _goal: Any) -> CancelResponse:
        self._rgv.rover.cancel()
        self._on_command()
        # rclpy marks the goal as being cancelled only after this callback.
        self._node.executor.create_task(self.end_goals)
        return CancelResponse.ACCEPT
