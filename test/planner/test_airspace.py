# SPDX-License-Identifier: Apache-2.0
"""Legs around exclusions, by hand and against geometry."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.motion.autopilot import DIRECT
from rocsafe_geo.motion.performance import GRAVITY_MPS2, Performance
from rocsafe_planner.errors import NoWayError, TooManyViewpointsError
from rocsafe_planner.problem.airspace import MAX_SITES, Airspace
from rocsafe_planner.problem.detours import Air
from rocsafe_planner.problem.flight_time import FlightTime

from .surveys import star

# flies as fast as 8 m/s through the air
AUTOPILOT = replace(DIRECT, lean_angle_deg=45.0, drag_per_m=GRAVITY_MPS2 / 8.0**2)


def flight(wind_mps=(0.0, 0.0)):
    """Return the times of a vehicle of 8 m/s and 2 m/s^2."""
    performance = Performance(
        cruise_speed_mps=8.0,
        acceleration_mps2=2.0,
        climb_rate_mps=3.0,
        descent_rate_mps=2.0,
        autopilot=AUTOPILOT,
        wind_mps=wind_mps,
    )
    return FlightTime(performance=performance)


def level(places):
    """Return places (n, 2) at one height, (n, 3)."""
    return np.column_stack([places, np.zeros(len(places))])


def air(sites, paths, wind_mps=(0.0, 0.0)):
    """Return a flight at one height."""
    return Air(flight=flight(wind_mps), sites=level(sites), corners=level(paths.corners))


def test_around_a_square_by_hand():
    """The way past a square 10 m wide bends at two of its corners, 1 mm off."""
    airspace = Airspace([shapely.box(-5, -5, 5, 5)], clearance_m=0.0)
    sites = np.array([(-20.0, 0.0), (20.0, 0.0), (-20.0, 30.0)])
    paths = airspace.detours(sites)
    part = math.hypot(14.999, 5.001)
    assert paths.length_m[0, 1] == pytest.approx(2 * part + 10.002)
    np.testing.assert_allclose(
        np.abs(paths.corners[paths.corners_between(0, 1)]), np.full((2, 2), 5.001)
    )
    assert paths.length_m[0, 2] == 30.0
    assert len(paths.corners_between(0, 2)) == 0
    ways = level(np.array([(part, 0.0), (10.002, 0.0), (part, 0.0)]))
    stops = flight()(np.zeros(3), ways).sum()
    found = paths.duration_s(np.array(0), np.array(1), air(sites, paths))
    assert found == pytest.approx(stops)


def test_clearance_is_kept():
    """With 3 m of clearance the way is that much longer, and nothing nearer may be flown to."""
    airspace = Airspace([shapely.box(-5, -5, 5, 5)], clearance_m=3.0)
    assert airspace.holds(np.array([(0.0, 7.9), (0.0, 8.01)])).tolist() == [False, True]
    paths = airspace.detours(np.array([(-20.0, 0.0), (20.0, 0.0)]))
    assert paths.length_m[0, 1] == pytest.approx(2 * math.hypot(12, 8) + 16, abs=0.01)


def test_a_concave_zone_shuts_its_bay():
    """Out of a bay that is open to the east, and round to the west of it."""
    bay = shapely.Polygon(
        [(0, 0), (40, 0), (40, 10), (10, 10), (10, 30), (40, 30), (40, 40), (0, 40)]
    )
    paths = Airspace([bay], 0.0).detours(np.array([(20.0, 20.0), (-10.0, 20.0)]))
    bends = paths.corners[paths.corners_between(0, 1)]
    assert len(bends) == 3
    line = shapely.LineString(np.vstack([(20.0, 20.0), bends, (-10.0, 20.0)]))
    assert line.length == pytest.approx(paths.length_m[0, 1])
    assert shapely.distance(line, bay) > 0.5e-3


def test_a_yard_is_open_to_who_stands_in_it():
    """No viewpoint lies in a yard of nobody; who stands there cannot leave it."""
    ring = shapely.box(0, 0, 50, 50).difference(shapely.box(10, 10, 40, 40))
    assert not Airspace([ring], 0.0, np.array([(100.0, 25.0)])).holds(np.array([(25.0, 25.0)]))
    airspace = Airspace([ring], 0.0, np.array([(25.0, 20.0)]))
    assert airspace.holds(np.array([(25.0, 25.0)])).all()
    with pytest.raises(NoWayError, match='exclusions shut off the place 25 m east, 25 m north'):
        airspace.detours(np.array([(25.0, 25.0), (100.0, 25.0)]))


def test_too_many_sites_are_refused():
    """Number and limit are named."""
    with pytest.raises(TooManyViewpointsError, match=f'must be at most {MAX_SITES}'):
        Airspace([shapely.box(0, 0, 1, 1)], 0.0).detours(np.zeros((MAX_SITES + 1, 2)))


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(10.0, 60.0), min_size=6, max_size=6), st.integers(0, 2**32 - 1))
def test_paths_are_metric_and_clear(radii, seed):
    """Not below the straight line, symmetric, in the triangle but for the margin, and clear."""
    zone = shapely.Polygon(star(6, radii))
    airspace = Airspace([zone], 1.0)
    places = np.random.default_rng(seed).uniform(-90.0, 90.0, (14, 2))
    places = places[airspace.holds(places)]
    paths = airspace.detours(places)
    length = paths.length_m
    straight = np.hypot(*(places[:, None] - places[None, :]).transpose(2, 0, 1))
    assert (length >= straight - 1e-9).all()
    np.testing.assert_allclose(length, length.T, atol=1e-9)
    assert (length[:, None, :] <= length[:, :, None] + length[None, :, :] + 0.02).all()
    for i, j in np.argwhere(length > straight + 1e-9):
        line = shapely.LineString(
            np.vstack([places[i], paths.corners[paths.corners_between(i, j)], places[j]])
        )
        assert line.length == pytest.approx(length[i, j])
        assert shapely.distance(line, zone) >= 1.0 - 1e-6


def test_wind_is_felt_both_ways():
    """Against the wind 6 m/s over ground, across it sqrt(8^2 - 2^2); with it no more than 8."""
    windy = flight((2.0, 0.0))
    times = windy(np.zeros(3), level(np.array([(100.0, 0.0), (-100.0, 0.0), (0.0, 100.0)])))
    across = math.sqrt(60.0)
    np.testing.assert_allclose(
        times, [100 / 8 + 8 / 2, 100 / 6 + 6 / 2, 100 / across + across / 2]
    )
    assert windy.fastest().cruise_speed_mps == 8.0


def test_a_climb_takes_its_time():
    """100 m along and 60 m up at 3 m/s, or down at 2 m/s: the height decides, and the ramps."""
    times = flight()(np.zeros(3), np.array([(100.0, 0.0, 60.0), (100.0, 0.0, -60.0)]))
    length = math.hypot(100.0, 60.0)
    steep = 60.0 / length
    ramps = [rate / steep / (2.0 * length / 100.0) for rate in (3.0, 2.0)]
    np.testing.assert_allclose(times, [20.0 + ramps[0], 30.0 + ramps[1]])
