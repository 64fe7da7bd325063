# SPDX-License-Identifier: Apache-2.0
"""Legs from stop to stop: closed form against limits, calculus and known answers."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.motion import MotionLimits, leg_duration_s
from rocsafe_geo.motion.leg import limit_arrays, solve_legs
from rocsafe_geo.motion.leg_table import LegTable

SPEEDS = st.floats(0.2, 20.0)
ACCELERATIONS = st.floats(0.3, 8.0)
JERKS = st.floats(0.1, 100.0)
SMOOTHINGS = st.just(0.0) | st.floats(0.01, 2.0)
LIMITS = st.builds(MotionLimits, SPEEDS, ACCELERATIONS, JERKS, SMOOTHINGS)
DISTANCES = st.just(0.0) | st.floats(1e-9, 3000.0)


@pytest.mark.parametrize(
    ('distance', 'speed', 'acceleration', 'duration'),
    [
        (15.0, 5.0, 2.0, 5.50),
        (15.0, 10.0, 2.5, 4.90),
        (30.0, 10.0, 2.5, 6.93),
        (30.0, 12.0, 3.0, 6.32),
        (0.0, 5.0, 2.0, 0.0),
    ],
)
def test_known_durations_without_jerk(distance, speed, acceleration, duration):
    """d/v + v/a when the cruise speed is reached, 2 sqrt(d/a) when not."""
    limits = MotionLimits(speed, acceleration, 1e9, 0.0)
    assert leg_duration_s(distance, limits) == pytest.approx(duration, abs=0.005)


def test_known_durations_with_jerk():
    """By hand, of 10 m/s, 2.5 m/s^2 and 1 m/s^3: each ramp takes 4 + 2.5 s and the smoothing."""
    limits = MotionLimits(10.0, 2.5, 1.0, 0.5)
    assert leg_duration_s(200.0, limits) == pytest.approx(7.0 + 20.0)
    # 70 m are needed to reach 10 m/s and to stop
    assert leg_duration_s(70.0, limits) == pytest.approx(14.0)
    # 2 a b^2 m for a peak of a with b = a/j + s: 1.5 m/s^2 on 12 m
    assert leg_duration_s(2.0 * 1.5 * 2.0**2, limits) == pytest.approx(4.0 * 2.0)
    # jerk alone: d = 2 j t^3 with four ramps of t
    assert leg_duration_s(2.0, replace(limits, smoothing_s=0.0)) == pytest.approx(4.0)


@pytest.mark.slow
@given(DISTANCES, LIMITS, st.floats(0.0, 1.0))
def test_motion_keeps_its_limits_and_is_its_own_calculus(distance, limits, fraction):
    """Speed, acceleration and jerk stay within limits, and each is the slope of the one before."""
    duration = leg_duration_s(distance, limits)
    table = LegTable(solve_legs(np.array([distance]), limit_arrays(limits)))
    elapsed = fraction * duration
    first = np.zeros(4, int)
    times = np.array([0.0, elapsed, duration, duration + 1.0])
    flown = table.progress_m(first, times)
    assert flown[[0, 2, 3]].tolist() == [0.0, distance, distance]
    step = 1e-5 * duration
    x0, v0, a0 = table.at(0, elapsed)
    x1, v1, a1 = table.at(0, elapsed + step)
    assert -1e-9 <= v0 <= limits.cruise_speed_mps * (1.0 + 1e-9)
    assert abs(a0) <= limits.acceleration_mps2 * (1.0 + 1e-9)
    assert abs(a1 - a0) <= limits.jerk_mps3 * step * (1.0 + 1e-6) + 1e-9
    assert x1 - x0 == pytest.approx(v0 * step, abs=limits.acceleration_mps2 * step**2 + 1e-9)
    assert v1 - v0 == pytest.approx(a0 * step, abs=limits.jerk_mps3 * step**2 + 1e-9)
    assert x1 >= x0 - 1e-9
    assert flown[1] == pytest.approx(x0, abs=1e-9)


@given(st.floats(1e-6, 3000.0), LIMITS)
def test_pieces_meet_and_end_at_the_distance_standing(distance, limits):
    """The integrated pieces end where the leg does, with neither speed nor acceleration."""
    legs = solve_legs(np.array([distance]), limit_arrays(limits))
    table = LegTable(legs)
    t = float(legs.duration_s[0] - table.begin_s[0, -1])
    c = table.coefficients[0, -1]
    assert np.polyval(c[::-1], t) == pytest.approx(distance, rel=1e-8)
    speed = float(legs.speed_mps[0])
    assert np.polyval(np.polyder(c[::-1]), t) == pytest.approx(0.0, abs=1e-7 * (1.0 + speed))
    assert np.polyval(np.polyder(c[::-1], 2), t) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
@given(DISTANCES, DISTANCES, LIMITS)
def test_duration_is_a_metric(first, second, limits):
    """Two legs are never faster than one of their sum, nor a longer leg than a shorter one."""
    apart = leg_duration_s(first, limits), leg_duration_s(second, limits)
    together = leg_duration_s(first + second, limits)
    assert together <= sum(apart) + 1e-9
    assert together >= max(apart) - 1e-9


@given(st.floats(1e-3, 3000.0), LIMITS)
def test_nothing_allowed_is_left_unused(distance, limits):
    """A leg reaches its speed, or its full acceleration, or its full jerk, or is all smoothing."""
    legs = solve_legs(np.asarray(distance), limit_arrays(limits))
    if legs.speed_mps < limits.cruise_speed_mps * (1.0 - 1e-9):
        assert legs.duration_s == pytest.approx(2.0 * legs.ramp_s)
        rise = legs.acceleration_mps2 / legs.jerk_mps3 + legs.smoothing_s
        is_resting = legs.speed_mps / legs.acceleration_mps2 > rise * (1.0 + 1e-6)
        if is_resting:
            assert legs.acceleration_mps2 == pytest.approx(limits.acceleration_mps2)


def test_arrays_match_scalars():
    """An array of distances gives the array of scalar results."""
    limits = MotionLimits(8.0, 2.0)
    distances = np.array([0.0, 0.01, 1.0, 5.0, 32.0, 500.0])
    expected = [leg_duration_s(d, limits) for d in distances.tolist()]
    assert leg_duration_s(distances, limits).tolist() == expected
    table = LegTable(solve_legs(distances, limit_arrays(limits)))
    numbers = np.arange(len(distances))
    flown = table.progress_m(numbers, np.full(len(distances), 3.0))
    assert flown == pytest.approx([table.at(number, 3.0)[0] for number in numbers.tolist()])


@pytest.mark.parametrize(
    'call',
    [
        lambda: MotionLimits(0.0, 1.0),
        lambda: MotionLimits(5.0, -1.0),
        lambda: MotionLimits(math.nan, 1.0),
        lambda: MotionLimits(5.0, 1.0, 0.0),
        lambda: MotionLimits(5.0, 1.0, 1.0, -0.1),
        lambda: leg_duration_s(-1.0, MotionLimits(5.0, 1.0)),
        lambda: leg_duration_s(math.nan, MotionLimits(5.0, 1.0)),
    ],
)
def test_impossible_motion_is_refused(call):
    """Zero, negative and NaN values are refused with the value in the message."""
    with pytest.raises(ValueError, match='must be'):
        call()
