# SPDX-License-Identifier: Apache-2.0
"""ROCSAFE messages of a vehicle -> what a ground station is shown of it."""

import math

from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, NavSatFix

from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.msg import GeoPoint, SurveyPlan, VehicleState
from rocsafe_mavlink.view.sight import Sight, mission_of
from rocsafe_ros.conversions import has_position, position_of_point, quaternion_values

AIRBORNE = frozenset(
    {
        VehicleState.TAKING_OFF,
        VehicleState.FLYING,
        VehicleState.HOLDING,
        VehicleState.RETURNING,
        VehicleState.LANDING,
    }
)


def see_state(sight: Sight, message: VehicleState) -> None:
    """Take what a vehicle does."""
    sight.is_airborne = message.state in AIRBORNE
    sight.is_climbing = message.state == VehicleState.TAKING_OFF
    sight.is_landing = message.state == VehicleState.LANDING
    sight.is_crashed = message.state == VehicleState.CRASHED
    sight.reached = int(message.viewpoints_visited)
    sight.battery_fraction = float(message.battery_fraction)


def see_fix(sight: Sight, message: NavSatFix) -> None:
    """Take where it is."""
    if has_position(message):
        sight.position = GeoPosition(message.latitude, message.longitude, message.altitude)


def see_motion(sight: Sight, message: Odometry) -> None:
    """Take its yaw; its velocity, which odometry tells in the frame of the body, in ENU."""
    x, y, z, w = quaternion_values(message.pose.pose.orientation)
    sight.yaw_rad = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    ahead, left = message.twist.twist.linear.x, message.twist.twist.linear.y
    cosine, sine = math.cos(sight.yaw_rad), math.sin(sight.yaw_rad)
    sight.velocity_enu = (
        cosine * ahead - sine * left,
        sine * ahead + cosine * left,
        message.twist.twist.linear.z,
    )


def see_battery(sight: Sight, message: BatteryState) -> None:
    """Take voltage and current."""
    sight.voltage_v, sight.current_a = float(message.voltage), float(message.current)


def see_home(sight: Sight, message: GeoPoint) -> None:
    """Take where it returns."""
    sight.home = position_of_point(message)


def see_plan(sight: Sight, name: str, message: SurveyPlan) -> None:
    """Take its route of a plan; a plan without one leaves it without a mission."""
    sight.items = ()
    for route in message.routes:
        if route.vehicle == name:
            places = tuple(position_of_point(each.position) for each in route.viewpoints)
            sight.items = mission_of(places, position_of_point(route.home))
