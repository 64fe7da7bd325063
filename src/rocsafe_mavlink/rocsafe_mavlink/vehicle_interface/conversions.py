# SPDX-License-Identifier: Apache-2.0
"""Values of real vehicles <-> messages."""

import math
from dataclasses import replace

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3
from sensor_msgs.msg import BatteryState, NavSatFix, NavSatStatus
from std_msgs.msg import Header

from rocsafe_geo.angle import heading_of_yaw_rad
from rocsafe_geo.limits import require_between
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import LONGEST_WAIT_S
from rocsafe_interfaces.msg import (
    GeoPoint,
    GeoPolygon,
    PreflightCheck,
    Traffic,
    VehicleEvent,
    VehicleState,
    Viewpoint,
)
from rocsafe_interfaces.msg import Route as RouteMessage
from rocsafe_mavlink.autopilots.autopilot import FlightState
from rocsafe_mavlink.checks.check import Check, CheckVerdict
from rocsafe_mavlink.drone.drone import DroneSpec
from rocsafe_mavlink.drone.status import DroneStatus
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.knowledge.events import Event
from rocsafe_mavlink.knowledge.telemetry import Contact, Motion
from rocsafe_mavlink.knowledge.traffic import Encounter
from rocsafe_mavlink.plan.fence import Ring
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint
from rocsafe_mavlink.vehicle_interface.result_conversions import OUTCOMES
from rocsafe_ros.conversions import diagnostic, point_of_position, position_of_point

STATES = {
    FlightState.UNKNOWN: VehicleState.UNKNOWN,
    FlightState.DISARMED: VehicleState.DISARMED,
    FlightState.ARMED: VehicleState.ARMED,
    FlightState.TAKING_OFF: VehicleState.TAKING_OFF,
    FlightState.FLYING: VehicleState.FLYING,
    FlightState.HOLDING: VehicleState.HOLDING,
    FlightState.RETURNING: VehicleState.RETURNING,
    FlightState.LANDING: VehicleState.LANDING,
    FlightState.LANDED: VehicleState.LANDED,
    FlightState.LOST: VehicleState.LOST,
    FlightState.WAITING: VehicleState.WAITING,
}
_VERDICTS = {
    CheckVerdict.PASS: PreflightCheck.PASS,
    CheckVerdict.WARN: PreflightCheck.WARN,
    CheckVerdict.FAIL: PreflightCheck.FAIL,
}
# MAV_SEVERITY: 0 to 3 are errors, 4 a warning, 5 and 6 notes.
_SEVERITIES = (VehicleEvent.ERROR,) * 4 + (VehicleEvent.WARN,) + (VehicleEvent.INFO,) * 2
# Quantities that no autopilot reports.
_UNKNOWN = math.nan


def assignment_of(message: RouteMessage, plan_id: str, spec: DroneSpec) -> Assignment:
    """Return the plan in a route message.

    Raises
    ------
    ValueError
        Naming what cannot be flown.
    """
    home = position_of_point(message.home)
    _require_plain(message)
    waypoints: list[FlightWaypoint] = []
    for viewpoint in message.viewpoints:
        waypoints += _waypoints(viewpoint, home, spec.hover_s)
    last = waypoints[-1] if waypoints else _over_home(home, message.flight_height_m)
    waypoints += [_bend(point, last) for point in message.homeward]
    if not message.viewpoints:
        waypoints.append(last)
    plan = FlightPlan(
        waypoints=tuple(waypoints),
        speed_mps=spec.speed_mps,
        takes_photographs=spec.takes_photographs,
        trigger_distance_m=spec.trigger_distance_m,
        home=GeoPosition(home.latitude_deg, home.longitude_deg, 0.0),
        exclusions=tuple(tuple(map(_level, ring_of(zone))) for zone in message.exclusions),
        clearance_m=message.clearance_m,
    )
    ids = tuple(int(viewpoint.id) for viewpoint in message.viewpoints)
    return Assignment(plan_id=plan_id, plan=plan, viewpoint_ids=ids)


def delay_of(message: RouteMessage) -> float:
    """Return the time to wait before a route is begun, seconds.

    Raises
    ------
    ValueError
        If it is no time that a mission waits: without it the route would be begun at once.
    """
    return require_between('delay_s', message.delay_s, 0.0, LONGEST_WAIT_S, 's')


def _over_home(home: GeoPosition, height_m: float) -> FlightWaypoint:
    """Return where a vehicle that is called home comes to, before it returns and lands."""
    return FlightWaypoint(position=_level(home), height_m=height_m, is_bend=True)


def _require_plain(message: RouteMessage) -> None:
    """Refuse what real vehicles do not fly: several flights, another end."""
    if len(message.flights) > 1:
        count = len(message.flights)
        raise ValueError(f'the route has {count} flights: must be 1, batteries are not changed')
    if message.end or message.is_open:
        raise ValueError('the route ends elsewhere: must end at home')


def _waypoints(viewpoint: Viewpoint, home: GeoPosition, hover_s: float) -> list[FlightWaypoint]:
    """Return the bends before a viewpoint, and the viewpoint."""
    place = position_of_point(viewpoint.position)
    # Both altitudes have the same datum, so their difference needs none.
    height_m = place.altitude_m - home.altitude_m
    if not math.isfinite(height_m):
        height_m = viewpoint.height_agl_m
    stop = FlightWaypoint(
        position=_level(place),
        height_m=height_m,
        hold_s=hover_s,
        heading_deg=math.degrees(heading_of_yaw_rad(viewpoint.yaw_rad)) % 360.0,
        height_agl_m=viewpoint.height_agl_m if viewpoint.height_agl_m > 0.0 else None,
    )
    return [*(_bend(point, stop) for point in viewpoint.approach), stop]


