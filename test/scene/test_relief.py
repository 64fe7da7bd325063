# SPDX-License-Identifier: Apache-2.0
"""Relief: earthworks have the profiles that they are given, hills begin where they should."""

import numpy as np
import pytest

from rocsafe_scene.ground.relief import Course, Pad, Relief
from rocsafe_scene.ground.terrain import GridFrame, HeightGrid, frame_of, make_terrain

FRAME = GridFrame(west_m=-40.96, south_m=-20.48, cell_m=0.64, columns=129, rows=65)


def level(frame: GridFrame) -> np.ndarray:
    """Return measured heights of 5 m everywhere."""
    return np.full(frame.columns * frame.rows, 5.0)


def slope(frame: GridFrame) -> np.ndarray:
    """Return a plane that rises by 0.1 m per metre to the north."""
    return 0.1 * frame.places()[:, 1]


def across(relief: Relief) -> tuple[np.ndarray, np.ndarray]:
    """Return north and height along the middle column of `FRAME`."""
    heights = relief.heights(FRAME).reshape(FRAME.rows, FRAME.columns)
    return FRAME.south_m + FRAME.cell_m * np.arange(FRAME.rows), heights[:, FRAME.columns // 2]


@pytest.mark.parametrize('lift_m', [0.7, -1.1])
def test_an_earthwork_is_a_top_with_smooth_flanks(lift_m):
    """Level across its width, half its lift in the middle of the flank, natural beyond."""
    line = np.array([[-100.0, 0.0], [100.0, 0.0]])
    course = Course(line=line, half_width_m=2.6, lift_m=lift_m, slope_m=3.2)
    north, height = across(
        Relief(seed=1, local_m=0.0, hills_m=0.0, courses=(course,), measured=level)
    )
    off = np.abs(north)
    assert height[off <= 2.6] == pytest.approx(5.0 + lift_m)
    assert height[off >= 5.8] == pytest.approx(5.0)
    half_way = np.interp(2.6 + 1.6, north, height)
    assert half_way == pytest.approx(5.0 + 0.5 * lift_m, abs=0.03 * abs(lift_m))
    flank = height[(north >= 2.6) & (north <= 5.8)]
    assert (np.diff(flank) * np.sign(lift_m) <= 1e-12).all()


def test_later_earthworks_cross_earlier_ones():
    """Where two cross, the last one has its own height."""
    east = Course(
        line=np.array([[-100.0, 0.0], [100.0, 0.0]]), half_width_m=3.0, lift_m=2.0, slope_m=2.0
    )
    north = Course(
        line=np.array([[0.0, -100.0], [0.0, 100.0]]), half_width_m=3.0, lift_m=-1.0, slope_m=2.0
    )
    relief = Relief(seed=1, local_m=0.0, hills_m=0.0, courses=(east, north), measured=level)
    heights = relief.heights(FRAME).reshape(FRAME.rows, FRAME.columns)
    assert heights[FRAME.rows // 2, FRAME.columns // 2] == pytest.approx(4.0)
    assert heights[FRAME.rows // 2, 5] == pytest.approx(7.0)


def test_an_embankment_on_a_slope_is_level_across_its_width():
    """Its height is that of the ground along its centre line."""
    course = Course(
        line=np.array([[-100.0, 4.0], [100.0, 4.0]]), half_width_m=3.0, lift_m=0.5, slope_m=2.0
    )
    north, height = across(
        Relief(seed=1, local_m=0.0, hills_m=0.0, courses=(course,), measured=slope)
    )
    on_top = np.abs(north - 4.0) <= 3.0
    assert height[on_top] == pytest.approx(0.9, abs=1e-6)
    assert height[north < -2.0] == pytest.approx(0.1 * north[north < -2.0])


def test_a_pad_on_a_slope_is_level_at_the_height_of_its_middle():
    """And the slope is as it was beyond its rim."""
    pad = Pad(east_m=0.0, north_m=5.0, radius_m=4.0)
    north, height = across(Relief(seed=1, local_m=0.0, hills_m=0.0, pads=(pad,), measured=slope))
    assert height[np.abs(north - 5.0) <= 4.0] == pytest.approx(0.5, abs=1e-6)
    away = np.abs(north - 5.0) >= 1.6 * 4.0
    assert height[away] == pytest.approx(0.1 * north[away])


def test_heights_grow_with_their_options_and_hills_begin_outside_of_the_site():
    """Local relief is proportional to `local_m`; within 190 m there are no hills at all."""
    one, two = (Relief(seed=3, local_m=m, hills_m=0.0).heights(FRAME) for m in (1.0, 2.0))
    assert two == pytest.approx(2.0 * one)
    assert np.abs(one).max() < 3.0
    hilly = Relief(seed=3, local_m=1.0, hills_m=100.0)
    assert hilly.heights(FRAME) == pytest.approx(one)
    far = frame_of((4096.0, 4096.0), 81.92)
    distance = np.linalg.norm(far.places(), axis=1)
    heights = hilly.heights(far)
    assert np.ptp(heights[distance > 1500.0]) > 30.0


def test_seeds_make_different_landscapes_and_the_same_seed_the_same():
    """Noise is a function of seed and place."""
    first, again, other = (
        Relief(seed=seed, local_m=1.0, hills_m=0.0).heights(FRAME) for seed in (4, 4, 5)
    )
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.8


def test_normals_stand_on_the_slope():
    """A plane has one normal, the gradient's."""
    heights = slope(FRAME).reshape(FRAME.rows, FRAME.columns)
    normals = HeightGrid(FRAME, heights).normals()
    expected = np.array([0.0, -0.1, 1.0]) / np.hypot(0.1, 1.0)
    assert np.allclose(normals, expected)


def test_a_plane_is_found_again_at_any_place_of_a_terrain():
    """Grids of all cells, and their triangles, lie in the plane."""
    terrain = make_terrain(slope)
    places = np.random.default_rng(1).uniform(-3000.0, 3000.0, (500, 2))
    assert terrain.height_at(places) == pytest.approx(0.1 * places[:, 1], abs=1e-9)
    assert terrain.covers(np.array([[0.0, 0.0], [491.0, -491.0], [600.0, 0.0]])).tolist() == [
        True, True, False,
    ]  # fmt: skip
