# SPDX-License-Identifier: Apache-2.0
"""The action drive_route of a real ground vehicle."""

from typing import Any

from rocsafe_interfaces.action import DriveRoute
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.flight_record import FlightSummary
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.vehicle_interface.drive_conversions import (
    drive_assignment,
    drive_failure,
    drive_result,
)
from rocsafe_mavlink.vehicle_interface.route_goals_node import RouteGoals
from rocsafe_ros.conversions import point_of_position
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.server_node import LeaseServer


class DriveRouteServer(RouteGoals):
    """Serves drive_route; the parameters are those of `RouteGoals`."""

    def __init__(self, node: VehicleScopeNode, drone: Drone, lease: LeaseServer) -> None:
        super().__init__(node, calls.DRIVE_ROUTE, drone, lease)

    def assignment(self, request: DriveRoute.Goal) -> Assignment:
        """Return the plan of the drive."""
        return drive_assignment(request.route, self._drone.spec)

    def result(self, goal: Any, summary: FlightSummary) -> DriveRoute.Result:
        """Return the result of a drive that has ended."""
        return self._located(drive_result(summary, goal.request.route))

    def failure(self, goal: Any, text: str, outcome: str) -> DriveRoute.Result:
        """Return the result of a goal before the end of its drive."""
        visited = 0 if outcome == 'REJECTED' else self._drone.remaining().visited
        return self._located(drive_failure(goal.request.route, text, outcome, visited))

    def feedback(self) -> DriveRoute.Feedback:
        """Return how far the drive is."""
        left = self._drone.remaining()
        return DriveRoute.Feedback(
            stop_index=left.visited,
            stop_count=left.count,
            distance_left_m=left.distance_m,
            time_left_s=left.time_s,
        )

    def _located(self, result: DriveRoute.Result) -> DriveRoute.Result:
        motion = self._drone.vehicle.motion
        if motion is not None:
            result.position = point_of_position(motion.position)
        return result
