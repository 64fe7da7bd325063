# SPDX-License-Identifier: Apache-2.0
"""The ground of flat scenes: photograph and meadow, and how a camera sees them."""

import hashlib
import math
import subprocess
import sys

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.pinhole import PinholeCamera, ground_homography, rotation_enu_from_optical
from rocsafe_scene.cameras.ground_camera import GroundCamera
from rocsafe_scene.errors import GroundError
from rocsafe_scene.flat_ground.ground_photograph import (
    FADING_M,
    SCENE_NAMES,
    GroundPhotograph,
    read_boxes,
    read_photograph,
    write_photograph,
)
from rocsafe_scene.flat_ground.meadow import TILE_PX, Meadow, paint_tile, tone_table
from rocsafe_scene.flat_ground.scene_box import SceneBox
from rocsafe_scene.flat_ground.scene_ground import SceneGround
from rocsafe_scene.ground.ground_patch import GroundBounds
from rocsafe_scene.mesh.classes import CLASSES
from rocsafe_scene.painting.noise import Window, fractal_at, lattice
from rocsafe_scene.scene.sunlight import lighting

OCTAVES = {2: 1.0, 3: 0.7, 5: 0.5, 9: 1.0}
TINY_CAMERA = PinholeCamera(math.radians(60.0), 160, 120)
TEXEL_M = 0.05


def black_photograph(side_m: float = 80.0) -> GroundPhotograph:
    """Return a square photograph of nothing."""
    side = round(side_m / TEXEL_M)
    return GroundPhotograph(np.zeros((side, side, 3), np.uint8), TEXEL_M)


@settings(max_examples=20, deadline=None)
@given(st.integers(-3000, 3000), st.integers(-3000, 3000), st.sampled_from([0, 2, 4]))
def test_noise_has_no_seams(x: int, y: int, octave: int) -> None:
    """A window's values are those of every larger window around it."""
    inner = Window(x, y, x + 24, y + 17)
    outer = Window(x - 37, y - 5, x + 51, y + 40)
    large = fractal_at(7, OCTAVES, octave, outer)
    small = fractal_at(7, OCTAVES, octave, inner)
    assert np.allclose(large[5:22, 37:61], small, atol=1e-5)


def test_lattice_values_are_spread_evenly() -> None:
    """Hashed values are uniform, uncorrelated between neighbours, and differ with the seed."""
    values = lattice(1, 3, Window(-200, -200, 200, 200))
    assert abs(values.mean()) < 0.01
    assert values.std() == pytest.approx(1.0 / math.sqrt(3.0), abs=0.01)
    for other in (values[1:, 1:], lattice(2, 3, Window(-199, -199, 200, 200))):
        assert abs(np.corrcoef(values[:-1, :-1].ravel(), other.ravel())[0, 1]) < 0.01


def test_meadow_never_repeats() -> None:
    """No 2 m patch of grass looks like another one of the same size 2 m to 80 m away."""
    patch = Meadow(3).patch(GroundBounds(west_m=0, south_m=0, east_m=80, north_m=40), 0.08)
    grey = cv2.cvtColor(patch.image, cv2.COLOR_BGR2GRAY)
    sample = grey[60:85, 70:95]
    match = cv2.matchTemplate(grey, sample, cv2.TM_CCOEFF_NORMED)
    match[40:80, 50:90] = 0.0
    assert match.max() < 0.7


