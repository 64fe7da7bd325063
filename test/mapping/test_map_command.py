# SPDX-License-Identifier: Apache-2.0
"""`rocsafe map` makes a map of anyone's photographs."""

import dataclasses
import importlib.util
import json
import pathlib
import sqlite3

import numpy as np
import pytest
import rasterio
import rasterio.warp
from test.small_file_system import small_file_system

from rocsafe_mapping.command_line.map_command import EXIT_FAILED, EXIT_OK, EXIT_REFUSED, main
from rocsafe_mapping.photographs.exif import with_exif
from rocsafe_mapping.store.photograph_files import photographs_of

pytestmark = pytest.mark.slow

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """A folder of photographs with Exif, mapped."""
    folder = tmp_path_factory.mktemp('photographs')
    for shot in texture.flight(6):
        path = folder / f'DJI_{shot.record.sequence:04d}.JPG'
        path.write_bytes(with_exif(shot.jpeg, shot.record))
    (folder / 'broken.jpg').write_bytes(b'\xff\xd8 no picture')
    assert main([str(folder), '--resolution', '0.2']) == EXIT_OK
    return folder / 'map'


def test_geotiff_is_georeferenced_and_tiled(folder):
    """The GeoTIFF has a UTM zone, tiles, overviews and a mask, and lies where the flight was."""
    with rasterio.open(folder / 'mosaic.tif') as file:
        assert file.crs.to_epsg() == 32629
        assert file.block_shapes[0] == (512, 512)
        assert file.tags(ns='IMAGE_STRUCTURE')['LAYOUT'] == 'COG'
        mask = file.dataset_mask()
        assert 0.2 < np.mean(mask > 0) <= 1.0
        east, north = file.transform @ (file.width / 2, file.height / 2)
        longitude, latitude = rasterio.warp.transform(file.crs, 4326, [east], [north])
        place = texture.FRAME.to_enu(latitude, longitude, [60.0])[0]
        assert np.hypot(*place[:2]) < 3.0


def test_heights_that_no_tag_tells_come_from_the_fixes(folder):
    """The tags tell altitudes of 92 m above sea only; the map is as large as the fixes are far."""
    quality = json.loads((folder / 'quality.json').read_text())
    # Six photographs of 37 m x 28 m, 22 m and 17 m apart: 3.5 thousand square metres.
    assert quality['coverage']['shown_m2'] == pytest.approx(3500.0, rel=0.15)


def test_quality_tells_what_was_measured(folder):
    """The quality document counts photographs, states its error, and the page shows it."""
    quality = json.loads((folder / 'quality.json').read_text())
    assert quality['photographs'] == {
        'total': 6,
        'placed_by_features': 6,
        'placed_by_gps': [],
    }
    assert quality['held_out_ties']['px']['median'] < 0.3
    assert quality['stated_error_m']['rms'] > 0.0
    assert all(tile['placed_by'] == 'features' for tile in quality['tiles'])
    assert 'Georeferenced' in (folder / 'quality.html').read_text()


def test_overlays_lie_where_the_map_lies(folder):
    """World file, KML and MBTiles describe the same place."""
    lines = [float(line) for line in (folder / 'mosaic.pgw').read_text().split()]
    with rasterio.open(folder / 'mosaic.tif') as file:
        half = lines[0] / 2
        assert lines[4] - half == pytest.approx(file.transform.c, abs=1e-3)
        assert lines[5] + half == pytest.approx(file.transform.f, abs=1e-3)
    assert 'LatLonQuad' in (folder / 'mosaic.kml').read_text()
    assert (folder / 'mosaic.pmtiles').read_bytes()[:8] == b'PMTiles\x03'
    with sqlite3.connect(folder / 'mosaic.mbtiles') as tiles:
        assert tiles.execute('SELECT COUNT(*) FROM tiles').fetchone()[0] > 1


