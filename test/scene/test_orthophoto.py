# SPDX-License-Identifier: Apache-2.0
"""The ground from a GeoTIFF: right place in any coordinate system, clear refusals."""

import math
from pathlib import Path

import numpy as np
import pytest

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.cameras.ground_camera import GroundCamera
from rocsafe_scene.errors import GroundError
from rocsafe_scene.ground.orthophoto import OrthophotoGround

rasterio = pytest.importorskip('rasterio')
pyproj = pytest.importorskip('pyproj')

FRAME = LocalFrame(GeoPosition(53.28, -9.06, 50.0))
DOT_ENU = (6.3, -4.7)


def write_photo(path: Path, crs: str, pixel: float, size: int = 400, bands: int = 3) -> None:
    """Write a black photo about the origin with one white disc of 1.5 m at `DOT_ENU`."""
    to_crs = pyproj.Transformer.from_crs('EPSG:4326', crs, always_xy=True)
    x0, y0 = to_crs.transform(-9.06, 53.28)
    columns, rows = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5)
    x, y = x0 + (columns - size / 2) * pixel, y0 - (rows - size / 2) * pixel
    longitudes, latitudes = to_crs.transform(x.ravel(), y.ravel(), direction='INVERSE')
    enu = FRAME.to_enu(latitudes, longitudes, np.full(size * size, 50.0))
    near = np.hypot(enu[:, 0] - DOT_ENU[0], enu[:, 1] - DOT_ENU[1]).reshape(size, size) < 1.5
    transform = rasterio.transform.from_origin(
        x0 - size / 2 * pixel, y0 + size / 2 * pixel, pixel, pixel
    )
    with rasterio.open(
        path,
        'w',
        driver='GTiff',
        width=size,
        height=size,
        count=bands,
        dtype='uint8',
        crs=crs,
        transform=transform,
    ) as file:
        for band in range(1, bands + 1):
            file.write((near * 255).astype('uint8'), band)


@pytest.mark.parametrize(
    ('crs', 'pixel', 'bands'),
    [
        ('EPSG:32629', 0.1, 3),
        ('EPSG:2157', 0.12, 1),
        ('EPSG:4326', 1e-6, 4),
        ('EPSG:3857', 0.15, 3),
    ],
)
@pytest.mark.filterwarnings('ignore::rasterio.errors.NotGeoreferencedWarning')
def test_photo_lies_where_its_coordinates_say(
    tmp_path: Path, crs: str, pixel: float, bands: int
) -> None:
    """A disc in the photo is seen where its local position projects to, within 0.3 px."""
    path = tmp_path / 'photo.tif'
    write_photo(path, crs, pixel, bands=bands)
    camera = PinholeCamera(math.radians(50.0), 320, 240)
    rotation = rotation_enu_from_optical(0.7, 0.03, -0.02)
    position = (4.0, -3.0, 12.0)
    image = GroundCamera(camera, OrthophotoGround(path, FRAME)).photograph(position, rotation)
    weight = image.astype(float).mean(axis=2)
    rows, columns = np.indices(weight.shape)
    seen = np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()
    ray = rotation.T @ (np.array([*DOT_ENU, 0.0]) - position)
    expected = (camera.matrix @ (ray / ray[2]))[:2]
    assert np.abs(seen - expected).max() < 0.3


def test_beyond_the_photo_is_black(tmp_path: Path) -> None:
    """A flight that leaves the photo goes on and sees nothing."""
    path = tmp_path / 'photo.tif'
    write_photo(path, 'EPSG:32629', 0.1, size=40)
    camera = GroundCamera(PinholeCamera(1.0, 64, 48), OrthophotoGround(path, FRAME))
    image = camera.photograph((500.0, 0.0, 10.0), rotation_enu_from_optical(0.0))
    assert not image.any()


def test_photo_of_another_place_is_refused(tmp_path: Path) -> None:
    """A photo that does not show the mission's origin is the wrong one."""
    path = tmp_path / 'photo.tif'
    write_photo(path, 'EPSG:32629', 0.1, size=40)
    with pytest.raises(GroundError, match=r'photo\.tif: does not show the mission origin'):
        OrthophotoGround(path, LocalFrame(GeoPosition(53.28, -9.05, 0.0)))


@pytest.mark.filterwarnings('ignore::rasterio.errors.NotGeoreferencedWarning')
def test_unusable_files_are_named(tmp_path: Path) -> None:
    """Missing, not an image, without coordinates: one line with the path."""
    text = tmp_path / 'text.tif'
    text.write_text('no image')
    bare = tmp_path / 'bare.tif'
    with rasterio.open(bare, 'w', driver='GTiff', width=4, height=4, count=1, dtype='uint8'):
        pass
    for path in (tmp_path / 'absent.tif', text, bare):
        with pytest.raises(GroundError, match=path.name):
            OrthophotoGround(path, FRAME)
