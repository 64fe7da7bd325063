# SPDX-License-Identifier: Apache-2.0
"""Flight at a velocity: the limits hold, the motion is smooth, and known cases come out."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.motion.limits import MotionLimits
from rocsafe_geo.motion.state import MotionState
from rocsafe_geo.motion.velocity import VelocityMotion

LEVEL, VERTICAL = MotionLimits(12.0, 2.0, 4.0, 0.0), MotionLimits(3.0, 1.0, 2.0, 0.0)
speeds = st.floats(-8.0, 8.0)
velocities = st.tuples(speeds, speeds, st.floats(-2.0, 2.0))
REST = MotionState((0.0, 0.0, 30.0))


def test_a_known_case():
    """From rest to 4 m/s east within 2 m/s^2 and 4 m/s^3, 10 s, and a stop.

    Each change of speed takes v / a + a / j = 2.5 s, so that the stop ends at 12.5 s; ten seconds
    of 4 m/s are flown in all, whatever the change.
    """
    motion = VelocityMotion(REST, (4.0, 0.0, 0.0), 10.0, LEVEL, VERTICAL)
    assert motion.duration_s == pytest.approx(12.5)
    assert motion.state(2.5).velocity_enu == pytest.approx((4.0, 0.0, 0.0))
    assert motion.distance_m == pytest.approx(40.0)
    assert motion.state(99.0).position_enu == pytest.approx((40.0, 0.0, 30.0))


@pytest.mark.slow
@given(velocities, velocities, st.floats(0.0, 20.0))
def test_limits_hold_and_nothing_jumps(before, after, flown_s):
    """Also where the time is too short to reach the velocity, and from another motion."""
    first = VelocityMotion(REST, before, 1.3, LEVEL, VERTICAL)
    start = first.state(0.8)
    motion = VelocityMotion(start, after, flown_s, LEVEL, VERTICAL)
    step_s = motion.duration_s / 400.0
    states = [*(motion.state(n * step_s) for n in range(400)), motion.state(motion.duration_s)]
    assert states[0].position_enu == pytest.approx(start.position_enu, abs=1e-9)
    assert states[0].velocity_enu == pytest.approx(start.velocity_enu, abs=1e-9)
    assert states[-1].is_still
    for a, b in pairwise(states):
        assert math.hypot(*b.acceleration_enu[:2]) <= 2.0 + 1e-6
        assert abs(b.acceleration_enu[2]) <= 1.0 + 1e-6
        jump = math.dist(a.velocity_enu, b.velocity_enu)
        assert jump <= math.hypot(2.0, 1.0) * step_s + 1e-6


@pytest.mark.parametrize('period_s', [0.05, 0.2, 0.5])
def test_a_velocity_that_turns_is_followed_by_one_order_after_the_other(period_s):
    """A stream that turns by 0.2 rad/s at 3 m/s: needs 0.6 of 2 m/s^2; it lags by seconds only."""
    state, time_s = REST, 0.0
    for n in range(round(40.0 / period_s)):
        time_s = n * period_s
        wanted = (3.0 * math.cos(0.2 * time_s), 3.0 * math.sin(0.2 * time_s), 0.0)
        state = VelocityMotion(state, wanted, 1.0, LEVEL, VERTICAL).state(period_s)
    assert math.dist(state.velocity_enu, wanted) < 0.8
    assert math.hypot(*state.velocity_enu) == pytest.approx(3.0, abs=0.3)


@pytest.mark.slow
@given(velocities, st.floats(0.1, 10.0))
def test_distance_is_the_length_of_the_path(velocity, flown_s):
    """Compared with chords; knots are where the polynomial changes."""
    motion = VelocityMotion(REST, velocity, flown_s, LEVEL, VERTICAL)
    places = [motion.state(n * motion.duration_s / 2000).position_enu for n in range(2001)]
    chords = sum(math.dist(a[:2], b[:2]) for a, b in pairwise(places))
    assert motion.distance_m == pytest.approx(chords, rel=1e-4, abs=1e-6)
    assert motion.knots_s == sorted(motion.knots_s)
    assert motion.progress_m(0.0) == 0.0


@pytest.mark.parametrize(
    ('velocity', 'flown_s'),
    [((math.nan, 0.0, 0.0), 1.0), ((1.0, 0.0, 0.0), -1.0), ((1.0, 0.0, 0.0), math.inf)],
)
def test_nonsense_is_refused(velocity, flown_s):
    """Named, with the limit."""
    with pytest.raises(ValueError, match='must be'):
        VelocityMotion(REST, velocity, flown_s, LEVEL, VERTICAL)
