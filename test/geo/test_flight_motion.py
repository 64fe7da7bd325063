# SPDX-License-Identifier: Apache-2.0
"""Routes, corners, stops, wind and charge: limits never exceeded, nothing ever jumps."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.motion import MotionLimits
from rocsafe_geo.motion.autopilot import DIRECT, Autopilot
from rocsafe_geo.motion.battery import Discharge, PowerModel
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.motion.route_motion import RouteMotion, Way
from rocsafe_geo.motion.state import MotionState
from rocsafe_geo.motion.stop import StopMotion

PLACES = st.lists(
    st.tuples(st.floats(-150.0, 150.0), st.floats(-150.0, 150.0), st.floats(10.0, 60.0)),
    min_size=2,
    max_size=6,
)
WINDS = st.just((0.0, 0.0)) | st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))


def performance(**changes):
    """Return a multirotor of ordinary performance."""
    values = {
        'cruise_speed_mps': 10.0,
        'acceleration_mps2': 2.5,
        'climb_rate_mps': 2.5,
        'descent_rate_mps': 1.5,
        **changes,
    }
    return Performance(**values)


def motion_along(flyer, places, stand_s):
    """Return the motion along places: passed where `stand_s` is 0."""
    ways = []
    for number, (here, there) in enumerate(pairwise(places)):
        is_last = number == len(places) - 2
        passes = stand_s == 0.0 and not is_last
        ways.append(flyer.way(here, there, stand_s, is_passed=passes))
    return RouteMotion(places[0], ways, flyer.corner_radius_m)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(PLACES, WINDS, st.sampled_from([0.0, 1.5]), st.floats(0.0, 1.0))
def test_a_route_is_smooth_within_its_limits_and_passes_its_places(places, wind, stand_s, share):
    """Position, speed and acceleration are slopes of each other and never jump."""
    flyer = performance(wind_mps=wind)
    motion = motion_along(flyer, places, stand_s)
    both = 2.0 if stand_s == 0.0 else 1.0
    time, step = share * motion.duration_s, 1e-4
    now, later = motion.state(time), motion.state(time + step)
    flat = math.hypot(*now.acceleration_enu[:2])
    assert flat <= both * 2.5 * (1.0 + 1e-9)
    assert now.speed_mps <= both * 10.0 * (1.0 + 1e-9)
    assert abs(now.acceleration_enu[2]) <= both * 1.0 + 1e-9
    for axis in range(3):
        moved = later.position_enu[axis] - now.position_enu[axis]
        assert moved == pytest.approx(now.velocity_enu[axis] * step, abs=1e-7)
        faster = later.velocity_enu[axis] - now.velocity_enu[axis]
        assert faster == pytest.approx(now.acceleration_enu[axis] * step, abs=1e-6)
        harder = later.acceleration_enu[axis] - now.acceleration_enu[axis]
        assert abs(harder) <= both * 1.0 * step * 1.01 + 1e-9
    assert motion.progress_m(time + step) >= motion.progress_m(time) - 1e-9
    np.testing.assert_allclose(motion.positions(np.array([time]))[0], now.position_enu, atol=1e-9)
    for arrival, place in zip(motion.arrivals_s, places[1:], strict=True):
        off_m = math.dist(motion.state(arrival).position_enu, place)
        assert off_m <= (flyer.corner_radius_m + 1e-6 if stand_s == 0.0 else 1e-9)
    assert motion.state(motion.duration_s).position_enu == places[-1]
    assert list(motion.arrivals_s) == sorted(motion.arrivals_s)


@settings(max_examples=40, deadline=None)
@given(PLACES)
def test_passing_corners_is_never_slower_and_no_faster_than_cruise(places):
    """Between the time of stops and the length at cruise speed."""
    flyer = performance()
    passed, stopped = motion_along(flyer, places, 0.0), motion_along(flyer, places, 1e-9)
    assert passed.duration_s <= stopped.duration_s + 1e-6
    length = sum(math.dist(a[:2], b[:2]) for a, b in pairwise(places))
    assert passed.duration_s >= length / 10.0 - 1e-9


def test_a_straight_line_is_flown_through():
    """Places on a line cost nothing where legs reach their speed: 400 m as if they were one."""
    flyer = performance()
    line = [(0.0, 0.0, 30.0), (150.0, 0.0, 30.0), (250.0, 0.0, 30.0), (400.0, 0.0, 30.0)]
    whole = motion_along(flyer, [line[0], line[-1]], 0.0)
    parts = motion_along(flyer, line, 0.0)
    assert parts.duration_s == pytest.approx(whole.duration_s)
    assert parts.state(parts.arrivals_s[0]).speed_mps == pytest.approx(10.0)


def test_a_radius_of_zero_stops_at_every_corner():
    """Also at straight ones, where rounding would decide."""
    flyer = performance(autopilot=Autopilot(waypoint_radius_m=0.0))
    places = [(0.0, 0.0, 30.0), (50.0, 0.0, 30.0), (100.0, 0.0, 30.0)]
    motion = motion_along(flyer, places, 0.0)
    assert motion.state(motion.arrivals_s[0]).velocity_enu == (0.0, 0.0, 0.0)


def test_a_way_passed_has_no_stand():
    """To stand somewhere is to stop there."""
    with pytest.raises(ValueError, match='stand_s'):
        Way(end_enu=(0.0, 0.0, 0.0), limits=MotionLimits(1.0, 1.0), stand_s=1.0, is_passed=True)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(PLACES, st.sampled_from([0.0, 1.5]), st.floats(0.0, 1.0))
def test_a_stop_is_smooth_from_anywhere(places, stand_s, share):
    """Brake at any instant of any route: no jump, no limit broken, rest at the end."""
    flyer = performance()
    route = motion_along(flyer, places, stand_s)
    start = route.state(share * route.duration_s)
    stop = StopMotion(start, flyer.level, flyer.vertical)
    begin = stop.state(0.0)
    assert begin.position_enu == start.position_enu
    assert math.dist(begin.velocity_enu, start.velocity_enu) < 1e-8
    if stop.duration_s:
        assert math.dist(begin.acceleration_enu, start.acceleration_enu) < 1e-8
    last = start
    times = np.linspace(0.0, stop.duration_s, 200)
    for time in times[1:].tolist():
        now = stop.state(time)
        step = times[1]
        assert math.dist(now.acceleration_enu[:2], last.acceleration_enu[:2]) <= 1.01 * step + 1e-9
        assert now.speed_mps <= max(start.speed_mps, 10.0 * 2.0) + 1e-9
        last = now
    assert last.velocity_enu == (0.0, 0.0, 0.0)
    almost = stop.state(max(0.0, stop.duration_s - 1e-6))
    assert math.dist(almost.position_enu, last.position_enu) < 1e-5


def test_a_stop_from_cruise_by_hand():
    """From 10 m/s: 4 s and 2.5 s of jerk, 32.5 m; from standstill nothing."""
    flyer = performance()
    cruise = MotionState((0.0, 0.0, 30.0), (10.0, 0.0, 0.0))
    stop = StopMotion(cruise, flyer.level, flyer.vertical)
    assert stop.duration_s == pytest.approx(6.5)
    assert stop.distance_m == pytest.approx(32.5)
    assert StopMotion(MotionState((1.0, 2.0, 3.0)), flyer.level, flyer.vertical).duration_s == 0.0


def test_wind_holds_up_and_does_not_push():
    """Against 6 m/s 10.24 m/s of airspeed leave 4.24; with it the cruise speed stays."""
    flyer = performance(wind_mps=(6.0, 0.0))
    paths = np.array([(1000.0, 0.0), (-1000.0, 0.0), (0.0, 1000.0)])
    with_it, against, across = flyer.legs_s(paths).tolist()
    calm = performance().legs_s(paths)[0]
    assert with_it == pytest.approx(calm)
    assert against == pytest.approx(1000.0 / (flyer.airspeed_mps - 6.0), rel=0.03)
    assert across == pytest.approx(1000.0 / math.sqrt(flyer.airspeed_mps**2 - 36.0), rel=0.06)


def test_wind_beyond_the_lean_angle_is_refused():
    """The wind, the limit and where it comes from are named."""
    with pytest.raises(ValueError, match=r'wind_mps is 11 m/s: must be up to .* lean_angle_deg'):
        performance(wind_mps=(0.0, 11.0))


def test_direct_autopilot_has_no_delays():
    """Climb and descent are height over rate, legs are trapezoids."""
    flyer = performance(autopilot=DIRECT)
    assert flyer.ascent_s(50.0) == pytest.approx(20.0)
    assert flyer.descent_s(30.0) == pytest.approx(20.0)
    assert flyer.legs_s(np.array([100.0, 0.0])) == pytest.approx(14.0)


@settings(max_examples=25, deadline=None)
@given(PLACES, WINDS, st.floats(0.0, 1.0))
def test_energy_is_the_integral_of_power(places, wind, share):
    """Against fine sums; at the largest airspeed a battery lasts as long as it says."""
    flyer = performance(wind_mps=wind)
    power = PowerModel(endurance_s=1000.0, top_airspeed_mps=flyer.airspeed_mps)
    motion = motion_along(flyer, places, 0.0)
    used = Discharge(motion, power, wind)
    end = share * motion.duration_s
    times = np.linspace(0.0, end, 2001)
    powers = [used.power_w(time) for time in times.tolist()]
    assert used.used_j(end) == pytest.approx(np.trapezoid(powers, times), rel=1e-4, abs=1e-6)
    assert power.power_w(flyer.airspeed_mps**2) * 1000.0 == pytest.approx(power.capacity_j)
