# SPDX-License-Identifier: Apache-2.0
"""The painted ground: the same everywhere and always, without seams and without repetition."""

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
from rocsafe_scene.ground.picture import GroundBounds
from rocsafe_scene.ground.procedural_ground import ProceduralGround, paint_tile
from rocsafe_scene.scenery.catalogue import SCENES, make_scene
from rocsafe_scene.scenery.marks import Paint, Placing, Shape, disc, polygon, stroke
from rocsafe_scene.scenery.noise import Window, fractal_at, lattice
from rocsafe_scene.scenery.scene import Scene, Thing

OCTAVES = {2: 1.0, 3: 0.7, 5: 0.5, 9: 1.0}
TINY_CAMERA = PinholeCamera(math.radians(60.0), 160, 120)


def thing(*marks: object, name: str = 'mark') -> Thing:
    """Return a thing that consists of `marks` on the ground."""
    return Thing(
        name=name,
        kind='mark',
        placing=Placing(0.0, 0.0),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(marks),
    )  # type: ignore[arg-type]


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


def test_ground_never_repeats() -> None:
    """No 2 m patch of turf looks like another one of the same size 2 m to 80 m away."""
    ground = ProceduralGround(3, make_scene('none', 3))
    patch = ground.patch(GroundBounds(west_m=0, south_m=0, east_m=80, north_m=40), 0.08)
    grey = cv2.cvtColor(patch.image, cv2.COLOR_BGR2GRAY)
    sample = grey[60:85, 70:95]
    match = cv2.matchTemplate(grey, sample, cv2.TM_CCOEFF_NORMED)
    match[40:80, 50:90] = 0.0
    assert match.max() < 0.7


@pytest.mark.parametrize('name', [name for name in SCENES if name != 'none'])
def test_scene_has_unique_names_and_shadows(name: str) -> None:
    """Things that are tall cast a shadow; the same seed makes the same scene."""
    scene = make_scene(name, 5)
    assert len({thing.name for thing in scene.things}) == len(scene.things) > 50
    assert all(thing.shadow for thing in scene.things if thing.size_m[2] > 0.0)
    assert [t.name for t in scene.things] == [t.name for t in make_scene(name, 5).things]


def test_scene_refuses_two_things_of_one_name() -> None:
    """Names are identities."""
    with pytest.raises(ValueError, match='twin'):
        Scene((thing(name='twin'), thing(name='twin')))


def test_unknown_scene_is_named() -> None:
    """The refusal lists what there is."""
    with pytest.raises(ValueError, match=r"'mars'.*derailment"):
        make_scene('mars', 1)


def test_tiles_are_the_same_in_every_process() -> None:
    """A fresh process paints the same bytes."""
    code = (
        'import hashlib\n'
        'from rocsafe_scene.ground.procedural_ground import paint_tile\n'
        'from rocsafe_scene.scenery.catalogue import make_scene\n'
        "print(hashlib.sha256(paint_tile(9, make_scene('derailment', 9), (3, 0, 0))).hexdigest())"
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
    own = hashlib.sha256(paint_tile(9, make_scene('derailment', 9), (3, 0, 0))).hexdigest()
    assert other.stdout.strip() == own


def test_tiles_fit_their_neighbours() -> None:
    """Across a tile's edge the scene goes on: a soft line has no step there."""
    line = stroke([[-5.0, 20.48], [5.0, 20.48]], 3.0, Paint((255, 255, 255), 0, 0.9, 0.3))
    scene = Scene((thing(line),))
    south, north = (paint_tile(1, scene, (2, 0, row)).astype(int) for row in (0, 1))
    middle = slice(0, 100)
    inside = np.abs(np.diff(south[-6:, middle], axis=0)).mean()
    across = np.abs(south[-1, middle] - north[0, middle]).mean()
    assert across < 1.5 * inside + 1.0


def test_cache_is_bounded() -> None:
    """Tiles are forgotten before they exceed the limit, and painted again the same."""
    ground = ProceduralGround(1, make_scene('none', 1), cache_bytes=3_000_000)
    here = GroundBounds(west_m=1.0, south_m=1.0, east_m=5.0, north_m=5.0)
    first = ground.patch(here, 0.05).image
    ground.patch(GroundBounds(west_m=100.0, south_m=1.0, east_m=170.0, north_m=5.0), 0.05)
    assert ground.held_bytes <= 3_000_000
    assert np.array_equal(ground.patch(here, 0.05).image, first)


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
    lens = GroundCamera(camera, ProceduralGround(6, make_scene(scene, 6)))
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


MARKER = Paint((255, 0, 255), 0)


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
    scene = Scene((thing(disc(place, 0.6, MARKER)),))
    image = GroundCamera(camera, ProceduralGround(4, scene)).photograph(position, rotation)
    rim = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    radii = 0.6 * np.sqrt(np.linspace(0.02, 1.0, 30))
    ground = place + np.array([[r * np.cos(a), r * np.sin(a)] for r in radii for a in rim])
    rays = (np.column_stack([ground, np.zeros(len(ground))]) - position) @ rotation
    pixels = (rays / rays[:, 2:]) @ camera.matrix.T
    assert np.abs(centre_of_marker(image) - pixels[:, :2].mean(axis=0)).max() < 0.1


def test_horizon_is_refused() -> None:
    """A camera that looks at the horizon has no flat-ground picture."""
    camera = GroundCamera(TINY_CAMERA, ProceduralGround(1, Scene(())))
    with pytest.raises(GroundError, match='horizon'):
        camera.photograph((0.0, 0.0, 30.0), rotation_enu_from_optical(0.0, 1.2))


def test_fine_texture_is_not_aliased() -> None:
    """Seen from far, stripes far below a pixel average out instead of beating."""
    stripes = tuple(
        polygon(
            [[x, -30.0], [x + 0.02, -30.0], [x + 0.02, 30.0], [x, 30.0]], Paint((255, 255, 255), 0)
        )
        for x in np.arange(-10.0, 10.0, 0.04).tolist()
    )
    dark = polygon([[-40, -40], [40, -40], [40, 40], [-40, 40]], Paint((0, 0, 0), 0))
    scene = Scene((thing(dark, *stripes),))
    camera = GroundCamera(TINY_CAMERA, ProceduralGround(1, scene))
    image = camera.photograph((0.0, 0.0, 9.0), rotation_enu_from_optical(0.0))
    middle = image[20:100, 20:140].astype(float)
    assert middle.std() < 12.0
    assert isinstance(stripes[0], Shape)
