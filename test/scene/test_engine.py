# SPDX-License-Identifier: Apache-2.0
"""The engine's pictures: exact geometry and labels, the same bytes from the same pose."""

import math
import threading

import numpy as np
import pytest
from test.scene.ray_scene import RayScene
from test.scene.scenes import PLANT, THINGS, small_environment

from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_scene.errors import EngineError
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.scene.environment import GROUND_NUMBER
from rocsafe_scene.scene.sunlight import lighting, sun_direction

pytest.importorskip('panda3d', reason='panda3d is not installed')
from rocsafe_scene.engine.renderer import Renderer
from rocsafe_scene.graphics.lens import looking
from rocsafe_scene.graphics.rendering import Purpose

LENS = PinholeCamera(math.radians(60.0), 240, 180)
NADIR = (np.array([0.5, -1.0, 32.0]), rotation_enu_from_optical(0.3, 0.05, -0.03))
OBLIQUE_EYE = np.array([-22.0, -26.0, 14.0])
OBLIQUE = (OBLIQUE_EYE, looking(np.array([0.0, -1.0, 1.0]) - OBLIQUE_EYE))
# Every third pixel in both directions is checked.
STEP = 3
# Metres; depth comes as a 32 bit float from a rasteriser of 24 bit depth.
DEPTH_LIMIT_M = 0.01


@pytest.fixture(scope='module')
def environment():
    """Return a handful of things and a tree on rolling ground."""
    return small_environment(*THINGS, PLANT)


@pytest.fixture(scope='module')
def renderer(environment, drawing):
    """Return a renderer of it."""
    time = environment.description.light.time
    return Renderer(environment, lighting(sun_direction(time, 53.28, -9.06), 'clear'))


@pytest.fixture(scope='module')
def eye(renderer):
    """Return a camera of it."""
    return renderer.camera(LENS)


def rays_of(position, rotation):
    """Return origins, unit directions and their cosines with the view, of every third pixel."""
    v, u = np.mgrid[0 : LENS.image_height_px : STEP, 0 : LENS.image_width_px : STEP]
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(u.size)])
    optical = np.linalg.solve(LENS.matrix, pixels).T
    length = np.linalg.norm(optical, axis=1)
    directions = optical @ rotation.T / length[:, None]
    return np.broadcast_to(position, directions.shape), directions, 1.0 / length


def off_silhouettes(numbers):
    """Return whether a pixel's neighbours all show the same thing as itself."""
    padded = np.pad(numbers, 1, mode='edge')
    same = np.ones(numbers.shape, bool)
    for row in range(3):
        for column in range(3):
            part = padded[row : row + numbers.shape[0], column : column + numbers.shape[1]]
            same &= part == numbers
    return same


@pytest.mark.slow
@pytest.mark.parametrize('pose', [NADIR, OBLIQUE], ids=['nadir', 'oblique'])
def test_labels_and_depth_agree_with_ray_casting(environment, eye, pose):
    """Off silhouettes at least 99.99 % of the ids are right; depth p99.9 within 1 cm."""
    frame = eye.expose(*pose)
    origins, directions, cosines = rays_of(*pose)
    hits = RayScene(environment).first_hits(origins, directions)
    numbers, depth = frame.numbers[::STEP, ::STEP], frame.depth_m[::STEP, ::STEP]
    truth = hits.numbers.reshape(numbers.shape)
    clear = off_silhouettes(frame.numbers)[::STEP, ::STEP]
    assert clear.mean() > 0.7
    assert len(np.unique(truth[clear])) >= 5
    assert np.mean(numbers[clear] == truth[clear]) >= 0.9999
    expected = (hits.distances_m * cosines).reshape(numbers.shape)
    is_leafless = frame.classes[::STEP, ::STEP] != class_number('tree')
    near = clear & is_leafless & (numbers > 0) & (expected < 40.0)
    error = np.abs(depth[near] - expected[near])
    assert np.quantile(error, 0.999) <= DEPTH_LIMIT_M


