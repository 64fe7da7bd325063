# SPDX-License-Identifier: Apache-2.0
"""Base maps that the operator brings."""

import sqlite3
import warnings
from contextlib import closing
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import rasterio
from PIL import Image
from pyproj import Transformer
from test.console.caller import Caller
from test.console.stage import ORIGIN, TOKEN, Stage, served

from rocsafe_console.errors import ConsoleError
from rocsafe_console.runs.base_map import MbTiles, open_base_map
from rocsafe_console.runs.raster_map import HALF_WORLD_M

pmtiles = pytest.importorskip('pmtiles.writer', reason='pmtiles is not installed')
RED, BLUE = (200, 30, 30), (30, 30, 200)


def make_map(path: Path, kind: str = 'png') -> Path:
    """Write an MBTiles file with one tile, in the north-west of zoom 1."""
    with sqlite3.connect(path) as file:
        file.execute('CREATE TABLE metadata (name text, value text)')
        file.execute(
            'CREATE TABLE tiles (zoom_level int, tile_column int, tile_row int, tile_data blob)'
        )
        file.execute("INSERT INTO metadata VALUES ('format', ?)", (kind,))
        file.execute("INSERT INTO metadata VALUES ('bounds', '-180,0,0,85')")
        file.execute('INSERT INTO tiles VALUES (1, 0, 1, ?)', (b'tile',))
    file.close()
    return path


def make_pmtiles(path: Path, kind: str = 'PNG') -> Path:
    """Write a PMTiles file with one tile, in the north-west of zoom 1."""
    from pmtiles.tile import Compression, TileType, zxy_to_tileid

    with path.open('wb') as file:
        writer = pmtiles.Writer(file)
        writer.write_tile(zxy_to_tileid(1, 0, 0), b'tile')
        header = {'tile_type': TileType[kind], 'tile_compression': Compression.NONE}
        edges = {'min_lon_e7': -1800000000, 'min_lat_e7': 0, 'max_lon_e7': 0}
        writer.finalize(
            {**header, **edges, 'max_lat_e7': 850000000, 'center_zoom': 1,
             'center_lon_e7': 0, 'center_lat_e7': 0},
            {'attribution': 'the county'},
        )  # fmt: skip
    return path


def make_raster(path: Path, crs: str = 'EPSG:32629', dtype: str = 'uint8', bands: int = 3) -> Path:
    """Write a GeoTIFF of 400 m about the origin of the stage: west half red, east half blue."""
    latitude, longitude = ORIGIN
    east, north = Transformer.from_crs('EPSG:4326', crs, always_xy=True).transform(
        longitude, latitude
    )
    pixels = np.zeros((bands, 200, 200), dtype)
    for band in range(min(bands, 3)):
        pixels[band, :, :100], pixels[band, :, 100:] = RED[band], BLUE[band]
    transform = rasterio.Affine(2.0, 0.0, east - 200.0, 0.0, -2.0, north + 200.0)
    with rasterio.open(
        path, 'w', driver='GTiff', width=200, height=200, count=bands, dtype=dtype, crs=crs,
        transform=transform,
    ) as file:  # fmt: skip
        file.write(pixels)
    return path


def colour_at(base, latitude: float, longitude: float, zoom: int) -> tuple[int, ...] | None:
    """Return red, green, blue and opacity of the base map at a place; None: no tile."""
    x, y = Transformer.from_crs('EPSG:4326', 'EPSG:3857', always_xy=True).transform(
        longitude, latitude
    )
    across = (x + HALF_WORLD_M) / (2 * HALF_WORLD_M) * 2**zoom
    down = (HALF_WORLD_M - y) / (2 * HALF_WORLD_M) * 2**zoom
    data = base.tile(zoom, int(across), int(down))
    if data is None:
        return None
    return Image.open(BytesIO(data)).getpixel((int(across % 1 * 256), int(down % 1 * 256)))


@pytest.mark.parametrize('make', [make_map, make_pmtiles])
def test_rows_are_counted_from_the_north(tmp_path, make):
    """As web maps do; MBTiles has them from the south."""
    base = open_base_map(make(tmp_path / 'a'))
    assert (base.zooms, base.content_type) == ((1, 1), 'image/png')
    assert base.bounds == (0.0, -180.0, 85.0, 0.0)
    assert base.tile(1, 0, 0) == b'tile'
    assert base.tile(1, 0, 1) is None
    assert base.tile(1, 5, 0) is None
    assert base.tile(99, 0, 0) is None


