# SPDX-License-Identifier: Apache-2.0
"""Scenes of real places: heights and colours from GeoTIFFs, clear refusals."""

import numpy as np
import pytest
from test.scene.scenes import FRAME

from rocsafe_scene.errors import SceneError
from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.ground.real_ground import draped, measured_heights
from rocsafe_scene.ground.terrain import make_terrain
from rocsafe_scene.scene.building import check
from rocsafe_scene.scene.scene_file import read_scene

rasterio = pytest.importorskip('rasterio')
pyproj = pytest.importorskip('pyproj')

CRS = 'EPSG:32629'
SLOPE_EAST, SLOPE_NORTH, LEVEL_M = 0.05, -0.02, 87.0
SCENE = """
name: real
place: {latitude_deg: 53.28, longitude_deg: -9.06, altitude_m: 60.0}
terrain: {dem: heights.tif, orthophoto: photo.tif}
objects:
  - {name: tank, make: tank_car, at: [100.0, 40.0]}
"""


def write(path, values, half_m, pixel_m):
    """Write bands (n, rows, columns), row 0 in the north, about the origin."""
    to_crs = pyproj.Transformer.from_crs('EPSG:4326', CRS, always_xy=True)
    x, y = to_crs.transform(-9.06, 53.28)
    transform = rasterio.transform.from_origin(x - half_m, y + half_m, pixel_m, pixel_m)
    count, rows, columns = values.shape
    with rasterio.open(
        path, 'w', driver='GTiff', width=columns, height=rows, count=count, dtype=values.dtype,
        crs=CRS, transform=transform,
    ) as file:  # fmt: skip
        file.write(values)


def grid(half_m, pixel_m):
    """Return east and north of pixel centres in the frame of the mission, (rows, columns)."""
    to_crs = pyproj.Transformer.from_crs('EPSG:4326', CRS, always_xy=True)
    x0, y0 = to_crs.transform(-9.06, 53.28)
    steps = np.arange(round(2 * half_m / pixel_m)) + 0.5
    x, y = np.meshgrid(x0 - half_m + steps * pixel_m, y0 + half_m - steps * pixel_m)
    longitude, latitude = to_crs.transform(x.ravel(), y.ravel(), direction='INVERSE')
    enu = FRAME.to_enu(latitude, longitude, np.full(x.size, 60.0))
    return enu[:, 0].reshape(x.shape), enu[:, 1].reshape(x.shape)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a sloping model, a striped photo and a scene of them."""
    path = tmp_path_factory.mktemp('place')
    east, north = grid(200.0, 2.0)
    heights = LEVEL_M + SLOPE_EAST * east + SLOPE_NORTH * north
    write(path / 'heights.tif', heights[None].astype('float32'), 200.0, 2.0)
    east, north = grid(60.0, 0.25)
    photo = np.stack([np.where(east > 0, 200, 20), np.where(north > 0, 180, 40), 0 * east + 90])
    write(path / 'photo.tif', photo.astype('uint8'), 60.0, 0.25)
    (path / 'real.yaml').write_text(SCENE)
    return path


def test_heights_are_those_of_the_model(folder):
    """About that of the origin; level beyond the rim, on the line to the origin."""
    terrain = make_terrain(measured_heights(str(folder / 'heights.tif'), FRAME))
    places = np.random.default_rng(1).uniform(-110.0, 110.0, (200, 2))
    expected = places @ np.array([SLOPE_EAST, SLOPE_NORTH])
    assert np.abs(terrain.height_at(places) - expected).max() < 0.02
    assert terrain.height_at(np.zeros((1, 2)))[0] == pytest.approx(0.0, abs=0.01)
    far = terrain.height_at(np.array([[450.0, 0.0], [3000.0, 0.0]]))
    assert far == pytest.approx(200.0 * SLOPE_EAST, abs=0.3)


def test_things_stand_on_the_model(folder):
    """A scene file names both, beside itself."""
    description = read_scene(folder / 'real.yaml')
    assert description.terrain.dem == str(folder / 'heights.tif')
    (tank,) = check(description)
    expected = 100.0 * SLOPE_EAST + 40.0 * SLOPE_NORTH
    assert tank.pieces[0].offset[2] == pytest.approx(expected, abs=0.05)


def test_the_photo_lies_where_it_belongs(folder):
    """East is red, north is green; beyond the photo the painted ground stays."""
    texel = 0.5
    colours = np.full((400, 400, 3), (1, 2, 3), np.uint8)
    painted = GroundMap(-100.0, -100.0, texel, colours, np.zeros((100, 100), np.uint8))
    found = draped(painted, str(folder / 'photo.tif'), FRAME)

    def at(east, north):
        return found.colours[int((north + 100.0) / texel), int((east + 100.0) / texel)].tolist()

    assert at(30.0, 30.0) == [90, 180, 200]
    assert at(-30.0, 30.0) == [90, 180, 20]
    assert at(30.0, -30.0) == [90, 40, 200]
    assert at(-80.0, 0.0) == [1, 2, 3]
    assert np.array_equal(colours[0, 0], (1, 2, 3))
    edge = [at(east, 30.0)[2] for east in (-1.0, 1.0)]
    assert edge == [20, 200]


@pytest.mark.parametrize(
    ('name', 'values', 'text'),
    [
        ('no.tif', None, 'no such file'),
        ('text.tif', b'hello', 'cannot be read'),
        ('small.tif', np.ones((1, 20, 20), 'float32'), 'must cover 143.36 m east and west'),
        ('photo.tif', np.ones((3, 400, 400), 'uint8'), 'must be one of heights'),
    ],
)
def test_a_bad_model_is_one_line(tmp_path, name, values, text):
    """Which file, what is wrong, what it must be."""
    path = tmp_path / name
    if isinstance(values, bytes):
        path.write_bytes(values)
    elif values is not None:
        write(path, values, 1.0 * values.shape[1], 2.0)
    with pytest.raises(SceneError, match=text) as caught:
        measured_heights(str(path), FRAME)
    assert str(caught.value).startswith(f'terrain.dem = {path}')
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('values', 'text'),
    [(None, 'No such file'), (np.ones((1, 80, 80), 'float32'), 'must have uint8')],
)
def test_a_bad_photo_is_one_line(tmp_path, values, text):
    """Which file, what is wrong, what it must be."""
    path = tmp_path / 'photo.tif'
    if values is not None:
        write(path, values, 40.0, 1.0)
    ground = GroundMap(
        -8.0, -8.0, 0.5, np.zeros((32, 32, 3), np.uint8), np.zeros((8, 8), np.uint8)
    )
    with pytest.raises(SceneError, match=text) as caught:
        draped(ground, str(path), FRAME)
    assert str(caught.value).startswith(f'terrain.orthophoto = {path}')
    assert '\n' not in str(caught.value)
