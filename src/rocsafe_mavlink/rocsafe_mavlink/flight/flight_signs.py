# SPDX-License-Identifier: Apache-2.0
"""Signs of trouble in the telemetry of a flight: a failsafe, a home that was moved."""

import math

from rocsafe_geo.position import distance_m
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.knowledge.telemetry import EkfFlag, Home, SystemStatus, VehicleTelemetry

HOME_MOVED_M, HOME_ROSE_M = 10.0, 3.0
# MISSION_CURRENT tells this number of items where there is no mission.
NO_MISSION = 65_535
# A ground vehicle that came back on its own tracks stands within the error of its receiver.
AT_HOME_M, STANDS_MPS = 5.0, 0.2


def shown_failsafe(vehicle: VehicleTelemetry) -> FlightOutcome | None:
    """Return the failsafe that telemetry shows in the air, though its text was lost."""
    if vehicle.is_fence_breached:
        return FlightOutcome.FAILSAFE_FENCE
    flags = vehicle.ekf_flags
    has_place = flags is None or flags & EkfFlag.ABSOLUTE_HORIZONTAL_POSITION
    is_failing = vehicle.status == SystemStatus.CRITICAL and vehicle.is_armed
    return FlightOutcome.FAILSAFE_GPS if is_failing and not has_place else None


def home_moved(planned: Home, now: Home | None, when: str = 'at arming') -> str:
    """Return how far home moved, if it is more than the plan allows; empty otherwise."""
    if now is None:
        return 'home is not known after arming'
    level_m = distance_m(planned.place, now.place)
    rise_m = abs(now.altitude_msl_m - planned.altitude_msl_m)
    if level_m <= HOME_MOVED_M and rise_m <= HOME_ROSE_M:
        return ''
    limits = f'at most {HOME_MOVED_M:g} m and {HOME_ROSE_M:g} m'
    return f'home moved {level_m:.1f} m and {rise_m:.1f} m in height {when}: {limits} allowed'


def mission_changed(count: int, vehicle: VehicleTelemetry) -> str:
    """Return that a vehicle tells another number of mission items than `count`; empty: it agrees.

    `count` leaves out home, as the vehicle's own number does.
    """
    told = vehicle.mission.total
    if told in (0, count):
        return ''
    items = 'no items' if told == NO_MISSION else f'{told} items'
    return f'its mission has {items}, sent were {count}: another station has changed it'


def is_at_home(vehicle: VehicleTelemetry) -> bool:
    """Return whether a ground vehicle stands where it began."""
    motion, home = vehicle.motion, vehicle.home
    if motion is None or home is None:
        return False
    return stands(vehicle) and distance_m(home.place, motion.position) < AT_HOME_M


def stands(vehicle: VehicleTelemetry) -> bool:
    """Return whether a ground vehicle tells that it does not move."""
    motion = vehicle.motion
    return motion is not None and math.hypot(*motion.velocity_enu_mps[:2]) < STANDS_MPS


def heights_moved(begun: Home | None, now: Home | None) -> str:
    """Return why heights above home are not those of a flight that was begun; empty: they are.

    An autopilot flies heights above its home of the moment, which every station may set anew.
    """
    if begun is None or now is None:
        return ''
    rise_m = now.altitude_msl_m - begun.altitude_msl_m
    if abs(rise_m) <= HOME_ROSE_M:
        return ''
    return (
        f'its home was set {abs(rise_m):.0f} m {"higher" if rise_m > 0 else "lower"} in flight, '
        'and with it all heights: set it back, or let it return or land'
    )
