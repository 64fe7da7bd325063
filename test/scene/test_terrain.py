# SPDX-License-Identifier: Apache-2.0
"""The shape of the ground: without gaps, where it was built, the same everywhere asked."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_scene.errors import SceneError
from rocsafe_scene.ground.height_file import write_heights
from rocsafe_scene.ground.relief import Course, Pad, Relief
from rocsafe_scene.ground.terrain import (
    INNER_CELL_M,
    INNER_HALF_M,
    GridFrame,
    HeightGrid,
    make_terrain,
)
from rocsafe_scene.mesh.lines import nearest_on, resampled

LINE = np.array([[-200.0, 10.0], [0.0, 14.0], [200.0, 6.0]])


@pytest.fixture(scope='module')
def terrain():
    """Return a landscape with a railway embankment and a level place."""
    course = Course(line=LINE, half_width_m=2.6, lift_m=0.8, slope_m=2.6)
    pad = Pad(east_m=60.0, north_m=-50.0, radius_m=10.0)
    relief = Relief(seed=9, local_m=2.0, hills_m=30.0, courses=[course], pads=[pad])
    return make_terrain(relief.heights)


def test_the_grids_meet_without_a_gap(terrain):
    """On the border of the fine grid both grids are equally high."""
    half_e, half_n = INNER_HALF_M
    along = np.arange(-half_n, half_n, INNER_CELL_M)
    border = np.column_stack([np.full(len(along), half_e), along])
    inner, outer = terrain.inner.height_at(border), terrain.outer.height_at(border)
    assert np.allclose(inner, outer, atol=1e-9)


def test_the_embankment_is_smooth_along_and_lifted_above_its_sides(terrain):
    """Along the track the slope stays below 3 %; beside it the ground lies lower."""
    line = resampled(LINE, 2.0)[40:-40]
    top = terrain.height_at(line)
    assert np.abs(np.diff(top)).max() / 2.0 < 0.03
    beside = terrain.height_at(line + np.array([0.0, 9.0]))
    assert np.mean(top - beside) > 0.4


def test_a_pad_is_level(terrain):
    """Within its radius the ground is even to a centimetre."""
    turn = np.linspace(0.0, 6.28, 40)
    ring = np.array([60.0, -50.0]) + 7.5 * np.column_stack([np.cos(turn), np.sin(turn)])
    assert np.ptp(terrain.height_at(ring)) < 0.01


@given(st.floats(0.0, 2.99), st.floats(0.0, 1.99))
def test_heights_are_those_of_the_triangles(x, y):
    """Inside a cell the height lies on the plane through three of its corners."""
    heights = np.array([[0.0, 1.0, 4.0, 2.0], [3.0, 0.5, 1.0, 7.0], [2.0, 2.0, 9.0, 1.0]])
    grid = HeightGrid(GridFrame(west_m=0.0, south_m=0.0, cell_m=1.0, columns=4, rows=3), heights)
    column, row = int(x), int(y)
    u, v = x - column, y - row
    sw, ne = heights[row, column], heights[row + 1, column + 1]
    corner = heights[row, column + 1] if u >= v else heights[row + 1, column]
    plane = sw + (corner - sw) * abs(u - v) + (ne - sw) * min(u, v)
    assert grid.height_at(np.array([[x, y]]))[0] == pytest.approx(plane, abs=1e-9)


def test_nearest_on_a_line():
    """Distance and way along a bent line, by hand."""
    line = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    found = nearest_on(line, np.array([[4.0, 3.0], [12.0, 5.0], [-3.0, -4.0]]))
    assert np.allclose(found.distance_m, [3.0, 2.0, 5.0])
    assert np.allclose(found.along_m, [4.0, 15.0, 0.0])


@pytest.mark.slow
def test_heights_for_planners_are_those_of_the_scene(tmp_path):
    """Read back they agree within a few centimetres, on and off the detailed ground."""
    origin = GeoPosition(53.28, -9.06, 60.0)
    terrain = make_terrain(Relief(seed=4, local_m=1.5, hills_m=20.0).heights)
    write_heights(tmp_path / 'heights.tif', terrain, origin, 256.0)
    places = np.random.default_rng(1).uniform(-220.0, 220.0, (200, 2))
    frame = LocalFrame(origin)
    geodetic = frame.to_geodetic(np.column_stack([places, terrain.height_at(places)]))
    read = read_terrain(tmp_path / 'heights.tif')
    error = read.altitudes_m(geodetic[:, 0], geodetic[:, 1]) - geodetic[:, 2]
    assert np.abs(error).max() < 0.25
    assert np.abs(error).mean() < 0.03
    with pytest.raises(SceneError, match='cannot be written'):
        write_heights(tmp_path / 'no' / 'heights.tif', terrain, origin)


def test_heights_for_planners_are_whole_or_as_before(tmp_path):
    """Nothing is left beside the file, nor of one that could not get its name."""
    origin = GeoPosition(53.28, -9.06, 60.0)
    terrain = make_terrain(Relief(seed=4, local_m=1.5, hills_m=20.0).heights)
    write_heights(tmp_path / 'heights.tif', terrain, origin, 64.0)
    (tmp_path / 'taken.tif' / 'by').mkdir(parents=True)
    with pytest.raises(SceneError, match='cannot be written'):
        write_heights(tmp_path / 'taken.tif', terrain, origin, 64.0)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['heights.tif', 'taken.tif']
