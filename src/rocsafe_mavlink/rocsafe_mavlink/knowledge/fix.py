# SPDX-License-Identifier: Apache-2.0
"""Check that a position is usable: messages continue long after the receiver lost its fix."""

import math

from rocsafe_mavlink.knowledge.telemetry import FIX_3D, EkfFlag, VehicleTelemetry

# A receiver whose time stands still this long has stopped, seconds.
FROZEN_AFTER_S = 1.0
# An older position is not the current one.
OLD_AFTER_S = 1.0
LARGEST_SPEED_MPS = 60.0
LARGEST_SEPARATION_M = 110.0
# Smaller differences are none: simulators copy one altitude into the other.
SMALLEST_SEPARATION_M = 0.001


def fix_fault(vehicle: VehicleTelemetry, now_s: float, old_after_s: float = OLD_AFTER_S) -> str:
    """Return why the position of `vehicle` cannot be used at `now_s`; empty if it can.

    Parameters
    ----------
    vehicle
        The vehicle as it is known now.
    now_s
        Steady time.
    old_after_s
        An older position, or one whose receiver stands still so long, is not the current one.
    """
    gps, motion = vehicle.gps, vehicle.motion
    if motion is None or now_s - motion.heard_s > old_after_s:
        return 'no position comes'
    if gps.fix_type < FIX_3D:
        return f'the receiver has no fix (type {gps.fix_type})'
    if now_s - gps.changed_s > max(FROZEN_AFTER_S, old_after_s):
        return "the receiver's time stands still"
    if vehicle.ekf_flags is None:
        return 'the position estimate has not been heard of'
    if not vehicle.ekf_flags & EkfFlag.ABSOLUTE_HORIZONTAL_POSITION:
        return 'the autopilot does not use the receiver'
    if motion.position.latitude_deg == 0.0 and motion.position.longitude_deg == 0.0:
        return 'the position is the zero of the map'
    if now_s - vehicle.jumped_s < OLD_AFTER_S:
        return 'the position jumped'
    return ''


def separation_m(altitude_m: float, ellipsoid_m: float, given_m: float) -> float:
    """Return the height of the geoid above the ellipsoid, metres; NaN if it is not known.

    Parameters
    ----------
    altitude_m
        Above mean sea level, by the receiver.
    ellipsoid_m
        Above the ellipsoid, by the receiver; 0 if it does not tell.
    given_m
        From the drones file; NaN if none was given.
    """
    measured = ellipsoid_m - altitude_m
    is_told = ellipsoid_m != 0.0 and abs(measured) > SMALLEST_SEPARATION_M
    if is_told and abs(measured) <= LARGEST_SEPARATION_M:
        return measured
    return given_m if math.isfinite(given_m) else math.nan
