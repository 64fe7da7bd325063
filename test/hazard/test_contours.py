# SPDX-License-Identifier: Apache-2.0
"""Areas of a grid above a level."""

import math

import numpy as np
import pytest
from shapely.geometry import Point

from rocsafe_hazard.contours import area_above


def areas(values, level, corner, cell_m):
    """Return the area of a grid of square cells."""
    rows, columns = values.shape
    east_m, north_m = corner[0] + cell_m * np.arange(columns), corner[1] + cell_m * np.arange(rows)
    return area_above(east_m, north_m, values, level)


def cone(size=60, centre=(30.2, 28.7)):
    """Return distances below 40 m from a centre, as a map of 1 m."""
    axis = np.arange(size, dtype=float)
    return 40.0 - np.hypot(axis[None, :] - centre[0], axis[:, None] - centre[1])


def test_a_ring_of_ten_metres_has_the_area_of_a_circle():
    """Within 1 % on a grid of 1 m."""
    area = areas(cone(), 30.0, (100.0, 200.0), 1.0)
    assert area.area == pytest.approx(math.pi * 100.0, rel=0.01)
    assert area.contains(Point(130.2, 228.7))
    assert area.centroid.distance(Point(130.2, 228.7)) < 0.05


def test_a_hole_stays_a_hole():
    """Low ground within high ground is outside."""
    ring = -np.abs(cone() - 28.0)
    area = areas(ring, -5.0, (0.0, 0.0), 1.0)
    assert area.area == pytest.approx(math.pi * (17.0**2 - 7.0**2), rel=0.02)
    assert not area.contains(Point(30.2, 28.7))


def test_areas_end_at_the_border():
    """All of a map that is high everywhere, nothing of one that is low."""
    whole = areas(np.full((11, 21), 5.0), 1.0, (0.0, 0.0), 2.0)
    assert whole.area == pytest.approx(20.0 * 40.0, rel=0.01)
    assert areas(np.zeros((11, 21)), 1.0, (0.0, 0.0), 2.0).is_empty


def test_values_at_the_level_make_no_mess():
    """A checkerboard of nodes exactly at the level."""
    board = np.indices((8, 8)).sum(axis=0) % 2.0
    assert areas(board, 1.0, (0.0, 0.0), 1.0).is_valid
