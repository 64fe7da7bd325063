# SPDX-License-Identifier: Apache-2.0
"""The action fly_route of a simulated vehicle."""

from collections.abc import Callable

from rocsafe_interfaces.action import FlyRoute
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_sim.messages.conversions import refusal_message, result_message, route_of
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.vehicle_interface.route_goals_node import RouteGoals


class FlyRouteServer(RouteGoals):
    """Serves fly_route; `rav` is the vehicle, the other parameters are those of `RouteGoals`."""

    def __init__(
        self,
        node: VehicleScopeNode,
        rav: Rav,
        lease: LeaseServer,
        on_command: Callable[[], None],
    ) -> None:
        self._rav = rav
        super().__init__(node, calls.FLY_ROUTE, lease, on_command)

    def begin(self, request: FlyRoute.Goal) -> str:
        """Command the flight."""
        vehicle = self._rav.vehicle
        route = route_of(request.route, request.plan_id, self._rav.parts.frame)
        before = vehicle.flight
        vehicle.fly_route(route, replaces=request.replace)
        is_other = before is not None and before.route != route
        return f'plan {request.plan_id} is flown in its place' if is_other else ''

    def cancel(self) -> None:
        """Cancel the flight: the vehicle holds."""
        self._rav.vehicle.cancel()

    def result(self) -> FlyRoute.Result | None:
        """Return the result of the flight, None while it goes on."""
        summary = self._rav.vehicle.summary()
        has_camera = bool(self._rav.parts.cameras)
        return None if summary is None else result_message(summary, has_camera=has_camera)

    def failure(self, text: str, *, is_refusal: bool) -> FlyRoute.Result:
        """Return the result of a goal that never began, or was replaced."""
        if is_refusal:
            return refusal_message(text)
        return FlyRoute.Result(outcome=FlyRoute.Result.ABORTED, error_msg=text)

    def feedback(self) -> FlyRoute.Feedback:
        """Return how far the flight is."""
        flight = self._rav.vehicle.flight
        left_m, left_s = self._rav.vehicle.left()
        return FlyRoute.Feedback(
            viewpoint_index=0 if flight is None else flight.visited,
            viewpoint_count=0 if flight is None else len(flight.route.waypoints),
            distance_left_m=left_m,
            time_left_s=left_s,
        )