def test_map_of_too_few_photographs_is_made_but_not_trusted(tmp_path, capsys):
    """A single photograph gives a map and exit code 1 with the reason."""
    shot = texture.flight(6)[0]
    (tmp_path / 'a.jpg').write_bytes(with_exif(shot.jpeg, shot.record))
    assert main([str(tmp_path), '--only-geotiff', '-o', str(tmp_path / 'out')]) == EXIT_FAILED
    assert 'not to be called georeferenced' in capsys.readouterr().out
    assert (tmp_path / 'out' / 'mosaic.tif').exists()


def test_odd_files_are_one_line_each(tmp_path, capsys):
    """A copy, a name with control characters, a focal length that no lens has."""
    shots = texture.flight(6)
    for number, shot in enumerate(shots):
        camera = shot.record.camera
        if number == 5:
            camera = dataclasses.replace(camera, fx_px=1e6, fy_px=1e6)
        record = dataclasses.replace(shot.record, camera=camera)
        (tmp_path / f'{number}.jpg').write_bytes(with_exif(shot.jpeg, record))
    (tmp_path / 'copy.jpg').write_bytes((tmp_path / '2.jpg').read_bytes())
    (tmp_path / 'a\nb\x1b[31m.jpg').write_bytes(b'no picture')
    main([str(tmp_path), '--only-geotiff'])
    found = capsys.readouterr()
    lines = found.err.splitlines()
    assert len(lines) == 3
    assert 'a\\nb\\x1b[31m.jpg: it is no picture' in lines[1]
    assert '5.jpg: a focal length of 2.5e+03 image widths is not from 0.2 to 50' in lines[0]
    assert lines[2] == 'not on the map: copy.jpg: the same file as 2.jpg'
    assert '5 photographs' in found.out


def test_a_full_disk_is_refused(tmp_path, capsys):
    """No traceback of GDAL's, whichever file does not fit."""
    shots = texture.flight(6)
    for number, shot in enumerate(shots):
        (tmp_path / f'{number}.jpg').write_bytes(with_exif(shot.jpeg, shot.record))
    with small_file_system(tmp_path / 'disk', megabytes=1) as disk:
        assert main([str(tmp_path), '-o', str(disk)]) == EXIT_REFUSED
        assert not [path for path in disk.iterdir() if path.name == 'mosaic.tif']
    assert 'error: cannot write map' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('fix', 'is_known'), [((0.0, 0.0), False), ((0.0, 9.0), True), ((9.0, 0.0), True)]
)
def test_zero_zero_is_no_fix(tmp_path, fix, is_known):
    """Many cameras write it while their receiver has none."""
    shot = texture.flight(6)[0]
    record = dataclasses.replace(shot.record, latitude_deg=fix[0], longitude_deg=fix[1])
    (tmp_path / 'a.jpg').write_bytes(with_exif(shot.jpeg, record))
    (found,) = photographs_of(tmp_path, pytest.fail)
    assert found.record.has_fix is is_known


def test_folder_without_photographs_is_refused(tmp_path, capsys):
    """An empty or missing folder is one clear line."""
    assert main([str(tmp_path)]) == EXIT_REFUSED
    assert main([str(tmp_path / 'missing')]) == EXIT_REFUSED
    errors = capsys.readouterr().err
    assert errors.count('error: ') == 2
    assert 'Traceback' not in errors


@pytest.mark.parametrize(
    ('arguments', 'reason'),
    [
        (['--labels', 'nowhere'], 'nowhere: has no PNG named like a photograph'),
        (['-o', '/dev/null/map'], 'cannot write to /dev/null/map'),
        (['--resolution', '1e9'], 'must be at most'),
        (['--max-pixels', '1'], 'max_pixels = 1 must be at least 10000'),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(tmp_path, capsys, arguments, reason):
    """Each was taken in silence, found after all the work, or told in warnings."""
    for shot in texture.flight(6)[:2]:
        path = tmp_path / f'{shot.record.sequence}.jpg'
        path.write_bytes(with_exif(shot.jpeg, shot.record))
    assert main([str(tmp_path), '--only-geotiff', *arguments]) == EXIT_REFUSED
    (line,) = capsys.readouterr().err.splitlines()
    assert reason in line