def test_tiles_are_the_same_in_every_process() -> None:
    """A fresh process paints the same bytes."""
    code = (
        'import hashlib\n'
        'from rocsafe_scene.flat_ground.meadow import paint_tile\n'
        'print(hashlib.sha256(paint_tile(9, (3, 0, 0))).hexdigest())'
    )
    env = {'PYTHONPATH': ':'.join(sys.path), 'PYTHONHASHSEED': '99'}
    other = subprocess.run(
        [sys.executable, '-c', code],
        env=env,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert other.stdout.strip() == hashlib.sha256(paint_tile(9, (3, 0, 0))).hexdigest()


def test_tiles_fit_their_neighbours() -> None:
    """Across the edge of a tile grass changes no more than within it."""
    south, north = (paint_tile(1, (2, 0, row)).astype(int) for row in (0, 1))
    assert south.shape == (TILE_PX, TILE_PX, 3)
    inside = np.abs(np.diff(south[-6:], axis=0)).mean()
    across = np.abs(south[-1] - north[0]).mean()
    assert across < 1.5 * inside + 1.0


def test_cache_is_bounded() -> None:
    """Tiles are dropped before they exceed the limit, and painted again the same."""
    meadow = Meadow(1, cache_bytes=3_000_000)
    here = GroundBounds(west_m=1.0, south_m=1.0, east_m=5.0, north_m=5.0)
    first = meadow.patch(here, 0.05).image
    meadow.patch(GroundBounds(west_m=100.0, south_m=1.0, east_m=170.0, north_m=5.0), 0.05)
    assert meadow.held_bytes <= 3_000_000
    assert np.array_equal(meadow.patch(here, 0.05).image, first)


def test_light_brightens_what_is_painted_brighter() -> None:
    """Black stays black, tones rise with the paint, and fall with a lower sun."""
    noon, evening = (
        tone_table(lighting(np.array([math.sqrt(1.0 - up * up), 0.0, up]), 'clear'))[0]
        for up in (0.9, 0.3)
    )
    assert not noon[0].any()
    assert (np.diff(noon.astype(int), axis=0) >= 0).all()
    assert (noon[128] > evening[128]).all()


@pytest.mark.parametrize('scene', [name for name in SCENE_NAMES if name != 'none'])
def test_scenes_come_with_a_photograph_and_boxes(scene: str) -> None:
    """The boxes have classes, lie on the photograph and are no larger than it."""
    photograph, boxes = read_photograph(scene), read_boxes(scene)
    assert photograph is not None
    half = np.array(photograph.half_m)
    assert len(boxes) > 100
    for box in boxes:
        assert box.label in CLASSES
        assert (np.abs(box.position_enu[:2]) <= half).all()
        assert 0.8 <= max(box.size_m) < 2.0 * half.max()
        assert np.linalg.norm(box.quaternion) == pytest.approx(1.0, abs=1e-4)


def test_boxes_stand_where_the_photograph_shows_them() -> None:
    """At the ambulances there is yellow, which is nowhere else around them."""
    photograph = read_photograph('derailment')
    assert photograph is not None
    places = [b.position_enu for b in read_boxes('derailment') if b.label == 'ambulance']
    assert len(places) == 2
    for east, north, _ in places:
        bounds = GroundBounds(
            west_m=east - 3.0, south_m=north - 3.0, east_m=east + 3.0, north_m=north + 3.0
        )
        blue, green, red = np.moveaxis(photograph.patch(bounds, 0.06).image.astype(int), -1, 0)
        assert ((red > 150) & (green > 150) & (blue < 90)).sum() > 100


def test_a_photograph_is_read_as_it_was_written(tmp_path, monkeypatch) -> None:
    """Pixels within the loss of JPEG, boxes exactly."""
    image = np.full((48, 64, 3), (40, 120, 200), np.uint8)
    box = SceneBox(
        name='drum',
        label='drum',
        position_enu=(1.0, -2.0, 0.45),
        quaternion=(0.0, 0.0, 0.0, 1.0),
        size_m=(0.6, 0.6, 0.9),
    )
    write_photograph(tmp_path / 'place.jpg', GroundPhotograph(image, 0.25), (box,), 95)
    monkeypatch.setattr('rocsafe_scene.flat_ground.ground_photograph.FOLDER', tmp_path)
    read = read_photograph('place')
    assert read is not None
    assert read.half_m == (8.0, 6.0)
    assert np.abs(read.image.astype(int) - image).max() <= 3
    assert read_boxes('place') == (box,)
    with pytest.raises(GroundError, match='mars'):
        read_photograph('mars')


def test_flat_ground_needs_neither_the_engine_nor_what_builds_scenes() -> None:
    """Vehicles start in a moment, and without EGL."""
    code = (
        'import sys\n'
        'import rocsafe_scene.flat_ground.scene_ground\n'
        "slow = ('panda3d', 'scipy.spatial', 'pydantic', 'shapely', 'rasterio')\n"
        'print([name for name in slow if name in sys.modules])'
    )
    env = {'PYTHONPATH': ':'.join(sys.path)}
    found = subprocess.run(
        [sys.executable, '-c', code],
        env=env,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert found.stdout.strip() == '[]'


def test_no_scene_is_meadow_without_boxes() -> None:
    """`none` has neither photograph nor boxes."""
    assert read_photograph('none') is None
    assert read_boxes('none') == ()


def test_photograph_fades_into_the_meadow() -> None:
    """Inside it is the photograph alone, outside the meadow alone, between a mixture."""
    ground, meadow = SceneGround(black_photograph(), 3), Meadow(3)
    bounds = GroundBounds(west_m=20.0, south_m=-5.0, east_m=60.0, north_m=5.0)
    seen, grass = ground.patch(bounds, 0.16), meadow.patch(bounds, 0.16)
    east = (np.arange(seen.image.shape[1]) - seen.pixel_from_ground[0, 2]) * 0.16
    row = round(seen.pixel_from_ground[1, 2])
    line, below = seen.image[row].astype(float), grass.image[row].astype(float)
    assert not line[east < 40.0 - FADING_M].any()
    assert np.array_equal(line[east > 40.0], below[east > 40.0])
    half_way = np.abs(east - (40.0 - 0.5 * FADING_M)) < 0.5
    assert line[half_way].mean() == pytest.approx(0.5 * below[half_way].mean(), rel=0.1)


def test_no_bounds_without_extent() -> None:
    """West lies west of east."""
    with pytest.raises(ValueError, match='west < east'):
        GroundBounds(west_m=2.0, south_m=0.0, east_m=2.0, north_m=1.0)


@pytest.mark.parametrize(('scene', 'east'), [('none', 40.0), ('derailment', 20.0)])
def test_overlapping_photographs_can_be_matched(scene: str, east: float) -> None:
    """With 40 % overlap nearly all ORB matches are right: the ground does not repeat itself.

    Repeating tiles gave 0 % right matches at this overlap, and plenty of key points.
    """
    camera = PinholeCamera(math.radians(60.0), 640, 480)
    lens = GroundCamera(camera, SceneGround(read_photograph(scene), 6))
    places = ((east, 3.0, 32.0), (east + 22.0, 4.0, 32.0))
    rotations = rotation_enu_from_optical(1.57), rotation_enu_from_optical(1.67, 0.02, -0.01)
    views = [lens.photograph(p, r) for p, r in zip(places, rotations, strict=True)]
    first, second = (
        ground_homography(camera, p, r) for p, r in zip(places, rotations, strict=True)
    )
    finder = cv2.ORB.create(3000)
    (keys, values), (other_keys, other_values) = (finder.detectAndCompute(v, None) for v in views)
    pairs = cv2.BFMatcher(cv2.NORM_HAMMING).knnMatch(values, other_values, k=2)
    good = [pair[0] for pair in pairs if pair[0].distance < 0.8 * pair[1].distance]
    seen = np.array([[*keys[m.queryIdx].pt, 1.0] for m in good])
    expected = seen @ (second @ np.linalg.inv(first)).T
    expected = expected[:, :2] / expected[:, 2:]
    error = np.linalg.norm([other_keys[m.trainIdx].pt for m in good] - expected, axis=1)
    assert len(good) > 150
    assert (error < 2.0).mean() > 0.85


def marked_photograph(place: np.ndarray, radius_m: float) -> GroundPhotograph:
    """Return a black photograph with a magenta disc."""
    photograph = black_photograph()
    rows, columns = photograph.image.shape[:2]
    centre = ((0.5 * columns + place[0] / TEXEL_M) - 0.5, (0.5 * rows - place[1] / TEXEL_M) - 0.5)
    fixed = tuple(round(64 * at) for at in centre)
    radius = round(64 * radius_m / TEXEL_M)
    cv2.circle(photograph.image, fixed, radius, (255, 0, 255), -1, cv2.LINE_AA, 6)
    return photograph


def centre_of_marker(image: np.ndarray) -> np.ndarray:
    """Return the centroid (u, v) of the magenta in an image."""
    blue, green, red = (image[..., part].astype(float) for part in range(3))
    weight = np.clip(np.minimum(blue, red) - green - 60.0, 0.0, None)
    rows, columns = np.indices(weight.shape)
    return np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()


@pytest.mark.parametrize('yaw_deg', [0.0, 77.0, -150.0])
@pytest.mark.parametrize('tilt_deg', [(0.0, 0.0), (4.0, -3.0), (-12.0, 9.0)])
def test_ground_points_are_seen_where_the_pinhole_says(
    yaw_deg: float, tilt_deg: tuple[float, float]
) -> None:
    """A painted disc's centroid lies within 0.1 px of its projected centroid."""
    camera = PinholeCamera(math.radians(60.0), 640, 480)
    position = (3.0, -8.0, 32.0)
    rotation = rotation_enu_from_optical(math.radians(yaw_deg), *np.radians(tilt_deg))
    ray = rotation @ np.array([0.21, -0.17, 1.0])
    place = np.array(position[:2]) - ray[:2] / ray[2] * position[2]
    ground = SceneGround(marked_photograph(place, 0.6), 4)
    image = GroundCamera(camera, ground).photograph(position, rotation)
    rim = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    radii = 0.6 * np.sqrt(np.linspace(0.02, 1.0, 30))
    ground = place + np.array([[r * np.cos(a), r * np.sin(a)] for r in radii for a in rim])
    rays = (np.column_stack([ground, np.zeros(len(ground))]) - position) @ rotation
    pixels = (rays / rays[:, 2:]) @ camera.matrix.T
    assert np.abs(centre_of_marker(image) - pixels[:, :2].mean(axis=0)).max() < 0.1


def test_horizon_is_refused() -> None:
    """A camera that looks at the horizon has no flat-ground picture."""
    camera = GroundCamera(TINY_CAMERA, SceneGround(None, 1))
    with pytest.raises(GroundError, match='horizon'):
        camera.photograph((0.0, 0.0, 30.0), rotation_enu_from_optical(0.0, 1.2))


def test_fine_texture_is_not_aliased() -> None:
    """Seen from far, stripes far below a pixel average out instead of beating."""
    image = np.zeros((1600, 1600, 3), np.uint8)
    image[:, ::2] = 255
    ground = SceneGround(GroundPhotograph(image, 0.05), 1)
    camera = GroundCamera(TINY_CAMERA, ground)
    seen = camera.photograph((0.0, 0.0, 45.0), rotation_enu_from_optical(0.0))
    middle = seen[20:100, 20:140].astype(float)
    assert middle.std() < 12.0
    assert middle.mean() == pytest.approx(127.5, abs=2.0)
