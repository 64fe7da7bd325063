# SPDX-License-Identifier: Apache-2.0
"""Ways over uneven ground: always clear of it, straight where they may be."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.terrain.relief import Relief

CELL_M = 5.0
CLEARANCE_M = 10.0
PLACES = st.tuples(st.floats(5.0, 190.0), st.floats(5.0, 190.0))


def hills(seed):
    """Return the heights of 40 x 40 cells of rough ground."""
    generator = np.random.default_rng(seed)
    rows, columns = np.mgrid[0:40, 0:40] * CELL_M
    tops = np.zeros((40, 40))
    for _ in range(4):
        north, east = generator.uniform(0.0, 200.0, 2)
        height, width = generator.uniform(5.0, 60.0), generator.uniform(8.0, 40.0)
        tops += height * np.exp(-((rows - north) ** 2 + (columns - east) ** 2) / width**2)
    return tops


def relief_of(tops):
    """Return the relief of such ground."""
    return Relief((0.0, 0.0), CELL_M, tops, CLEARANCE_M)


def test_over_level_ground_legs_are_straight():
    """Both bends are the target."""
    first, second = relief_of(np.zeros((40, 40))).bends(
        np.array([[5.0, 5.0, 30.0]]), np.array([[150.0, 90.0, 30.0]])
    )
    assert first.tolist() == second.tolist() == [[150.0, 90.0, 30.0]]


def test_over_a_wall_it_climbs_and_sinks():
    """Between two low places it flies level above the wall and its clearance."""
    tops = np.zeros((40, 40))
    tops[:, 20] = 50.0
    start, end = np.array([[10.0, 100.0, 15.0]]), np.array([[190.0, 100.0, 15.0]])
    first, second = relief_of(tops).bends(start, end)
    assert first[0, 2] >= 50.0 + CLEARANCE_M
    assert first[0, 2] == pytest.approx(second[0, 2])
    assert 10.0 < first[0, 0] < 100.0 < second[0, 0] < 190.0


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 1000), PLACES, PLACES, st.floats(0.0, 30.0))
def test_legs_clear_the_ground_everywhere(seed, start, end, above_m):
    """Each of a thousand places along a leg is above the ground by the clearance."""
    tops = hills(seed)

    def ground_m(east, north):
        return tops[np.rint(north / CELL_M).astype(int), np.rint(east / CELL_M).astype(int)]

    def over(place):
        # ends are above the highest ground near them, as viewpoints are
        east, north = place
        return np.array([[east, north, tops.max() + above_m - 20.0]])

    a, b = over(start), over(end)
    high = relief_of(tops)
    lowest = CLEARANCE_M + tops.max()
    first, second = high.bends(a, b)
    shares = np.linspace(0.0, 1.0, 250)[:, None]
    legs = [p + shares * (q - p) for p, q in ((a, first), (first, second), (second, b))]
    path = np.vstack(legs)
    needed = ground_m(path[:, 0], path[:, 1]) + CLEARANCE_M
    at_ends = min(a[0, 2], b[0, 2])
    # a leg may start or end lower than the clearance, but never sinks below what it was given
    assert (path[:, 2] >= np.minimum(needed, at_ends) - 1e-6).all()
    assert path[:, 2].max() <= max(lowest, a[0, 2], b[0, 2]) + 1e-6
