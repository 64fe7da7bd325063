# SPDX-License-Identifier: Apache-2.0
"""The node ``mavlink_view``: shows simulated vehicles to a MAVLink ground station."""

import os
from functools import partial
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_interfaces.msg import SurveyPlan, VehicleState
from rocsafe_mavlink import view_conversions
from rocsafe_mavlink.errors import EndpointError
from rocsafe_mavlink.view.station_view import StationView
from rocsafe_mavlink.view_options import ViewOptions
from rocsafe_ros.interfaces import topics
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run

STATE_TYPE = 'rocsafe_interfaces/msg/VehicleState'
# Variables by which a user sets how far ROS looks.
REACH = (
    'ROCSAFE_INTERFACES', 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_STATIC_PEERS',
    'ROS_DISCOVERY_SERVER', 'ROS_LOCALHOST_ONLY',
)  # fmt: skip
LOOK_PERIOD_S, ANSWER_PERIOD_S, SHOW_PERIOD_S = 1.0, 0.02, 0.2
# Every so many fast messages, the slow ones are sent, too.
SLOW_EVERY = 5


class ViewNode(Node):
    """Shows every simulated vehicle of the ROS domain, and obeys nobody.

    Subscribes for each vehicle: ``state``, ``fix``, ``odom``, ``battery_state``, ``home``; once:
    ``plan``. It publishes nothing and calls nothing: what a station asks for cannot reach a
    vehicle. A real vehicle has a link of its own and is left out.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('mavlink_view', **node_options)
        options = declare_options(self, ViewOptions)
        try:
            self._view = StationView(options.address)
        except EndpointError as error:
            raise ParameterError(str(error)) from error
        self._known: set[str] = set()
        self._plan: SurveyPlan | None = None
        self._shown = 0
        topics.create_subscription(self, topics.PLAN, self._on_plan)
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._start_ns = self._steady.now().nanoseconds
        for period_s, callback in (
            (LOOK_PERIOD_S, self._look),
            (ANSWER_PERIOD_S, self._answer),
            (SHOW_PERIOD_S, self._show),
        ):
            self.create_timer(period_s, callback, clock=self._steady)

    def destroy_node(self) -> None:
        """Close the link."""
        self._view.close()
        super().destroy_node()

    def _look(self) -> None:
        """Listen to vehicles that are new in the domain."""
        for full, types in self.get_topic_names_and_types():
            name = full.strip('/').removesuffix('/state')
            if STATE_TYPE in types and '/' not in name and name not in self._known:
                self._known.add(name)
                on_state = partial(self._on_state, name)
                topics.create_subscription(self, topics.STATE, on_state, name)

    def _on_state(self, name: str, message: VehicleState) -> None:
        if not message.is_simulated:
            return
        if name not in self._view.sights:
            self._begin(name)
        view_conversions.see_state(self._view.sights[name], message)

    def _begin(self, name: str) -> None:
        """Show a vehicle that has said that it is simulated."""
        sight = self._view.add(name)
        self.get_logger().info(f'{name} is shown as system {sight.system}')
        for spec, see in (
            (topics.FIX, view_conversions.see_fix),
            (topics.ODOM, view_conversions.see_motion),
            (topics.BATTERY_STATE, view_conversions.see_battery),
            (topics.HOME, view_conversions.see_home),
        ):
            topics.create_subscription(self, spec, partial(see, sight), name)
        if self._plan is not None:
            view_conversions.see_plan(sight, name, self._plan)

    def _on_plan(self, message: SurveyPlan) -> None:
        self._plan = message
        for name, sight in self._view.sights.items():
            view_conversions.see_plan(sight, name, message)

    def _answer(self) -> None:
        self._view.answer(self._steady.now().nanoseconds / NS_PER_S)

    def _show(self) -> None:
        time_ms = (self._steady.now().nanoseconds - self._start_ns) * 1000 // NS_PER_S
        self._view.show(time_ms, is_slow=self._shown % SLOW_EVERY == 0)
        self._shown += 1


def main() -> int:
    """Run the node until it is asked to stop; it looks on this machine unless told otherwise."""
    if not any(os.environ.get(name) for name in REACH):
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    return run(ViewNode)


if __name__ == '__main__':
    raise SystemExit(main())
