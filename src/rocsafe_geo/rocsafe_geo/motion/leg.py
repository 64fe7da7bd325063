# SPDX-License-Identifier: Apache-2.0
"""Legs flown from standstill to standstill within limits of speed, acceleration and jerk.

A leg speeds up, cruises, and brakes as it sped up. While it speeds up, the acceleration rises to
its peak a with a jerk that itself rises to j within the smoothing time s and falls again (in
a/j + s altogether), rests there, and falls as it rose. A ramp to speed v takes v/a + a/j + s and
covers half of v times that. What a leg is too short for it leaves out, in this order: the cruise,
the rest at full acceleration, the rest at full jerk. In the last case, with the jerk's own rate of
change k as only limit, a leg of length d takes 8 (d / 8 k)^(1/4). Every case is solved in closed
form, whole arrays at once. Duration grows with distance, ever more slowly, from 0 at 0: it is a
metric wherever distance is one.
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
    """Legs as they are flown; arrays of one shape.

    Attributes
    ----------
    distance_m : given.
    limit_mps : speed that they may reach.
    speed_mps, acceleration_mps2, jerk_mps3 : that they do reach.
    smoothing_s : in which the jerk rises and falls.
    ramp_s : for speeding up, and again for braking.
    duration_s : from standstill to standstill.
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
    """Return limits as arrays of no dimension."""
    return (
        np.asarray(limits.cruise_speed_mps),
        np.asarray(limits.acceleration_mps2),
        np.asarray(limits.jerk_mps3),
        np.asarray(limits.smoothing_s),
    )


def solve_legs(distance_m: FloatArray, limits: LimitArrays) -> Legs:
    """Return how legs of these distances are flown.

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
        # a leg without cruise takes two ramps, whatever rounding makes of it
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
    # Most legs of a survey's matrices reach their speed, and cost two operations.
    is_short = distance < cruise * ramp
    if np.any(is_short):
        short = solve_legs(distance[is_short], limit_arrays(limits)).duration_s
        duration[is_short] = short
    return as_given(duration)


def as_given(values: FloatArray) -> float | FloatArray:
    """Return a float for a result of no dimension, the array else."""
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
    """Return jerk and smoothing no larger than the rise to full acceleration has room for."""
    shorter = np.sqrt(acceleration * smoothing / jerk)
    is_short = shorter < smoothing
    return (
        np.where(is_short, _quotient(acceleration, shorter), jerk),
        np.where(is_short, shorter, smoothing),
    )


def _peak_speed(
    distance: FloatArray, acceleration: FloatArray, jerk: FloatArray, smoothing: FloatArray
) -> FloatArray:
    """Return the speed that a leg reaches if only its length, and not its speed, is limited."""
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
