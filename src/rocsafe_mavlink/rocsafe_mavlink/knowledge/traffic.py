# SPDX-License-Identifier: Apache-2.0
"""Other aircraft that the receiver of a vehicle reports (ADS-B), and close encounters."""

import math
from dataclasses import dataclass, replace

from rocsafe_geo.position import GeoPosition, level_offset_m
from rocsafe_mavlink.knowledge.telemetry import Aircraft, Motion, VehicleTelemetry
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.units import deg_of_e7, m_of_mm

# ADSB_FLAGS.
COORDINATES, ALTITUDE, HEADING, VELOCITY, CALLSIGN = 1, 2, 4, 8, 16
PRESSURE = 0
# Aircraft kept at most; the nearest in time are heard again.
LARGEST_COUNT = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class TrafficLimits:
    """When another aircraft is close: the "well clear" of small unmanned aircraft (ASTM F3442).

    Attributes
    ----------
    level_m, height_m
        Closer than both is close: 2000 ft and 250 ft.
    pressure_m
        More height for aircraft that tell a pressure altitude: by weather it differs so much from
        the height above the sea.
    ahead_s
        The time that is looked ahead: so long both fly on as they do.
    old_s
        An aircraft that was not heard for so long is not looked at.
    """

    level_m: float = 610.0
    height_m: float = 76.0
    pressure_m: float = 150.0
    ahead_s: float = 60.0
    old_s: float = 15.0


TRAFFIC_LIMITS = TrafficLimits()


@dataclass(frozen=True, slots=True, kw_only=True)
class Encounter:
    """An aircraft as seen from a vehicle.

    Attributes
    ----------
    aircraft
        The aircraft.
    distance_m, above_m
        Level distance, and height above the vehicle; NaN if not known.
    closest_m, closest_in_s
        Level distance where it is nearest within the time looked ahead, and when.
    is_close
        Whether it is, or comes, too close.
    """

    aircraft: Aircraft
    distance_m: float
    above_m: float
    closest_m: float
    closest_in_s: float
    is_close: bool

    @property
    def text(self) -> str:
        """The warning for people."""
        name = self.aircraft.callsign or f'{self.aircraft.icao:06X}'
        above = 'height not known' if math.isnan(self.above_m) else f'{self.above_m:+.0f} m high'
        nearest = f'{self.closest_m:.0f} m in {self.closest_in_s:.0f} s'
        return f'aircraft {name} at {self.distance_m:.0f} m, {above}, nearest {nearest}'


def with_aircraft(vehicle: VehicleTelemetry, message: Message, now_s: float) -> VehicleTelemetry:
    """Return what is known after an ADSB_VEHICLE; one without a place changes nothing."""
    flags = int(message['flags'])
    if not flags & COORDINATES:
        return vehicle
    speed_mps, course_rad = message['hor_velocity'] / 100.0, message['heading'] / 100.0
    course_rad = math.radians(course_rad)
    is_moving = bool(flags & VELOCITY and flags & HEADING)
    level = (speed_mps * math.sin(course_rad), speed_mps * math.cos(course_rad))
    aircraft = Aircraft(
        icao=int(message['ICAO_address']),
        callsign=str(message['callsign']).strip() if flags & CALLSIGN else '',
        position=GeoPosition(deg_of_e7(message['lat']), deg_of_e7(message['lon'])),
        altitude_msl_m=m_of_mm(message['altitude']) if flags & ALTITUDE else math.nan,
        is_pressure=message['altitude_type'] == PRESSURE,
        velocity_enu_mps=(*level, message['ver_velocity'] / 100.0) if is_moving else None,
        heard_s=now_s - float(message['tslc']),
    )
    others = tuple(one for one in vehicle.traffic if one.icao != aircraft.icao)
    return replace(vehicle, traffic=(*others, aircraft)[-LARGEST_COUNT:])


def encounter(aircraft: Aircraft, motion: Motion, now_s: float) -> Encounter:
    """Return an aircraft as seen from a vehicle at `now_s`: both are taken to fly straight on."""
    age_s = now_s - aircraft.heard_s
    theirs = aircraft.velocity_enu_mps or (0.0, 0.0, 0.0)
    heard_east_m, heard_north_m = level_offset_m(motion.position, aircraft.position)
    east_m, north_m = heard_east_m + age_s * theirs[0], heard_north_m + age_s * theirs[1]
    ours = motion.velocity_enu_mps
    east_mps, north_mps = theirs[0] - ours[0], theirs[1] - ours[1]
    square = east_mps**2 + north_mps**2
    meeting_s = -(east_m * east_mps + north_m * north_mps) / square if square else 0.0
    in_s = min(max(meeting_s, 0.0), TRAFFIC_LIMITS.ahead_s)
    closest_m = math.hypot(east_m + in_s * east_mps, north_m + in_s * north_mps)
    above_m = aircraft.altitude_msl_m - motion.altitude_msl_m
    allowed_m = TRAFFIC_LIMITS.height_m + (
        TRAFFIC_LIMITS.pressure_m if aircraft.is_pressure else 0.0
    )
    # A climb or descent within the time looked ahead counts from the start of that time.
    drift_m = in_s * (theirs[2] - ours[2])
    heights_m = (above_m, above_m + drift_m)
    is_level = math.isnan(above_m) or (
        min(map(abs, heights_m)) < allowed_m or heights_m[0] * heights_m[1] < 0.0
    )
    return Encounter(
        aircraft=aircraft,
        distance_m=math.hypot(east_m, north_m),
        above_m=above_m,
        closest_m=closest_m,
        closest_in_s=in_s,
        is_close=closest_m < TRAFFIC_LIMITS.level_m and is_level,
    )


def encounters(vehicle: VehicleTelemetry, now_s: float) -> tuple[Encounter, ...]:
    """Return all aircraft that were heard lately, the nearest to come first."""
    if vehicle.motion is None:
        return ()
    seen = [
        encounter(aircraft, vehicle.motion, now_s)
        for aircraft in vehicle.traffic
        if now_s - aircraft.heard_s <= TRAFFIC_LIMITS.old_s
    ]
    return tuple(sorted(seen, key=lambda one: one.closest_m))
