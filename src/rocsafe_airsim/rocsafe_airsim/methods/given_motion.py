# SPDX-License-Identifier: Apache-2.0
"""What the calls that move a vehicle give: places, speeds, durations, yaws."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.given import number, table
from rocsafe_airsim.ned import Vector, yaw_ned
from rocsafe_airsim.values import vector
from rocsafe_airsim.vehicle import (
    Turn,
    VehicleNow,
)
from rocsafe_geo.angle import wrap_rad

FORWARD_ONLY = 1


LONGEST_S = 3600.0


# Metres, or metres a second; no vehicle gets so far from home.
FARTHEST_M = 1e6


def vector_of(value: Any) -> Vector:
    """Return the numbers of a Vector3r."""
    given = table(value, 'a Vector3r')
    return possible([given.get(key) for key in vector((0.0, 0.0, 0.0))])


def possible(numbers: Sequence[Any]) -> Vector:
    """Return a place or velocity; raises `AirsimError` unless it is on this earth."""
    x, y, z = (number(each, 'a coordinate', is_finite=False) for each in numbers)
    if not max(abs(x), abs(y), abs(z)) <= FARTHEST_M or math.isnan(x + y + z):
        raise AirsimError(f'{x:g}, {y:g}, {z:g}: must be within {FARTHEST_M:g}')
    return x, y, z


def _asked_yaw(now: VehicleNow, goal: Vector, aim: Mapping[str, Any]) -> float | None:
    mode = table(aim.get('yaw_mode') or {}, 'yaw_mode')
    given = 0.0 if mode.get('is_rate', True) else mode.get('yaw_or_rate', 0.0)
    offset_deg = number(given, 'yaw_or_rate')
    if aim.get('drivetrain') == FORWARD_ONLY:
        east, north = goal[0] - now.true_enu[0], goal[1] - now.true_enu[1]
        if math.hypot(east, north) < 1.0:
            return None
        return wrap_rad(math.atan2(north, east) - math.radians(offset_deg))
    return None if mode.get('is_rate', True) else yaw_ned(math.radians(offset_deg))


def _turn(yaw_mode: Any) -> Turn:
    mode = table(yaw_mode or {}, 'yaw_mode')
    value = math.radians(number(mode.get('yaw_or_rate', 0.0), 'yaw_or_rate'))
    if mode.get('is_rate', True):
        return Turn(rate_radps=-value)
    return Turn(yaw_enu_rad=yaw_ned(value))


def _speed(value: Any) -> float:
    speed = number(value, 'velocity', is_finite=False)
    if not (math.isfinite(speed) and speed > 0.0):
        raise AirsimError(f'velocity is {speed:g} m/s: must be positive')
    return speed


def _duration(value: Any) -> float:
    seconds = number(value, 'duration', is_finite=False)
    if not 0.0 <= seconds <= LONGEST_S:
        raise AirsimError(f'duration is {seconds:g} s: must be within 0 and {LONGEST_S:g} s')
    return seconds