def _bend(point: GeoPoint, stop: FlightWaypoint) -> FlightWaypoint:
    """Return a bend of the way to or from `stop`, with the same height and heading."""
    place = _level(position_of_point(point))
    return replace(stop, position=place, hold_s=0.0, is_bend=True)


def _level(place: GeoPosition) -> GeoPosition:
    return GeoPosition(place.latitude_deg, place.longitude_deg, 0.0)


def ring_of(polygon: GeoPolygon) -> Ring:
    """Return the corners of a polygon, the first not repeated at its end."""
    places = tuple(position_of_point(point) for point in polygon.points)
    return places[:-1] if len(places) > 1 and places[0] == places[-1] else places


def predicted_message(seen: DroneStatus, stamp: Time, frame_id: str) -> NavSatFix | None:
    """Return the expected position of a silent vehicle; None while it is heard."""
    if seen.prediction is None:
        return None
    place, variance = seen.prediction.position, seen.prediction.spread_m**2
    return NavSatFix(
        header=Header(stamp=stamp, frame_id=frame_id),
        status=NavSatStatus(status=NavSatStatus.STATUS_NO_FIX, service=NavSatStatus.SERVICE_GPS),
        latitude=place.latitude_deg,
        longitude=place.longitude_deg,
        altitude=place.altitude_m,
        position_covariance=[variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance],
        position_covariance_type=NavSatFix.COVARIANCE_TYPE_APPROXIMATED,
    )


def battery_message(seen: DroneStatus, stamp: Time, frame_id: str) -> BatteryState:
    """Return the charge; NaN where the autopilot does not tell. Discharging is negative."""
    return BatteryState(
        header=Header(stamp=stamp, frame_id=frame_id),
        voltage=seen.voltage_v,
        current=-seen.current_a,
        percentage=seen.charge,
        temperature=_UNKNOWN,
        charge=_UNKNOWN,
        capacity=_UNKNOWN,
        design_capacity=_UNKNOWN,
        power_supply_status=(
            BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
            if seen.is_armed
            else BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING
        ),
        power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_UNKNOWN,
        power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN,
        present=True,
    )


def state_message(
    seen: DroneStatus, vehicle: str, stamp: Time, shots: tuple[int, int]
) -> VehicleState:
    """Return the state; `shots` are the numbers taken and not yet stored."""
    return VehicleState(
        header=Header(stamp=stamp, frame_id=f'{vehicle}/base_link'),
        vehicle=vehicle,
        state=STATES[seen.state],
        is_simulated=False,
        plan_id=seen.plan_id,
        viewpoint_count=seen.viewpoint_count,
        viewpoints_visited=seen.visited,
        shots_taken=shots[0],
        shots_pending=shots[1],
        battery_fraction=seen.charge,
        distance_flown_m=seen.distance_m,
        text=seen.text,
        advice=seen.advice,
        position=_point(seen.motion),
        speed_mps=_speed_mps(seen.motion),
        ending=0 if seen.ending is None else OUTCOMES[seen.ending],
        taken_by=seen.taken_by,
    )


def _point(motion: Motion | None) -> GeoPoint:
    if motion is None:
        return GeoPoint(latitude=math.nan, longitude=math.nan, altitude=math.nan)
    return point_of_position(motion.position)


def _speed_mps(motion: Motion | None) -> float:
    return math.nan if motion is None else math.hypot(*motion.velocity_enu_mps[:2])


def event_message(event: Event, vehicle: str, stamp: Time) -> VehicleEvent:
    """Return an event."""
    severity = _SEVERITIES[event.severity] if event.severity < 7 else VehicleEvent.DEBUG
    return VehicleEvent(
        header=Header(stamp=stamp, frame_id=f'{vehicle}/base_link'),
        vehicle=vehicle,
        severity=severity,
        kind=event.kind.value,
        text=event.text,
    )


def traffic_message(seen: Encounter, vehicle: str, stamp: Time, separation_m: float) -> Traffic:
    """Return another aircraft; `separation_m` is the height of the geoid, NaN if not known."""
    aircraft = seen.aircraft
    east, north, up = aircraft.velocity_enu_mps or (math.nan,) * 3
    place = aircraft.position
    return Traffic(
        header=Header(stamp=stamp, frame_id=f'{vehicle}/base_link'),
        vehicle=vehicle,
        icao=aircraft.icao,
        callsign=aircraft.callsign,
        position=GeoPoint(
            latitude=place.latitude_deg,
            longitude=place.longitude_deg,
            altitude=aircraft.altitude_msl_m + separation_m,
        ),
        velocity=Vector3(x=east, y=north, z=up),
        distance_m=seen.distance_m,
        above_m=seen.above_m,
        closest_m=seen.closest_m,
        closest_in_s=seen.closest_in_s,
        is_close=seen.is_close,
    )


def check_message(check: Check) -> PreflightCheck:
    """Return one check before a flight."""
    return PreflightCheck(
        name=check.name, verdict=_VERDICTS[check.verdict], value=check.value, limit=check.limit
    )


def link_status(
    name: str, contacts: dict[str, Contact], counts: dict[str, int], fault: str = ''
) -> DiagnosticStatus:
    """Return the health of a link: who is heard, how much was dropped and why, its fault."""
    silent = [f'{who}: {how.value}' for who, how in contacts.items() if how is not Contact.FRESH]
    wrong = [*silent, *filter(None, [fault])]
    text = ', '.join(wrong) or 'all are heard'
    return diagnostic(text, name=f'bridge: {name}', is_warning=bool(wrong), values=counts)
