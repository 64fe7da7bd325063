# SPDX-License-Identifier: Apache-2.0
"""Heights between the points of a grid lie on two triangles a cell, of the finest grid there."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.terrain.height_grid import GridFrame, HeightGrid, height_at

NEAR = st.floats(-1.0, 5.0, allow_nan=False)


def grid(heights, west_m=0.0, south_m=0.0, cell_m=1.0):
    """Return a grid of `heights`, the first row in the south."""
    table = np.array(heights, float)
    rows, columns = table.shape
    frame = GridFrame(west_m=west_m, south_m=south_m, cell_m=cell_m, columns=columns, rows=rows)
    return HeightGrid(frame, table)


def test_a_cell_is_cut_from_south_west_to_north_east():
    """A peak in the south-east lifts the lower triangle only, and half of it at its middle."""
    cell = grid([[0.0, 1.0], [0.0, 0.0]])
    places = np.array([[0.5, 0.5], [0.75, 0.25], [0.25, 0.75], [1.0, 0.0], [1.0, 0.5]])
    assert cell.height_at(places).tolist() == [0.0, 0.5, 0.0, 1.0, 0.5]


@given(NEAR, NEAR, st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_a_plane_is_given_back_and_goes_on_level_beyond_its_rim(east, north, a, b):
    """On triangles, a plane is exact; outside of the grid the nearest place of the rim counts."""
    axis = np.arange(5.0)
    plane = grid(a * axis[None, :] + b * axis[:, None])
    inside = np.clip([east, north], 0.0, 4.0)
    found = plane.height_at(np.array([[east, north]]))[0]
    assert found == pytest.approx(a * inside[0] + b * inside[1], abs=1e-9)


def test_the_finest_grid_that_covers_a_place_decides():
    """Inside the fine one its height, around it that of the coarse one."""
    fine = grid(np.full((3, 3), 7.0), west_m=4.0, south_m=4.0)
    coarse = grid(np.full((3, 3), 1.0), cell_m=5.0)
    places = np.array([[5.0, 5.0], [6.0, 6.0], [6.1, 5.0], [20.0, -3.0]])
    assert height_at((fine, coarse), places).tolist() == [7.0, 7.0, 1.0, 1.0]
