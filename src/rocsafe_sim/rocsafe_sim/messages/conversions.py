# SPDX-License-Identifier: Apache-2.0
"""Conversions between values of the simulated vehicles and messages."""

import math
from itertools import accumulate

from builtin_interfaces.msg import Time
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.battery import VOLTAGE_V, PowerModel
from rocsafe_geo.motion.state import Enu
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import GeoPoint, GeoPolygon, VehicleState, Viewpoint
from rocsafe_interfaces.msg import Route as RouteMessage
from rocsafe_interfaces.srv import PushFence
from rocsafe_ros.conversions import enu_of_point
from rocsafe_sim.flight.fence import Fence
from rocsafe_sim.flight.route import BatterySwap, FlightRoute, RouteWaypoint
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.flight_record import FlightOutcome, FlightRecord
from rocsafe_sim.vehicle.snapshot import FlightSummary, VehicleSnapshot

STATES = {
    Mode.DISARMED: VehicleState.DISARMED,
    Mode.WAITING: VehicleState.WAITING,
    Mode.TAKING_OFF: VehicleState.TAKING_OFF,
    Mode.FLYING: VehicleState.FLYING,
    Mode.HOLDING: VehicleState.HOLDING,
    Mode.RETURNING: VehicleState.RETURNING,
    Mode.LANDING: VehicleState.LANDING,
    Mode.LANDED: VehicleState.LANDED,
    Mode.FALLING: VehicleState.CRASHED,
    Mode.CRASHED: VehicleState.CRASHED,
}
OUTCOMES = {
    FlightOutcome.COMPLETED: FlyRoute.Result.COMPLETED,
    FlightOutcome.CANCELLED: FlyRoute.Result.CANCELLED,
    FlightOutcome.RETURNED_EARLY: FlyRoute.Result.RETURNED_EARLY,
    FlightOutcome.BATTERY_LOW: FlyRoute.Result.BATTERY_LOW,
    FlightOutcome.FAILED: FlyRoute.Result.ABORTED,
    FlightOutcome.COLLIDED: FlyRoute.Result.COLLISION,
}
_UNKNOWN = math.nan


def route_of(message: RouteMessage, plan_id: str, frame: LocalFrame) -> FlightRoute:
    """Return the route of a message.

    Over level ground home is at height 0 of the frame; otherwise heights are differences of
    altitude.

    Raises
    ------
    ValueError
        If a position is invalid, or a viewpoint is not above the ground.
    """
    places = _Places(frame, is_level=not message.follows_terrain)
    flights = message.flights[:-1]
    return FlightRoute(
        plan_id=plan_id,
        home_enu=places.ground(message.home),
        waypoints=tuple(_waypoint(viewpoint, places) for viewpoint in message.viewpoints),
        homeward_enu=places.all(message.homeward),
        exclusions=tuple(places.outline(zone) for zone in message.exclusions),
        clearance_m=message.clearance_m,
        delay_s=message.delay_s,
        swaps=tuple(
            BatterySwap(after=after, homeward_enu=places.all(flight.homeward))
            for flight, after in zip(
                flights, accumulate(len(flight.viewpoints) for flight in flights), strict=True
            )
        ),
        swap_s=message.battery_swap_s,
        landing_enu=places.ground(message.end[0]) if message.end else None,
        is_open=message.is_open,
        height_m=message.flight_height_m if message.follows_terrain else 0.0,
    )


def _waypoint(viewpoint: Viewpoint, places: '_Places') -> RouteWaypoint:
    waypoint = RouteWaypoint(
        viewpoint_id=viewpoint.id,
        position_enu=places.place(viewpoint.position),
        yaw_rad=viewpoint.yaw_rad,
        approach_enu=places.all(viewpoint.approach),
    )
    up_m = waypoint.position_enu[2] if places.is_level else viewpoint.height_agl_m
    if not up_m > 0.0:
        raise ValueError(
            f'viewpoint {viewpoint.id} is {up_m:g} m above the ground: must be above 0'
        )
    return waypoint


