# SPDX-License-Identifier: Apache-2.0
"""Stop-to-stop legs."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.motion import MotionLimits, leg_duration_s, leg_progress_m, leg_speed_mps

SPEEDS = st.floats(0.2, 20.0)
ACCELERATIONS = st.floats(0.3, 8.0)
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
def test_known_durations(distance, speed, acceleration, duration):
    """d/v + v/a when the cruise speed is reached, 2 sqrt(d/a) when not."""
    limits = MotionLimits(speed, acceleration)
    assert leg_duration_s(distance, limits) == pytest.approx(duration, abs=0.005)


@given(DISTANCES, SPEEDS, ACCELERATIONS, st.floats(0.0, 1.0))
def test_speed_is_the_slope_of_progress(distance, speed, acceleration, fraction):
    """Progress runs from 0 to the distance, and its slope is the speed, within both limits."""
    limits = MotionLimits(speed, acceleration)
    duration = leg_duration_s(distance, limits)
    elapsed = fraction * duration
    assert leg_progress_m(0.0, distance, limits) == 0.0
    assert leg_progress_m(duration, distance, limits) == distance
    assert leg_progress_m(duration + 1.0, distance, limits) == distance
    now = leg_speed_mps(elapsed, distance, limits)
    assert 0.0 <= now <= speed
    step = 1e-4
    moved = leg_progress_m(elapsed + step, distance, limits) - leg_progress_m(
        elapsed, distance, limits
    )
    assert moved == pytest.approx(now * step, abs=acceleration * step**2 + 1e-9)


@given(DISTANCES, DISTANCES, SPEEDS, ACCELERATIONS)
def test_duration_is_a_metric(first, second, speed, acceleration):
    """Two legs are never faster than one of their sum."""
    limits = MotionLimits(speed, acceleration)
    together = leg_duration_s(first + second, limits)
    assert together <= leg_duration_s(first, limits) + leg_duration_s(second, limits) + 1e-9


def test_arrays_match_scalars():
    """An array of distances gives the array of scalar results."""
    limits = MotionLimits(8.0, 2.0)
    distances = np.array([0.0, 5.0, 32.0, 500.0])
    expected = [leg_duration_s(d, limits) for d in distances.tolist()]
    assert leg_duration_s(distances, limits).tolist() == expected


@pytest.mark.parametrize(
    'call',
    [
        lambda: MotionLimits(0.0, 1.0),
        lambda: MotionLimits(5.0, -1.0),
        lambda: MotionLimits(math.nan, 1.0),
        lambda: leg_duration_s(-1.0, MotionLimits(5.0, 1.0)),
        lambda: leg_duration_s(math.nan, MotionLimits(5.0, 1.0)),
    ],
)
def test_impossible_motion_is_refused(call):
    """Zero, negative and NaN values are refused with the value in the message."""
    with pytest.raises(ValueError, match='must be'):
        call()
