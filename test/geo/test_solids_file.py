# SPDX-License-Identifier: Apache-2.0
"""A file of solids gives back what was written, or says in one line why not."""

import re

import numpy as np
import pytest
from test.geo.boxes import box_thing

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.solids.scene_solids import SceneSolids
from rocsafe_geo.solids.solids_file import read_solids, write_solids
from rocsafe_geo.terrain.height_grid import GridFrame, HeightGrid

ORIGIN = GeoPosition(53.28, -9.06, 66.0)


def slope(half_m=1000.0, cell_m=100.0):
    """Return ground that rises a tenth to the east."""
    count = round(2.0 * half_m / cell_m) + 1
    frame = GridFrame(west_m=-half_m, south_m=-half_m, cell_m=cell_m, columns=count, rows=count)
    return HeightGrid(frame, np.tile(0.1 * np.linspace(-half_m, half_m, count), (count, 1)))


def scene(*things):
    """Return `things` on a slope."""
    return SceneSolids(origin=ORIGIN, things=things, ground=(slope(100.0, 10.0), slope()))


def test_a_file_gives_back_what_was_written(tmp_path):
    """Every number to the last bit, and the same bytes when it is written again."""
    wall = box_thing('wall', (2.0, 10.0, 5.0), (10.0, 0.0, 0.0), 'lead')
    house = box_thing('house', (8.0, 9.0, 5.5), (-20.1, 33.3, 0.1), 'brick', 0.14)
    first, second = tmp_path / 'first.npz', tmp_path / 'second.npz'
    write_solids(first, scene(wall, house))
    found = read_solids(first)
    write_solids(second, found)
    assert first.read_bytes() == second.read_bytes()
    assert found.origin == ORIGIN
    for thing, expected in zip(found.things, (wall, house), strict=True):
        assert (thing.name, thing.material, thing.fill) == (
            expected.name, expected.material, expected.fill,
        )  # fmt: skip
        np.testing.assert_array_equal(thing.corners_enu_m, expected.corners_enu_m, strict=True)
    for grid, expected in zip(found.ground, scene().ground, strict=True):
        assert grid.frame == expected.frame
        np.testing.assert_array_equal(grid.heights, expected.heights, strict=True)


def test_a_scene_without_things_is_ground_alone(tmp_path):
    """As of a field where nothing stands."""
    write_solids(tmp_path / 'field.npz', scene())
    assert read_solids(tmp_path / 'field.npz').things == ()


def test_altitudes_are_those_of_the_ground_about_the_origin():
    """At places 100 m to the east and west; the Earth's curve takes less than 2 cm."""
    places = [offset(ORIGIN, east, 30.0) for east in (-100.0, 0.0, 100.0)]
    found = scene().altitudes_m(
        [place.latitude_deg for place in places], [place.longitude_deg for place in places]
    )
    assert found - ORIGIN.altitude_m == pytest.approx([-10.0, 0.0, 10.0], abs=0.02)


def written(path, **changes):
    """Write a file of solids with some arrays changed; None leaves one out."""
    write_solids(path, scene(box_thing('wall', (2.0, 10.0, 5.0), (10.0, 0.0, 0.0), 'lead')))
    with np.load(path) as archive:
        arrays = {**archive, **changes}
    np.savez(path, **{name: value for name, value in arrays.items() if value is not None})


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'format': np.array('rocsafe-solids 2')}, "format = 'rocsafe-solids 2' must be"),
        ({'materials': None}, 'materials is missing'),
        ({'origin': np.array([91.0, 0.0, 0.0])}, 'latitude_deg'),
        ({'fills': np.array([1.5])}, 'wall: fill = 1.5 must be within 0 and 1'),
        ({'corners': np.full((12, 3, 3), np.nan, np.float32)}, 'wall: corners_enu_m must be'),
        ({'names': np.array(['wall', 'roof'])}, 'shorter'),
        ({'grids': np.zeros((0, 3))}, 'ground must hold at least one grid'),
        ({'names': np.array([{}], object)}, 'Object arrays cannot be loaded'),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(changes, reason, tmp_path):
    """With its name and what is wrong."""
    path = tmp_path / 'wrong.npz'
    written(path, **changes)
    with pytest.raises(ValueError, match=re.escape(f'solids {path}: ')) as caught:
        read_solids(path)
    assert reason in str(caught.value)
    assert '\n' not in str(caught.value)


def test_what_is_no_archive_is_refused(tmp_path):
    """A text, a torn file and no file at all."""
    text, torn = tmp_path / 'text.npz', tmp_path / 'torn.npz'
    text.write_text('solid\n')
    write_solids(torn, scene())
    torn.write_bytes(torn.read_bytes()[:2000])
    for path in (text, torn, tmp_path / 'none.npz'):
        with pytest.raises(ValueError, match=re.escape(f'solids {path}: ')):
            read_solids(path)