@pytest.mark.parametrize('crs', ['EPSG:32629', 'EPSG:2157', 'EPSG:3857'])
def test_a_raster_of_any_projection_lies_where_it_belongs(tmp_path, crs):
    """Red in the west, blue in the east of its middle, nothing beyond it; at each of its zooms."""
    base = open_base_map(make_raster(tmp_path / 'a.tif', crs))
    latitude, longitude = ORIGIN
    for zoom in range(base.zooms[1] - 1, base.zooms[1] + 1):
        assert colour_at(base, latitude, longitude - 6e-4, zoom) == (*RED, 255)
        assert colour_at(base, latitude, longitude + 6e-4, zoom) == (*BLUE, 255)
        outside = colour_at(base, latitude, longitude + 6e-3, zoom)
        assert outside is None or outside[3] == 0
    assert base.bounds[0] < latitude < base.bounds[2]
    # Its finest zoom resolves its pixels of 2 m, its coarsest shows it whole.
    pixel_m = 2 * HALF_WORLD_M / 256 / 2 ** base.zooms[1]
    scale = 1.0 if crs == 'EPSG:3857' else np.cos(np.radians(latitude))
    assert 0.9 <= pixel_m * scale <= 2.0
    assert base.zooms[0] < base.zooms[1]


@pytest.mark.parametrize('bands', [1, 4])
def test_a_grey_raster_and_one_with_opacity_are_shown(tmp_path, bands):
    """The fourth band hides what it says."""
    base = open_base_map(make_raster(tmp_path / 'a.tif', bands=bands))
    latitude, longitude = ORIGIN
    found = colour_at(base, latitude, longitude - 6e-4, base.zooms[1])
    if bands == 1:
        assert found == (200, 200, 200, 255)
    else:
        assert found is None or found[3] == 0


def test_what_is_no_map_is_told_in_one_line(tmp_path):
    """No file, another file, vector tiles, heights, pixels without a place, damage."""
    (tmp_path / 'text').write_text('no database')
    unplaced = tmp_path / 'unplaced.tif'
    with (
        warnings.catch_warnings(),
        rasterio.open(
            unplaced, 'w', driver='GTiff', width=4, height=4, count=3, dtype='uint8'
        ) as file,
    ):
        file.write(np.zeros((3, 4, 4), 'uint8'))
    cut = tmp_path / 'cut.pmtiles'
    cut.write_bytes(make_pmtiles(tmp_path / 'whole').read_bytes()[:90])
    cut_raster = tmp_path / 'cut.tif'
    cut_raster.write_bytes(unplaced.read_bytes()[:9])
    for path in (
        tmp_path / 'none', tmp_path, tmp_path / 'text', make_map(tmp_path / 'v', 'pbf'),
        make_pmtiles(tmp_path / 'vector', 'MVT'), unplaced, cut, cut_raster,
        make_raster(tmp_path / 'heights.tif', dtype='float32'),
        make_raster(tmp_path / 'two.tif', bands=2),
    ):  # fmt: skip
        with pytest.raises(ConsoleError, match=path.name) as error:
            open_base_map(path)
        assert '\n' not in str(error.value)


def test_a_damaged_map_has_holes_and_ends_nothing(tmp_path):
    """Each byte of a PMTiles file may be wrong: the file is refused, or a tile is missing."""
    whole = make_pmtiles(tmp_path / 'whole').read_bytes()
    path = tmp_path / 'damaged'
    for at in range(8, len(whole)):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :])
        try:
            base = open_base_map(path)
        except ConsoleError:
            continue
        found = base.tile(1, 0, 0)
        assert found is None or len(found) <= len(whole)


def test_damaged_mbtiles_have_holes_and_end_nothing(tmp_path):
    """Each piece of the file may be another one, also a number where the tile should be."""
    path = make_map(tmp_path / 'a.mbtiles')
    whole = path.read_bytes()
    for at in range(0, len(whole), 97):
        path.write_bytes(whole[:at] + b'\xff' * 97 + whole[at + 97 :])
        try:
            found = open_base_map(path).tile(1, 0, 0)
        except ConsoleError:
            continue
        assert found is None or len(found) <= len(whole)
    path.write_bytes(whole)
    with closing(sqlite3.connect(path)) as file:
        file.execute('UPDATE tiles SET tile_data = 1000000000')
        file.commit()
    base = open_base_map(path)
    assert [base.tile(*place) for place in ((1, 0, 0), (1, 10**30, 0), (31, 0, 0))] == [None] * 3


def test_the_page_gets_its_tiles(tmp_path):
    """And a transparent one where there is none, so that nothing fails."""
    stage = Stage(tmp_path)
    stage.context.base_map = MbTiles(make_map(tmp_path / 'a.mbtiles'))
    with served(stage) as address:
        caller = Caller(address)
        assert caller.ask('/api/base/1/0/0')[0] == 401
        caller.ask('/api/token', {'token': TOKEN})
        assert caller.ask('/api/base/1/0/0')[0] == 200
        assert caller.headers['Content-Type'] == 'image/png'
        assert caller.ask('/api/base/1/1/1')[0] == 200
        caller.ask('/static/main.js', **{'Accept-Encoding': 'gzip'})
        assert caller.headers['Content-Encoding'] == 'gzip'
        etag = caller.headers['ETag']
        assert caller.ask('/static/main.js', **{'If-None-Match': etag})[0] == 304
