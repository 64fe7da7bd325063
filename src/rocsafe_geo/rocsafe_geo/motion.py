# SPDX-License-Identifier: Apache-2.0
"""A leg flown from standstill to standstill: trapezoid of speed over time.

The vehicle accelerates uniformly, cruises, and brakes uniformly; a leg shorter than v^2/a never
reaches the cruise speed. Duration is d/v + v/a for d >= v^2/a, else 2 sqrt(d/a): concave and
increasing in d with value 0 at 0, hence a metric wherever d is one.
"""

from dataclasses import dataclass
from typing import overload

import numpy as np

from rocsafe_geo.limits import require_positive
from rocsafe_geo.projection import FloatArray


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """How fast a vehicle flies and how hard it speeds up and brakes; both above zero."""

    cruise_speed_mps: float
    acceleration_mps2: float

    def __post_init__(self) -> None:
        for name in ('cruise_speed_mps', 'acceleration_mps2'):
            object.__setattr__(self, name, require_positive(name, getattr(self, name)))


@overload
def leg_duration_s(distance_m: float, limits: MotionLimits) -> float: ...
@overload
def leg_duration_s(distance_m: FloatArray, limits: MotionLimits) -> FloatArray: ...
def leg_duration_s(distance_m: float | FloatArray, limits: MotionLimits) -> float | FloatArray:
    """Return the time of a leg of `distance_m` metres (scalar or array), in seconds.

    Raises
    ------
    ValueError
        If a distance is negative or NaN.
    """
    distance = _distances(distance_m)
    return _as_given(_duration(distance, _peak_speed(distance, limits), limits))


@overload
def leg_progress_m(elapsed_s: float, distance_m: float, limits: MotionLimits) -> float: ...
@overload
def leg_progress_m(
    elapsed_s: float | FloatArray, distance_m: float | FloatArray, limits: MotionLimits
) -> float | FloatArray: ...
def leg_progress_m(
    elapsed_s: float | FloatArray, distance_m: float | FloatArray, limits: MotionLimits
) -> float | FloatArray:
    """Return how far a leg has been flown `elapsed_s` seconds after its start, in metres.

    0 before the start, exactly `distance_m` from the leg's end on. Scalars or arrays that
    broadcast. Raises ValueError if a distance is negative or NaN.
    """
    distance = _distances(distance_m)
    peak = _peak_speed(distance, limits)
    duration = _duration(distance, peak, limits)
    elapsed = np.clip(elapsed_s, 0.0, duration)
    remaining = duration - elapsed
    ramp_s = peak / limits.acceleration_mps2
    half_a = 0.5 * limits.acceleration_mps2
    progress = np.where(elapsed < ramp_s, half_a * elapsed**2, peak * (elapsed - 0.5 * ramp_s))
    braking = distance - half_a * remaining**2
    return _as_given(np.where(remaining < ramp_s, braking, np.minimum(progress, distance)))


@overload
def leg_speed_mps(elapsed_s: float, distance_m: float, limits: MotionLimits) -> float: ...
@overload
def leg_speed_mps(
    elapsed_s: float | FloatArray, distance_m: float | FloatArray, limits: MotionLimits
) -> float | FloatArray: ...
def leg_speed_mps(
    elapsed_s: float | FloatArray, distance_m: float | FloatArray, limits: MotionLimits
) -> float | FloatArray:
    """Return the speed `elapsed_s` seconds after a leg's start, in m/s; 0 outside the leg.

    Scalars or arrays that broadcast. Raises ValueError if a distance is negative or NaN.
    """
    distance = _distances(distance_m)
    peak = _peak_speed(distance, limits)
    elapsed = np.asarray(elapsed_s, float)
    remaining = _duration(distance, peak, limits) - elapsed
    ramps = limits.acceleration_mps2 * np.minimum(elapsed, remaining)
    return _as_given(np.clip(ramps, 0.0, peak))


def _distances(distance_m: float | FloatArray) -> FloatArray:
    distance = np.asarray(distance_m, float)
    if not np.all(distance >= 0.0):
        worst = float(np.min(distance))
        raise ValueError(f'distance_m is {worst:g} m: must be 0 or above')
    return distance


def _peak_speed(distance: FloatArray, limits: MotionLimits) -> FloatArray:
    peak: FloatArray = np.minimum(
        limits.cruise_speed_mps, np.sqrt(distance * limits.acceleration_mps2)
    )
    return peak


def _duration(distance: FloatArray, peak: FloatArray, limits: MotionLimits) -> FloatArray:
    cruise = np.divide(distance, peak, out=np.zeros_like(distance), where=peak > 0.0)
    duration: FloatArray = cruise + peak / limits.acceleration_mps2
    return duration


def _as_given(values: FloatArray) -> float | FloatArray:
    """Return a float for a scalar result, the array else."""
    return float(values) if values.ndim == 0 else values
