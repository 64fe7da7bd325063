# SPDX-License-Identifier: Apache-2.0
"""Fly one vehicle by its topics: take its lease, send it a route, watch it fly.

A vehicle must be there, for example a simulated one:

    ros2 run rocsafe_sim rav --ros-args -r __ns:=/rav1 -p lock_step:=false
    python examples/fly_vehicle.py rav1

A real vehicle has the same topics, but a route for it needs a confirmation: docs/real-drones.md.
"""

import sys
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.task import Future

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import GeoPoint, Route, Viewpoint
from rocsafe_interfaces.srv import Lease
from rocsafe_ros.interfaces import topics

HEIGHT_M = 20.0
# East and north of home of the places to photograph, metres.
PLACES_M = ((15.0, 0.0), (15.0, 15.0), (0.0, 15.0))
DEADLINE_S, FLIGHT_DEADLINE_S = 30.0, 600.0


class Pilot(Node):
    """A node that flies one vehicle."""

    def __init__(self, vehicle: str) -> None:
        super().__init__('pilot')
        self._vehicle = vehicle
        self._home = Future()
        # The table of topics knows type and quality of service of each name.
        topics.create_subscription(self, topics.HOME, self._on_home, vehicle)
        self._lease = self.create_client(Lease, f'{vehicle}/lease')
        self._fly_route = ActionClient(self, FlyRoute, f'{vehicle}/fly_route')

    def _on_home(self, home: GeoPoint) -> None:
        if not self._home.done():
            self._home.set_result(home)

    def fly(self) -> FlyRoute.Result:
        """Fly to the places and back; every wait has a deadline."""
        home = self._wait(self._home, DEADLINE_S)
        if not self._lease.wait_for_service(DEADLINE_S):
            raise TimeoutError(f'{self._vehicle} does not answer')
        request = Lease.Request(holder='example', duration_s=FLIGHT_DEADLINE_S)
        leased = self._wait(self._lease.call_async(request), DEADLINE_S)
        if not leased.success:
            raise PermissionError(leased.message)
        goal = FlyRoute.Goal(
            route=route_from(self._vehicle, home), plan_id='example', lease=leased.control.lease
        )
        if not self._fly_route.wait_for_server(DEADLINE_S):
            raise TimeoutError(f'{self._vehicle} takes no routes')
        sent = self._fly_route.send_goal_async(goal, feedback_callback=self._on_feedback)
        handle = self._wait(sent, DEADLINE_S)
        return self._wait(handle.get_result_async(), FLIGHT_DEADLINE_S).result

    def _on_feedback(self, message: Any) -> None:
        flown = message.feedback
        self.get_logger().info(
            f'to {flown.viewpoint_index} of {flown.viewpoint_count}, '
            f'{flown.time_left_s:.0f} s to touch-down'
        )

    def _wait(self, future: Future, deadline_s: float) -> Any:
        rclpy.spin_until_future_complete(self, future, timeout_sec=deadline_s)
        if not future.done():
            raise TimeoutError(f'{self._vehicle} has not answered in {deadline_s:.0f} s')
        return future.result()


def route_from(vehicle: str, home: GeoPoint) -> Route:
    """Return the route over the places, about a home."""
    frame = LocalFrame(GeoPosition(home.latitude, home.longitude, home.altitude))
    viewpoints = []
    for number, (east, north) in enumerate(PLACES_M):
        place = frame.position_of((east, north, HEIGHT_M))
        point = GeoPoint(
            latitude=place.latitude_deg, longitude=place.longitude_deg, altitude=place.altitude_m
        )
        viewpoints.append(Viewpoint(id=number, position=point, height_agl_m=HEIGHT_M))
    return Route(vehicle=vehicle, home=home, viewpoints=viewpoints, flight_height_m=HEIGHT_M)


def main(vehicle: str = 'rav1') -> FlyRoute.Result:
    """Fly the vehicle and print how it went."""
    rclpy.init()
    try:
        result = Pilot(vehicle).fly()
    finally:
        rclpy.shutdown()
    print(
        f'{result.error_msg or "completed"}: {result.shots_taken} photographs, '
        f'{result.distance_flown_m:.0f} m, {result.duration_s:.0f} s'
    )
    return result


if __name__ == '__main__':
    main(*sys.argv[1:])
