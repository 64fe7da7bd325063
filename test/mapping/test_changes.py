# SPDX-License-Identifier: Apache-2.0
"""Labels lie where their photographs lie, and two flights tell what changed."""

import importlib.util
import json
import pathlib

import cv2
import numpy as np
import pytest
import rasterio
import rasterio.warp
import shapely

from rocsafe_mapping.command_line.changes_command import EXIT_OK, EXIT_REFUSED, main
from rocsafe_mapping.command_line.map_command import main as map_main
from rocsafe_mapping.mosaic.changes import ChangeOptions
from rocsafe_mapping.photographs.exif import with_exif

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)

# A lorry, metres east and north of the origin.
WEST, EAST, SOUTH, NORTH = 2.0, 8.0, -4.0, -1.0


def taken(ground, folder, rng, count=4):
    """Write photographs of a ground along a line; return them."""
    folder.mkdir()
    shots = []
    for number in range(count):
        shot = texture.photograph(
            ground, number, -18.0 + 12.0 * number, 0.0, rng=rng, fix_m=0.3, gain=rng.normal(1, 0.1)
        )
        (folder / f'DJI_{number:04d}.JPG').write_bytes(with_exif(shot.jpeg, shot.record))
        shots.append(shot)
    return shots


def painted(ground, colour):
    """Return the ground with the lorry on it."""
    scale, half = texture.GROUND_PX_PER_M, texture.GROUND_SIDE_M / 2
    changed = ground.copy()
    rows = slice(int((half - NORTH) * scale), int((half - SOUTH) * scale))
    columns = slice(int((half + WEST) * scale), int((half + EAST) * scale))
    changed[rows, columns] = colour
    return changed


@pytest.mark.slow
def test_a_lorry_that_came_is_the_only_change(tmp_path):
    """Found where it stands, with its area; light and fixes that differ are no change."""
    ground = texture.textured_ground(8)
    rng = np.random.default_rng(3)
    taken(ground, tmp_path / 'before', rng)
    taken(painted(ground, (250, 250, 40)), tmp_path / 'after', rng)
    output = tmp_path / 'changes.geojson'
    arguments = [str(tmp_path / 'before'), str(tmp_path / 'after'), '-o', str(output)]
    assert main(arguments) == EXIT_OK
    (feature,) = json.loads(output.read_text())['features']
    area_m2 = (EAST - WEST) * (NORTH - SOUTH)
    assert feature['properties']['area_m2'] == pytest.approx(area_m2, rel=0.2)
    ring = np.array(feature['geometry']['coordinates'][0])
    shape = shapely.Polygon(
        texture.FRAME.to_enu(ring[:, 1], ring[:, 0], [60.0] * len(ring))[:, :2]
    )
    assert shape.exterior.is_ccw
    middle = shape.centroid
    assert (middle.x, middle.y) == pytest.approx(((WEST + EAST) / 2, (SOUTH + NORTH) / 2), abs=1.5)


@pytest.mark.slow
def test_flights_over_other_ground_are_refused(tmp_path, capsys):
    """Nothing ties them: differences would mean nothing."""
    rng = np.random.default_rng(3)
    taken(texture.textured_ground(8), tmp_path / 'before', rng, 2)
    taken(texture.textured_ground(9), tmp_path / 'after', rng, 2)
    output = tmp_path / 'changes.geojson'
    arguments = [str(tmp_path / 'before'), str(tmp_path / 'after'), '-o', str(output)]
    assert main(arguments) == EXIT_REFUSED
    assert 'no ground in common' in capsys.readouterr().err
    assert not output.exists()


def test_a_folder_without_photographs_is_named(tmp_path, capsys):
    """Nobody is told that two flights do not look alike where one has no photograph."""
    (tmp_path / 'before').mkdir()
    assert main([str(tmp_path / 'before'), str(tmp_path / 'after')]) == EXIT_REFUSED
    assert 'before: has no JPEG file' in capsys.readouterr().err


def test_change_options_have_limits():
    """Nothing below or at zero."""
    with pytest.raises(ValueError, match=r'least_area_m2 = 0\.0 must be above 0'):
        ChangeOptions(least_area_m2=0.0)


@pytest.mark.slow
def test_labels_lie_where_the_map_lies(tmp_path):
    """The map of labels has only classes that were given, on the map's own grid."""
    ground = texture.textured_ground(8)
    labels = tmp_path / 'labels'
    labels.mkdir()
    rows = [(3, 'grass', (80, 150, 60)), (7, 'lorry', (60, 120, 180))]
    keys = ('number', 'class', 'colour')
    table = [dict(zip(keys, row, strict=True)) for row in rows]
    (labels / 'table.json').write_text(json.dumps(table))
    marked = painted(np.full_like(ground, 3), 7)
    for shot in taken(ground, tmp_path / 'card', np.random.default_rng(3)):
        # Nearest: what the camera sees of a picture of labels.
        picture = texture.seen(marked, shot.centre, shot.rotation)[..., 0]
        picture = np.where(picture > 5, 7, 3).astype(np.uint8)
        cv2.imwrite(str(labels / f'DJI_{shot.record.sequence:04d}.png'), picture)
    out = tmp_path / 'out'
    arguments = ['--labels', str(labels), '--only-geotiff', '--resolution', '0.2', '-o', str(out)]
    map_main([str(tmp_path / 'card'), *arguments])
    with rasterio.open(out / 'labels.tif') as file, rasterio.open(out / 'mosaic.tif') as mosaic:
        found = file.read(1)
        assert (file.transform, file.shape) == (mosaic.transform, mosaic.shape)
        assert (file.crs, file.nodata) == (mosaic.crs, 0)
        assert set(np.unique(found)) == {0, 1, 2}
        assert file.colormap(1)[2] == (60, 120, 180, 255)
        area_m2 = np.count_nonzero(found == 2) * 0.2**2
        assert area_m2 == pytest.approx((EAST - WEST) * (NORTH - SOUTH), rel=0.1)
        rows, columns = np.nonzero(found == 2)
        east, north = mosaic.transform @ (columns.mean() + 0.5, rows.mean() + 0.5)
        longitude, latitude = rasterio.warp.transform(file.crs, 4326, [east], [north])
    place = texture.FRAME.to_enu(latitude, longitude, [60.0])[0]
    legend = json.loads((out / 'labels.json').read_text())['classes']
    assert [row['class'] for row in legend] == ['grass', 'lorry']
    assert legend[1]['area_m2'] == pytest.approx(area_m2, abs=0.01)
    assert place[:2] == pytest.approx(((WEST + EAST) / 2, (SOUTH + NORTH) / 2), abs=1.5)