def ending_of(flight: FlightRecord) -> int:
    """Return the outcome that a flight has or will have, as in FlyRoute."""
    return int(OUTCOMES[flight.outcome or flight.ending])


def fence_of(request: PushFence.Request, frame: LocalFrame) -> Fence:
    """Return the fence of a message; raises `ValueError` if a polygon is invalid."""
    places = _Places(frame, is_level=True)
    return Fence(
        inclusions=tuple(map(places.outline, request.inclusions)),
        exclusions=tuple(map(places.outline, request.exclusions)),
    )


def places_of(points: list[GeoPoint], frame: LocalFrame) -> tuple[Enu, ...]:
    """Return places of messages; raises `ValueError` if one is invalid."""
    return _Places(frame, is_level=True).all(points)


def waiting_text(number: int, waits_s: float) -> str:
    """Return the reason why a vehicle waits before flight `number`; empty if it does not wait."""
    if math.isinf(waits_s):
        return 'held on the ground, until it is resumed'
    if waits_s <= 0.0:
        return ''
    why = 'gets a new battery' if number else 'keeps away from others'
    return f'{why}: takes off in {waits_s:.0f} s'


def battery_message(
    snapshot: VehicleSnapshot, power: PowerModel, stamp: Time, frame_id: str
) -> BatteryState:
    """Return charge and current; fields that are not simulated are NaN."""
    airborne = snapshot.mode.is_airborne
    capacity_ah = power.capacity_ah
    return BatteryState(
        header=Header(stamp=stamp, frame_id=frame_id),
        voltage=VOLTAGE_V,
        temperature=_UNKNOWN,
        # REP 147 and sensor_msgs: negative while it discharges
        current=-snapshot.power_w / VOLTAGE_V,
        charge=capacity_ah * snapshot.battery_fraction,
        capacity=capacity_ah,
        design_capacity=capacity_ah,
        percentage=snapshot.battery_fraction,
        power_supply_status=(
            BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
            if airborne
            else BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING
        ),
        power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_GOOD,
        power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_LIPO,
        present=True,
    )


def result_message(summary: FlightSummary, *, has_camera: bool) -> FlyRoute.Result:
    """Return the result of a flight that has ended; a camera took one photograph a viewpoint."""
    is_complete = summary.outcome is FlightOutcome.COMPLETED
    return FlyRoute.Result(
        outcome=OUTCOMES[summary.outcome],
        error_msg='' if is_complete else f'{summary.outcome.value}: {summary.text}',
        viewpoints_visited=summary.viewpoints_visited,
        shots_taken=summary.viewpoints_visited if has_camera else 0,
        distance_flown_m=summary.distance_flown_m,
        duration_s=summary.duration_s,
    )


def refusal_message(reason: str) -> FlyRoute.Result:
    """Return the result of a refused route."""
    return FlyRoute.Result(outcome=FlyRoute.Result.REJECTED, error_msg=reason)


class _Places:
    """Places of messages in a local frame."""

    def __init__(self, frame: LocalFrame, *, is_level: bool) -> None:
        self._frame = frame
        self.is_level = is_level

    def place(self, point: GeoPoint) -> Enu:
        """Return a place in the air."""
        east, north, up = enu_of_point(point, self._frame)
        return east, north, up if self.is_level else point.altitude - self._frame.origin.altitude_m

    def ground(self, point: GeoPoint) -> Enu:
        """Return a place on the ground."""
        east, north, up = self.place(point)
        return east, north, 0.0 if self.is_level else up

    def all(self, points: list[GeoPoint]) -> tuple[Enu, ...]:
        """Return places in the air."""
        return tuple(self.place(point) for point in points)

    def outline(self, zone: GeoPolygon) -> tuple[tuple[float, float], ...]:
        """Return the corners of a zone, east and north."""
        return tuple((east, north) for east, north, _ in self.all(zone.points))