@pytest.mark.slow
def test_sky_has_number_0_and_no_depth(eye):
    """Above the horizon there is nothing."""
    frame = eye.expose(np.array([0.0, 0.0, 20.0]), looking(np.array([1.0, 0.2, 0.5])))
    is_sky = frame.numbers == 0
    assert is_sky.mean() > 0.5
    assert np.isinf(frame.depth_m[is_sky]).all()
    assert (frame.classes[is_sky] == class_number('sky')).all()


@pytest.mark.slow
def test_the_same_pose_gives_the_same_bytes_in_any_order(renderer, eye):
    """After other poses, and from another camera, nothing differs."""
    first = eye.expose(*OBLIQUE)
    eye.expose(*NADIR)
    again = eye.expose(*OBLIQUE)
    other = renderer.camera(LENS)
    third = other.expose(*OBLIQUE)
    other.close()
    for frame in (again, third):
        for name in ('image', 'depth_m', 'numbers', 'classes', 'normals'):
            assert np.array_equal(getattr(first, name), getattr(frame, name)), name


@pytest.mark.slow
def test_what_a_camera_is_not_for_changes_nothing_else(renderer, eye):
    """Its image, or its depth and labels, have the bytes that a camera for all gives."""
    everything = eye.expose(*OBLIQUE)
    for purpose, names, empty in (
        (Purpose.IMAGE, ('image', 'numbers', 'normals'), 'depth_m'),
        (Purpose.TRUTH, ('depth_m', 'numbers', 'classes', 'normals'), 'image'),
    ):
        camera = renderer.camera(LENS, purpose)
        frame = camera.expose(*OBLIQUE)
        camera.close()
        for name in names:
            assert np.array_equal(getattr(frame, name), getattr(everything, name)), name
        assert getattr(frame, empty).size == 0


def test_points_are_seen_where_the_lens_says(eye, environment):
    """The centroid of a known target lies within a tenth of a pixel of its projection."""
    position, rotation = NADIR
    frame = eye.expose(position, rotation)
    v, u = np.nonzero(frame.numbers == environment.objects[2].number)
    depth = frame.depth_m[v, u][:, None]
    pixels = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(LENS.matrix).T * depth
    world = pixels @ rotation.T + position
    low, high = environment.objects[2].bounds
    texel = 32.0 / LENS.focal_px
    assert np.all(world >= low - 0.1 * texel)
    assert np.all(world <= high + 0.1 * texel)
    assert np.allclose([*world.min(axis=0)[:2], *world.max(axis=0)[:2]],
                       [*low[:2], *high[:2]], atol=1.5 * texel)  # fmt: skip


def test_another_thread_is_refused(eye):
    """It would silently get the picture before."""
    caught = []

    def ask() -> None:
        try:
            eye.expose(*NADIR)
        except EngineError as error:
            caught.append(str(error))

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join(10.0)
    assert caught == ['the engine was asked from another thread than the one it started in']


@pytest.mark.slow
def test_what_moves_is_where_its_path_says(drawing):
    """Half way in time is half way along; its shadow and its labels go with it."""
    path = ({'time_s': 0.0, 'at': (-10.0, 2.0)}, {'time_s': 10.0, 'at': (10.0, 2.0)})
    moving = small_environment(
        {'name': 'van', 'make': 'ambulance', 'at': (0.0, 0.0), 'path': path}
    )
    light = lighting(sun_direction(moving.description.light.time, 53.28, -9.06), 'clear')
    renderer = Renderer(moving, light)
    eye = renderer.camera(LENS)
    places, frames = [], []
    for time_s in (0.0, 5.0, 10.0):
        renderer.set_time(time_s)
        frame = eye.expose(np.array([0.0, 2.0, 32.0]), rotation_enu_from_optical(math.pi / 2))
        frames.append(frame)
        column = np.nonzero(frame.numbers == moving.objects[0].number)[1]
        places.append((column.mean() - 119.5) / LENS.focal_px * 31.0)
    assert places == pytest.approx([-10.0, 0.0, 10.0], abs=0.8)
    # Where it stood at first there is a shadow then, and none is left behind.
    there, *gone = (frame.image[:, :90].astype(int) for frame in frames)
    is_ground = frames[0].numbers[:, :90] == GROUND_NUMBER
    assert np.count_nonzero((gone[0] - there).min(axis=2)[is_ground] > 15) > 40
    assert np.array_equal(*gone)
