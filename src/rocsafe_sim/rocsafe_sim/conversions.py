# SPDX-License-Identifier: Apache-2.0
"""Values of the simulated vehicles <-> messages."""

import math

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Quaternion, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, NavSatFix, NavSatStatus
from std_msgs.msg import Header

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.battery import PowerModel
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import GeoPoint, GeoPolygon, VehicleState
from rocsafe_interfaces.msg import Route as RouteMessage
from rocsafe_ros.conversions import position_of_point
from rocsafe_sim.flight_record import Outcome
from rocsafe_sim.observation import FlightSummary, Observation
from rocsafe_sim.route import Enu, Route, Waypoint
from rocsafe_sim.segment import Mode, Pose
from rocsafe_sim.sensing_noise import SensorNoise

MAP_FRAME = 'map'
STATES = {
    Mode.DISARMED: VehicleState.DISARMED,
    Mode.TAKING_OFF: VehicleState.TAKING_OFF,
    Mode.FLYING: VehicleState.FLYING,
    Mode.HOLDING: VehicleState.HOLDING,
    Mode.RETURNING: VehicleState.RETURNING,
    Mode.LANDING: VehicleState.LANDING,
    Mode.LANDED: VehicleState.LANDED,
}
OUTCOMES = {
    Outcome.COMPLETED: FlyRoute.Result.COMPLETED,
    Outcome.CANCELLED: FlyRoute.Result.CANCELLED,
    Outcome.RETURNED_EARLY: FlyRoute.Result.RETURNED_EARLY,
    Outcome.BATTERY_LOW: FlyRoute.Result.BATTERY_LOW,
}
# Of a fix without error: ROS takes 0 for "unknown" in some readers.
_LEAST_VARIANCE_M2 = 1e-12
_UNKNOWN = math.nan


def route_of(message: RouteMessage, plan_id: str, frame: LocalFrame) -> Route:
    """Return the route of a message.

    Raises
    ------
    ValueError: if it has no viewpoint or a position that is none.
    """
    home = position_of_point(message.home)
    east, north, _ = frame.enu_of(home).tolist()
    return Route(
        plan_id=plan_id,
        home_enu=(east, north, 0.0),
        waypoints=tuple(
            Waypoint(
                viewpoint_id=viewpoint.id,
                position_enu=_enu(frame, position_of_point(viewpoint.position)),
                yaw_rad=viewpoint.yaw_rad,
                approach_enu=_places(frame, viewpoint.approach),
            )
            for viewpoint in message.viewpoints
        ),
        homeward_enu=_places(frame, message.homeward),
        exclusions=tuple(_outline(frame, zone) for zone in message.exclusions),
        clearance_m=message.clearance_m,
    )


def fix_message(
    position: GeoPosition, stamp: Time, frame_id: str, noise: SensorNoise | None
) -> NavSatFix:
    """Return a fix with the covariance of `noise`; None: the exact truth."""
    horizontal = noise.gps_horizontal_std_m**2 if noise else 0.0
    vertical = noise.gps_vertical_std_m**2 if noise else 0.0
    h, v = max(horizontal, _LEAST_VARIANCE_M2), max(vertical, _LEAST_VARIANCE_M2)
    return NavSatFix(
        header=Header(stamp=stamp, frame_id=frame_id),
        status=NavSatStatus(status=NavSatStatus.STATUS_FIX, service=NavSatStatus.SERVICE_GPS),
        latitude=position.latitude_deg,
        longitude=position.longitude_deg,
        altitude=position.altitude_m,
        position_covariance=[h, 0.0, 0.0, 0.0, h, 0.0, 0.0, 0.0, v],
        position_covariance_type=NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN,
    )


def velocity_message(pose: Pose, stamp: Time, frame_id: str = MAP_FRAME) -> TwistStamped:
    """Return the velocity over ground: east, north, up."""
    message = TwistStamped(header=Header(stamp=stamp, frame_id=frame_id))
    linear = message.twist.linear
    linear.x, linear.y, linear.z = pose.velocity_enu
    return message


def odometry_message(pose: Pose, measured_enu: Enu, stamp: Time, vehicle: str) -> Odometry:
    """Return the measured position in the mission's frame; the twist is in the body's frame."""
    message = Odometry(
        header=Header(stamp=stamp, frame_id=MAP_FRAME), child_frame_id=f'{vehicle}/base_link'
    )
    position = message.pose.pose.position
    position.x, position.y, position.z = measured_enu
    message.pose.pose.orientation = yaw_quaternion(pose.yaw_rad)
    east, north, up = pose.velocity_enu
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    linear = message.twist.twist.linear
    linear.x, linear.y, linear.z = cos * east + sin * north, cos * north - sin * east, up
    return message


def yaw_quaternion(yaw_rad: float) -> Quaternion:
    """Return the attitude of a level vehicle."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(0.5 * yaw_rad), w=math.cos(0.5 * yaw_rad))


def path_pose(position_enu: Enu, stamp: Time) -> PoseStamped:
    """Return one point of the flown track."""
    message = PoseStamped(header=Header(stamp=stamp, frame_id=MAP_FRAME))
    position = message.pose.position
    position.x, position.y, position.z = position_enu
    message.pose.orientation.w = 1.0
    return message


def battery_message(
    observation: Observation, power: PowerModel, stamp: Time, frame_id: str
) -> BatteryState:
    """Return charge left and current; what is not simulated is NaN."""
    airborne = observation.mode.is_airborne
    capacity_ah = power.capacity_ah
    return BatteryState(
        header=Header(stamp=stamp, frame_id=frame_id),
        voltage=power.voltage_v,
        temperature=_UNKNOWN,
        # REP 147 and sensor_msgs: negative while it discharges
        current=-observation.power_w / power.voltage_v,
        charge=capacity_ah * observation.battery_fraction,
        capacity=capacity_ah,
        design_capacity=capacity_ah,
        percentage=observation.battery_fraction,
        power_supply_status=(
            BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
            if airborne
            else BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING
        ),
        power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_GOOD,
        power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_LIPO,
        present=True,
    )


def result_message(summary: FlightSummary) -> FlyRoute.Result:
    """Return the result of a flight that has ended."""
    is_complete = summary.outcome is Outcome.COMPLETED
    return FlyRoute.Result(
        outcome=OUTCOMES[summary.outcome],
        error_msg='' if is_complete else f'{summary.outcome.value}: {summary.text}',
        viewpoints_visited=summary.viewpoints_visited,
        shots_taken=summary.viewpoints_visited,
        distance_flown_m=summary.distance_flown_m,
        duration_s=summary.duration_s,
    )


def refusal_message(reason: str) -> FlyRoute.Result:
    """Return the result of a route that is not flown."""
    return FlyRoute.Result(outcome=FlyRoute.Result.REJECTED, error_msg=reason)


def _outline(frame: LocalFrame, zone: GeoPolygon) -> tuple[tuple[float, float], ...]:
    """Return the corners of a zone, east and north."""
    corners = [_enu(frame, position_of_point(point)) for point in zone.points]
    return tuple((east, north) for east, north, _ in corners)


def _places(frame: LocalFrame, points: list[GeoPoint]) -> tuple[Enu, ...]:
    return tuple(_enu(frame, position_of_point(point)) for point in points)


def _enu(frame: LocalFrame, position: GeoPosition) -> Enu:
    east, north, up = frame.enu_of(position).tolist()
    return east, north, up
