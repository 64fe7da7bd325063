# SPDX-License-Identifier: Apache-2.0
"""The action drive_route of a simulated ground vehicle."""

from collections.abc import Callable

from rocsafe_interfaces.action import DriveRoute
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_sim.driving.rgv import Rgv
from rocsafe_sim.messages.drive_conversions import (
    drive_feedback,
    drive_refusal,
    drive_result,
    drive_route_of,
)
from rocsafe_sim.vehicle_interface.route_goals_node import RouteGoals


class DriveRouteServer(RouteGoals):
    """Serves drive_route; `rgv` is the vehicle, the other parameters are those of `RouteGoals`."""

    def __init__(
        self,
        node: VehicleScopeNode,
        rgv: Rgv,
        lease: LeaseServer,
        on_command: Callable[[], None],
    ) -> None:
        self._rgv = rgv
        super().__init__(node, calls.DRIVE_ROUTE, lease, on_command)

    def begin(self, request: DriveRoute.Goal) -> str:
        """Command the drive."""
        rover = self._rgv.rover
        route = drive_route_of(request.route, self._rgv.frame)
        before = None if rover.is_over else rover.state.route
        rover.drive(route, replaces=request.replace)
        is_other = before is not None and before.route_id != route.route_id
        return f'route {route.route_id} is driven in its place' if is_other else ''

    def cancel(self) -> None:
        """Cancel the drive."""
        self._rgv.rover.cancel()

    def result(self) -> DriveRoute.Result | None:
        """Return the result of the drive when the vehicle stands, None before."""
        rover = self._rgv.rover
        return drive_result(self._rgv) if rover.is_over and rover.is_idle else None

    def failure(self, text: str, *, is_refusal: bool) -> DriveRoute.Result:
        """Return the result of a goal that never began, or was replaced."""
        if is_refusal:
            return drive_refusal(text)
        return DriveRoute.Result(outcome=DriveRoute.Result.ABORTED, error_msg=text)

    def feedback(self) -> DriveRoute.Feedback:
        """Return how far the drive is."""
        return drive_feedback(self._rgv)
