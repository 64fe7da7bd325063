# SPDX-License-Identifier: Apache-2.0
"""Lengths inside solids and distances to them, with answers worked by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test.geo.boxes import box_triangles

from rocsafe_geo.solids.solid import Solid

WALL = Solid(box_triangles((9.0, -5.0, 0.0), (11.0, 5.0, 5.0)))


def inside_m(solid, start, *ends):
    """Return the length inside `solid` of the ray from `start` to each end."""
    ways = np.array(ends) - start
    lengths = np.linalg.norm(ways, axis=1)
    origins = np.broadcast_to(np.array(start), ways.shape)
    return solid.inside_m(origins, ways / lengths[:, None], lengths)


def test_a_ray_is_inside_between_its_entry_and_its_exit():
    """Straight and slanted through a wall of 2 m, to its middle, and away from it."""
    ends = [(30.0, 0.0, 2.0), (10.0, 0.0, 2.0), (30.0, 9.0, 9.0), (-5.0, 0.0, 2.0)]
    slanted = 2.0 * np.sqrt(30.0**2 + 9.0**2 + 7.0**2) / 30.0
    found = inside_m(WALL, (0.0, 0.0, 2.0), *ends)
    assert found == pytest.approx([2.0, 1.0, slanted, 0.0], abs=1e-5)


def test_a_ray_that_begins_inside_counts_from_there():
    """From the middle of the wall half of its thickness."""
    assert inside_m(WALL, (10.0, 0.0, 2.0), (0.0, 0.0, 2.0)) == pytest.approx([1.0], abs=1e-5)


def test_parts_that_overlap_count_once():
    """Two boxes of 2 m that share 1 m are 3 m long."""
    parts = (box_triangles((9.0, -5.0, 0.0), (11.0, 5.0, 5.0)),
             box_triangles((10.0, -5.0, 0.0), (12.0, 5.0, 5.0)))  # fmt: skip
    found = inside_m(Solid(np.concatenate(parts)), (0.0, 0.3, 2.0), (30.0, 0.3, 2.0))
    assert found == pytest.approx([3.0], abs=1e-5)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_ball_touches_what_is_nearer_than_its_radius(seed):
    """The distance to a box is that to its nearest point, for places outside of it."""
    low, high = np.array([9.0, -5.0, 0.0]), np.array([11.0, 5.0, 5.0])
    place = np.random.default_rng(seed).uniform((2.0, -12.0, -7.0), (18.0, 12.0, 12.0))
    gap = float(np.linalg.norm(place - np.clip(place, low, high)))
    if gap > 0.01:
        assert WALL.touches(place, gap + 1e-3)
        assert not WALL.touches(place, gap - 1e-3)


def test_many_triangles_in_clusters_are_as_one_heap():
    """A row of a hundred boxes, 1200 triangles, stops a ray by the width of all."""
    row = [box_triangles((2.0 * i, -1.0, 0.0), (2.0 * i + 0.5, 1.0, 2.0)) for i in range(100)]
    solid = Solid(np.concatenate(row))
    assert len(solid.clusters) > 1
    assert sum(len(cluster.corners) for cluster in solid.clusters) == 1200
    found = inside_m(solid, (-5.0, 0.2, 1.1), (300.0, 0.2, 1.1), (300.0, 0.2, 5.1))
    assert found[0] == pytest.approx(50.0, abs=1e-3)
