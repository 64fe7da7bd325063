# SPDX-License-Identifier: Apache-2.0
"""Legs flown from standstill to standstill within limits of speed, acceleration and jerk.

A leg consists of a ramp up to its speed, a cruise, and the same ramp mirrored in time. In a ramp
the acceleration rises to its peak a, stays there, and falls. To rise it takes a/j + s, in which
the jerk itself rises to j within the smoothing time s, stays there, and falls. A ramp to speed v
takes v/a + a/j + s and covers half of v times that.

A short leg omits, in this order: the cruise, the time at full acceleration, the time at full jerk.
In the last case the rate of change k of the jerk is the only limit, and a leg of length d takes
8 (d / 8 k)^(1/4). Every case is solved in closed form, whole arrays at once. Duration is a concave
function of distance, 0 at 0: it is a metric wherever distance is one.
"""

from dataclasses import dataclass
from typing import overload

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.limits import MotionLimits

_ANY_SPEED_M = 1e12
"""A leg this long reaches any speed."""

LimitArrays = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""Speed, acceleration, jerk and smoothing of legs, arrays that broadcast."""


@dataclass(frozen=True, slots=True, eq=False)
class Legs:
    """Solved legs; arrays of one shape.

    Attributes
    ----------
    distance_m
        Length, as given.
    limit_mps
        Speed that a leg may reach.
    speed_mps, acceleration_mps2, jerk_mps3
        Largest speed, acceleration and jerk that a leg does reach.
    smoothing_s
        Time in which the jerk rises and falls.
    ramp_s
        Time of a ramp: for acceleration, and again for braking.
    duration_s
        Time from standstill to standstill.
    """

    distance_m: FloatArray
    limit_mps: FloatArray
    speed_mps: FloatArray
    acceleration_mps2: FloatArray
    jerk_mps3: FloatArray
    smoothing_s: FloatArray
    ramp_s: FloatArray
    duration_s: FloatArray


def limit_arrays(limits: MotionLimits) -> LimitArrays:
    """Return limits as arrays without dimensions."""
    return (
        np.asarray(limits.cruise_speed_mps),
        np.asarray(limits.acceleration_mps2),
        np.asarray(limits.jerk_mps3),
        np.asarray(limits.smoothing_s),
    )


def solve_legs(distance_m: FloatArray, limits: LimitArrays) -> Legs:
    """Return the solved legs of these distances.

    Raises
    ------
    ValueError
        If a distance is negative or NaN.
    """
    distance, speed, acceleration, jerk, smoothing = np.broadcast_arrays(
        _distances(distance_m), *limits
    )
    jerk, smoothing = _reachable(acceleration, jerk, smoothing)
    peak = np.minimum(speed, _peak_speed(distance, acceleration, jerk, smoothing))
    peak_acceleration, jerk, smoothing = _ramp(peak, acceleration, jerk, smoothing)
    ramp = _quotient(peak, peak_acceleration) + _quotient(peak_acceleration, jerk) + smoothing
    return Legs(
        distance_m=distance,
        limit_mps=speed,
        speed_mps=peak,
        acceleration_mps2=peak_acceleration,
        jerk_mps3=jerk,
        smoothing_s=smoothing,
        ramp_s=ramp,
        # A leg without cruise takes exactly two ramps, in spite of rounding.
        duration_s=ramp + np.maximum(ramp, _quotient(distance, peak)),
    )


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
    cruise = limits.cruise_speed_mps
    ramp = float(solve_legs(np.asarray(_ANY_SPEED_M), limit_arrays(limits)).ramp_s)
    duration = np.asarray(ramp + distance / cruise)
    # Most legs of a survey reach their speed, and need two operations.
    is_short = distance < cruise * ramp
    if np.any(is_short):
        short = solve_legs(distance[is_short], limit_arrays(limits)).duration_s
        duration[is_short] = short
    return as_given(duration)


def as_given(values: FloatArray) -> float | FloatArray:
    """Return a float for a result without dimensions, else the array."""
    return float(values) if values.ndim == 0 else values


def _distances(distance_m: float | FloatArray) -> FloatArray:
    distance = np.asarray(distance_m, float)
    if not np.all(distance >= 0.0):
        worst = float(np.min(distance))
        raise ValueError(f'distance_m is {worst:g} m: must be 0 or above')
    return distance


def _quotient(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a / b, 0 where b is 0."""
    quotient: FloatArray = np.divide(a, b, out=np.zeros(np.shape(a)), where=b > 0.0)
    return quotient


def _reachable(
    acceleration: FloatArray, jerk: FloatArray, smoothing: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return jerk and smoothing, reduced to what the rise to full acceleration can reach."""
    shorter = np.sqrt(acceleration * smoothing / jerk)
    is_short = shorter < smoothing
    return (
        np.where(is_short, _quotient(acceleration, shorter), jerk),
        np.where(is_short, shorter, smoothing),
    )


def _peak_speed(
    distance: FloatArray, acceleration: FloatArray, jerk: FloatArray, smoothing: FloatArray
) -> FloatArray:
    """Return the speed that a leg reaches if only its length limits it."""
    rise = acceleration / jerk + smoothing
    with_rest = 0.5 * acceleration * (np.sqrt(rise**2 + 4.0 * distance / acceleration) - rise)
    # b = a/j + s solves b^3 - s b^2 = d / 2j (Cardano, 1545)
    half = smoothing**3 / 27.0 + distance / (4.0 * jerk)
    root = np.sqrt(np.maximum(0.0, half**2 - smoothing**6 / 729.0))
    large = np.cbrt(half + root)
    b = large + _quotient(smoothing**2 / 9.0, large) + smoothing / 3.0
    without_rest = jerk * (b - smoothing) * b
    is_smooth = distance < 8.0 * jerk * smoothing**3
    brief = np.where(is_smooth, distance * smoothing / (8.0 * jerk), 0.0) ** 0.25
    brief_speed = 2.0 * brief**3 * _quotient(jerk, smoothing)
    peak: FloatArray = np.where(
        distance >= 2.0 * acceleration * rise**2,
        with_rest,
        np.where(is_smooth, brief_speed, without_rest),
    )
    return peak


def _ramp(
    speed: FloatArray, acceleration: FloatArray, jerk: FloatArray, smoothing: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return peak acceleration, peak jerk and smoothing of ramps to `speed`."""
    is_smooth = speed < 2.0 * jerk * smoothing**2
    brief = np.cbrt(np.where(is_smooth, speed * smoothing / (2.0 * jerk), 0.0))
    brief_jerk = brief * _quotient(jerk, smoothing)
    without_rest = 0.5 * jerk * (np.sqrt(smoothing**2 + 4.0 * speed / jerk) - smoothing)
    peak = np.where(is_smooth, brief * brief_jerk, np.minimum(acceleration, without_rest))
    return peak, np.where(is_smooth, brief_jerk, jerk), np.where(is_smooth, brief, smoothing)
