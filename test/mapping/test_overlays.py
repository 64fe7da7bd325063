# SPDX-License-Identifier: Apache-2.0
"""Tiles of a finished map lie where the map lies."""

import math
import sqlite3

import cv2
import numpy as np
import pytest
import rasterio
from pyproj import Transformer
from rasterio.transform import Affine

from rocsafe_mapping.products.cog import RGBA
from rocsafe_mapping.products.overlays import write_mbtiles

EPSG, WEST_M, NORTH_M, PIXEL_M, SIDE = 32629, 495_803.37, 5_903_412.61, 0.061, 500
WORLD_M = math.pi * 6_378_137.0


def spot(column: float, row: float) -> np.ndarray:
    """Return a picture of a soft spot about a place, integers being pixel edges."""
    x = np.arange(SIDE) + 0.5
    away = (x[np.newaxis, :] - column) ** 2 + (x[:, np.newaxis] - row) ** 2
    picture = np.full((4, SIDE, SIDE), 255, np.uint8)
    picture[:3] = (250.0 * np.exp(-away / (2.0 * 20.0**2))).astype(np.uint8)
    return picture


@pytest.fixture(scope='module')
def tiles(tmp_path_factory):
    """The tiles of a map of a spot."""
    return tiles_of(tmp_path_factory.mktemp('map'), PIXEL_M)


def tiles_of(folder, pixel_m: float) -> list:
    """Return the tiles of a map of a spot, whose pixels are so wide."""
    profile = {
        'driver': 'GTiff', 'width': SIDE, 'height': SIDE, 'count': 4, 'dtype': 'uint8',
        'crs': f'EPSG:{EPSG}', 'transform': Affine(pixel_m, 0, WEST_M, 0, -pixel_m, NORTH_M),
    }  # fmt: skip
    with rasterio.open(folder / 'm.tif', 'w', **profile) as file:
        file.colorinterp = RGBA
        file.write(spot(240.0, 260.0))
    write_mbtiles(folder / 'm.tif', folder / 'm.mbtiles')
    with sqlite3.connect(folder / 'm.mbtiles') as file:
        return file.execute(
            'SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles'
        ).fetchall()


def middle_px(tiles: list, zoom: int) -> np.ndarray:
    """Return where the spot's middle is seen, in pixels of the world at a zoom."""
    total, moment = 0.0, np.zeros(2)
    for level, column, row, png in tiles:
        if level == zoom:
            gray = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_GRAYSCALE)
            weight = np.where(gray > 40, gray, 0).astype(float)
            rows, columns = np.nonzero(weight)
            values = weight[rows, columns]
            north = (1 << zoom) - 1 - row
            places = np.column_stack([columns + 0.5 + 256 * column, rows + 0.5 + 256 * north])
            total, moment = total + values.sum(), moment + values @ places
    return moment / total


@pytest.mark.parametrize('coarser', [0, 1, 2])
def test_tiles_lie_where_the_map_lies(tiles, coarser):
    """To a tenth of a pixel, at the finest zoom and at those made of it."""
    zoom = max(tile[0] for tile in tiles) - coarser
    to_web = Transformer.from_crs(EPSG, 3857, always_xy=True)
    east, north = to_web.transform(WEST_M + 240 * PIXEL_M, NORTH_M - 260 * PIXEL_M)
    true = np.array([east + WORLD_M, WORLD_M - north]) / (2.0 * WORLD_M / 256 / 2**zoom)
    assert np.abs(middle_px(tiles, zoom) - true).max() < 0.1


def test_pixels_too_fine_for_tiles_give_coarser_tiles(tmp_path):
    """A drone a few metres above the ground sees millimetres; GDAL knows 22 zooms."""
    assert max(tile[0] for tile in tiles_of(tmp_path, 0.004)) == 22
