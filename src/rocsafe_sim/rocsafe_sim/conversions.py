# SPDX-License-Identifier: Apache-2.0
"""Values of the simulated vehicles <-> messages."""

import math

from builtin_interfaces.msg import Time
from sensor_msgs.msg import BatteryState
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
from rocsafe_sim.segment import Mode

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
