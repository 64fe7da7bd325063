# SPDX-License-Identifier: Apache-2.0
"""Ways around zones: known lengths, never through a zone, never longer than another way."""

import itertools
import math

import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rocsafe_geo.detour import WaysAround, zone_on_way

SQUARE = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))
COORDINATES = st.floats(-60.0, 60.0)


def boxes():
    """Return zones: one to three boxes, which may overlap."""
    corner, side = st.floats(-40.0, 30.0), st.floats(4.0, 25.0)
    one = st.tuples(corner, corner, side, side).map(
        lambda b: tuple(shapely.box(b[0], b[1], b[0] + b[2], b[1] + b[3]).exterior.coords)[:-1]
    )
    return st.lists(one, min_size=1, max_size=3)


def length_m(*places):
    """Return the length of a way."""
    return sum(math.dist(a, b) for a, b in itertools.pairwise(places))


def test_around_a_square_the_way_bends_at_its_corners():
    """From west to east past a square of 20 m with 2 m clearance: 18 + 24 + 18 m, with slopes."""
    ways = WaysAround([SQUARE], 2.0, (30.0, 0.0))
    bends = ways.bends((-30.0, 0.0))
    assert len(bends) == 2
    assert [abs(value) for bend in bends for value in bend] == pytest.approx([12.0] * 4, abs=0.01)
    expected = 2.0 * math.hypot(18.0, 12.0) + 24.0
    assert length_m((-30.0, 0.0), *bends, (30.0, 0.0)) == pytest.approx(expected, abs=0.02)


def test_a_free_way_is_straight():
    """A way that passes beside the zone needs no bend."""
    assert WaysAround([SQUARE], 2.0, (30.0, 20.0)).bends((-30.0, 20.0)) == []


def test_from_inside_it_leads_out_at_the_nearest_side():
    """The first bend is on the edge of the clearance, straight ahead of the nearest side."""
    first, *_ = WaysAround([SQUARE], 2.0, (30.0, 0.0)).bends((-7.0, 3.0))
    assert first == pytest.approx((-12.0, 3.0), abs=0.01)


def test_a_goal_that_is_shut_off_is_flown_to_straight():
    """Where there is no way around, the way is straight."""
    ring = [shapely.box(-30, -30, 30, -20), shapely.box(-30, 20, 30, 30),
            shapely.box(-30, -30, -20, 30), shapely.box(20, -30, 30, 30)]  # fmt: skip
    zones = [tuple(wall.exterior.coords)[:-1] for wall in ring]
    assert WaysAround(zones, 1.0, (0.0, 0.0)).bends((60.0, 0.0)) == []


FAR = ((100.0, 100.0), (110.0, 100.0), (110.0, 110.0))


@pytest.mark.parametrize(
    ('way', 'fault'),
    [
        (((-30.0, 0.0), (30.0, 0.0)), (1, 2)),
        (((-30.0, 20.0), (30.0, 20.0)), None),
        (((-30.0, 20.0), (30.0, 20.0), (30.0, 0.0), (-30.0, 0.0)), (3, 2)),
        (((-30.0, 14.0), (30.0, 14.0)), (1, 2)),
        (((-30.0, 14.0), (0.0, 14.0), (0.0, 40.0)), (1, 2)),
        (((0.0, 12.0), (0.0, 40.0)), None),
        (((0.0, 12.0), (0.0, 40.0), (40.0, 40.0), (12.0, 0.0)), None),
        (((0.0, 12.0), (20.0, 10.5)), (1, 2)),
        (((0.0, 9.0), (0.0, 40.0)), (1, 2)),
        (((0.0, 40.0), (0.0, 0.0)), (1, 2)),
    ],
    ids=['through', 'free', 'third leg', 'too near', 'only its ends may be near', 'leaves',
         'leaves and ends', 'goes nearer', 'from inside', 'ends inside'],
)  # fmt: skip
def test_first_leg_that_is_too_near_to_a_zone_is_named(way, fault):
    """Around a square of 20 m with 6 m clearance, of which 1 m is left for rounding."""
    assert zone_on_way([FAR, SQUARE], 6.0, way) == fault


def test_without_a_clearance_a_way_may_touch_a_zone():
    """It may not cut off a corner of it."""
    assert zone_on_way([SQUARE], 0.0, [(-30.0, 10.0), (30.0, 10.0)]) is None
    assert zone_on_way([SQUARE], 0.0, [(-30.0, 9.8), (30.0, 9.8)]) == (1, 1)
    sliver = ((-10.0, 0.0), (10.0, 0.0), (10.0, 0.06))
    assert zone_on_way([sliver], 0.0, [(9.0, -5.0), (9.0, 5.0)]) == (1, 1)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(boxes(), st.tuples(COORDINATES, COORDINATES), st.tuples(COORDINATES, COORDINATES))
def test_no_way_crosses_a_zone_or_could_be_shorter(zones, place, goal):
    """Any way keeps clear; no other clear way over one or two corners of zones is shorter."""
    clearance_m = 1.5
    union = shapely.union_all([shapely.Polygon(zone) for zone in zones])
    wide = union.buffer(clearance_m + 0.05, join_style='mitre')
    assume(not wide.intersects(shapely.Point(place)) and not wide.intersects(shapely.Point(goal)))
    way = (place, *WaysAround(zones, clearance_m, goal).bends(place), goal)
    kept = union.buffer(clearance_m - 0.05, join_style='mitre')
    assume(len(way) > 2 or not kept.intersects(shapely.LineString(way)))
    assert not kept.intersects(shapely.LineString(way))
    assert zone_on_way(zones, clearance_m, way) is None
    corners = shapely.get_coordinates(union.buffer(clearance_m + 0.01, join_style='mitre'))
    for count in (1, 2):
        for middle in itertools.permutations(map(tuple, corners[:12]), count):
            other = (place, *middle, goal)
            if not wide.intersects(shapely.LineString(other)):
                assert length_m(*way) <= length_m(*other) + 0.05
