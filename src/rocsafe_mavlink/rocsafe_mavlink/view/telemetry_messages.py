# SPDX-License-Identifier: Apache-2.0
"""Messages by which a vehicle shows itself to a ground station."""

import math
from collections.abc import Iterator

from rocsafe_mavlink.view.sight import Sight
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.units import e7_of_deg

# A quadrotor without an autopilot: stations expect it to take no commands.
QUADROTOR, GENERIC_AUTOPILOT, MAVLINK = 2, 0, 3
ARMED, CUSTOM_MODE = 128, 1
STANDBY, ACTIVE, EMERGENCY = 3, 4, 6
ON_GROUND, IN_AIR, TAKING_OFF, LANDING = 1, 2, 3, 4
FIX_3D = 3
UNKNOWN_16, UNKNOWN_PERCENT, NO_CELL = 0xFFFF, -1, 0xFFFF
AUTOPILOT = 1
# MAV_PROTOCOL_CAPABILITY: MISSION_INT and MAVLINK2, and no other.
CAPABILITIES = 4 | 8192
LARGEST_16, LARGEST_SPEED_MPS = 32_767, 327.0


def heartbeat(sight: Sight) -> Message:
    """Return the heartbeat: armed while it is in the air."""
    state = EMERGENCY if sight.is_crashed else ACTIVE if sight.is_airborne else STANDBY
    return _from(
        sight,
        'HEARTBEAT',
        type=QUADROTOR,
        autopilot=GENERIC_AUTOPILOT,
        base_mode=CUSTOM_MODE | (ARMED if sight.is_airborne else 0),
        system_status=state,
        mavlink_version=MAVLINK,
    )


def slow_messages(sight: Sight, time_ms: int) -> Iterator[Message]:
    """Yield what is sent once a second, the heartbeat first."""
    yield heartbeat(sight)
    landed = ON_GROUND
    if sight.is_airborne:
        landed = LANDING if sight.is_landing else TAKING_OFF if sight.is_climbing else IN_AIR
    yield _from(sight, 'EXTENDED_SYS_STATE', landed_state=landed)
    yield from _battery(sight)
    yield _from(sight, 'MISSION_CURRENT', seq=sight.current_item, total=len(sight.items))
    if sight.home is not None:
        yield _from(
            sight,
            'HOME_POSITION',
            latitude=e7_of_deg(sight.home.latitude_deg),
            longitude=e7_of_deg(sight.home.longitude_deg),
            altitude=_mm(sight.home.altitude_m),
            q=[1.0, 0.0, 0.0, 0.0],
            time_usec=time_ms * 1000,
        )


def fast_messages(sight: Sight, time_ms: int) -> Iterator[Message]:
    """Yield position and attitude; nothing before the first fix.

    The simulation has no geoid: the altitude above the sea is said to be that above the ellipsoid.
    """
    place = sight.position
    if place is None:
        return
    east, north, up = sight.velocity_enu
    latitude, longitude = e7_of_deg(place.latitude_deg), e7_of_deg(place.longitude_deg)
    altitude, heading = _mm(place.altitude_m), round(sight.heading_deg * 100.0) % 36_000
    yield _from(
        sight,
        'GLOBAL_POSITION_INT',
        time_boot_ms=time_ms,
        lat=latitude,
        lon=longitude,
        alt=altitude,
        relative_alt=_mm(sight.height_m),
        vx=_cmps(north),
        vy=_cmps(east),
        vz=_cmps(-up),
        hdg=heading,
    )
    yield _from(
        sight,
        'ATTITUDE',
        time_boot_ms=time_ms,
        yaw=math.remainder(math.radians(sight.heading_deg), 2.0 * math.pi),
    )
    yield _from(
        sight,
        'GPS_RAW_INT',
        time_usec=time_ms * 1000,
        fix_type=FIX_3D,
        lat=latitude,
        lon=longitude,
        alt=altitude,
        alt_ellipsoid=altitude,
        eph=UNKNOWN_16,
        epv=UNKNOWN_16,
        vel=_cmps(math.hypot(east, north)),
        cog=heading,
        satellites_visible=255,
    )
    yield _from(
        sight,
        'VFR_HUD',
        groundspeed=math.hypot(east, north),
        heading=round(sight.heading_deg) % 360,
        alt=place.altitude_m,
        climb=up,
    )


def autopilot_version(sight: Sight) -> Message:
    """Return who it is: nobody's hardware, with no capability but to be read."""
    return _from(sight, 'AUTOPILOT_VERSION', capabilities=CAPABILITIES, uid=sight.system)


def _battery(sight: Sight) -> Iterator[Message]:
    percent = UNKNOWN_PERCENT
    if math.isfinite(sight.battery_fraction):
        percent = round(100.0 * min(max(sight.battery_fraction, 0.0), 1.0))
    is_known = math.isfinite(sight.voltage_v)
    millivolts = min(round(1000.0 * sight.voltage_v), UNKNOWN_16 - 1) if is_known else UNKNOWN_16
    current = -1
    if math.isfinite(sight.current_a):
        current = min(round(100.0 * abs(sight.current_a)), LARGEST_16)
    yield _from(
        sight,
        'SYS_STATUS',
        voltage_battery=millivolts,
        current_battery=current,
        battery_remaining=percent,
    )
    yield _from(
        sight,
        'BATTERY_STATUS',
        temperature=LARGEST_16,
        voltages=[millivolts, *[NO_CELL] * 9],
        current_battery=current,
        current_consumed=-1,
        energy_consumed=-1,
        battery_remaining=percent,
    )


def _from(sight: Sight, name: str, **fields: object) -> Message:
    return Message(name, fields, sight.system, AUTOPILOT)


def _mm(length_m: float) -> int:
    return round(1000.0 * length_m)


def _cmps(speed_mps: float) -> int:
    return round(100.0 * min(max(speed_mps, -LARGEST_SPEED_MPS), LARGEST_SPEED_MPS))
