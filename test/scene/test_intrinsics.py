# SPDX-License-Identifier: Apache-2.0
"""Known points are seen where OpenCV projects them, within a tenth of a pixel, in every camera."""

import math

import cv2
import numpy as np
import pytest
import shapely
from test.scene.scenes import small_environment

from rocsafe_geo.pinhole import rotation_body_from_optical, rotation_enu_from_body
from rocsafe_scene.optics.effects import Effects
from rocsafe_scene.scene.environment import GROUND_NUMBER
from rocsafe_scene.scene.sunlight import lighting, sun_direction
from rocsafe_sim.cameras.camera_settings import CameraSettings

pytest.importorskip('panda3d', reason='panda3d is not installed')
from rocsafe_scene.engine.renderer import Renderer
from rocsafe_scene.optics.optics import Optics

# Sides that are no whole number of pixels, so that edges do not run along pixel centres.
HALF_M = 1.37
HEIGHT_M = 3.0
PLACES = [(x, y) for x in (-9.3, 0.4, 8.9) for y in (-6.1, 0.7, 6.3)]
SQUARE = f"""\
v -{HALF_M} -{HALF_M} 0
v {HALF_M} -{HALF_M} 0
v {HALF_M} {HALF_M} 0
v -{HALF_M} {HALF_M} 0
f 1 2 3
f 1 3 4
"""
LIMIT_PX = 0.1
CAMERAS = {
    'nadir': (CameraSettings(), (0.6, -0.4, 32.0)),
    'wide': (CameraSettings(horizontal_fov_deg=85.0, image_width_px=800), (0.6, -0.4, 22.0)),
    'oblique': (CameraSettings(pitch_deg=-50.0, yaw_deg=20.0), (-20.0, -6.0, 27.0)),
    'distorted': (
        CameraSettings(effects=Effects(distortion=(-0.21, 0.05, 0.003, -0.002, 0.0))),
        (0.6, -0.4, 32.0),
    ),
    'oblique distorted': (
        CameraSettings(pitch_deg=-55.0, effects=Effects(distortion=(0.1, -0.02, 0.0, 0.002))),
        (-19.0, 0.5, 27.0),
    ),
}


@pytest.fixture(scope='module')
def targets(tmp_path_factory):
    """Return a scene of level squares in the air."""
    mesh = tmp_path_factory.mktemp('targets') / 'square.obj'
    mesh.write_text(SQUARE)
    things = [
        {'name': f'square_{index}', 'mesh': str(mesh), 'at': place, 'height_m': HEIGHT_M}
        for index, place in enumerate(PLACES)
    ]
    return small_environment(*things)


@pytest.fixture(scope='module')
def renderer(targets, drawing):
    """Return a renderer of it."""
    time = targets.description.light.time
    return Renderer(targets, lighting(sun_direction(time, 53.28, -9.06), 'clear'))


def shares_of(renderer, settings, position, rotation):
    """Return, by the number of a target, how much of each pixel of a photograph it fills.

    The picture of the lens is interpolated from the drawn one, so that its pixels fill in part.
    """
    eye = renderer.camera(settings.drawn_lens)
    frame = eye.expose(np.array(position), rotation)
    eye.close()
    rng = np.random.default_rng(0)
    for number in np.unique(frame.numbers[frame.numbers > GROUND_NUMBER]):
        drawn = np.where(frame.numbers == number, np.uint8(255), np.uint8(0))
        if not settings.effects.are_none:
            optics = Optics(settings.lens, settings.effects)
            drawn = optics.develop(np.dstack([drawn] * 3), None, rng)[..., 0]
        yield number, drawn / 255.0


def border_of(thing):
    """Return points along the border of a target, in order, (n, 3)."""
    corners = thing.pieces[0].points()
    middle = corners.mean(axis=0)
    turn = np.arctan2(corners[:, 1] - middle[1], corners[:, 0] - middle[0])
    ring = corners[np.argsort(turn)]
    shares = np.linspace(0.0, 1.0, 40, endpoint=False)[:, None]
    sides = [a + shares * (b - a) for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)]
    return np.concatenate(sides)


@pytest.mark.slow
@pytest.mark.parametrize('name', CAMERAS)
def test_targets_are_where_opencv_projects_them(renderer, targets, name):
    """The centroid of each target's picture is that of its outline by cv2.projectPoints."""
    settings, position = CAMERAS[name]
    looks = settings.direction
    rotation = rotation_enu_from_body(0.25, 0.03, -0.02) @ rotation_body_from_optical(
        looks.pitch_rad, looks.yaw_rad
    )
    turn, move = cv2.Rodrigues(rotation.T)[0], -rotation.T @ np.array(position)
    terms = np.array(settings.effects.distortion or [0.0] * 5)
    things = {thing.number: thing for thing in targets.objects}
    lens, errors = settings.lens, []
    within = shapely.box(0.0, 0.0, lens.image_width_px - 1.0, lens.image_height_px - 1.0)
    for number, share in shares_of(renderer, settings, position, rotation):
        border, _ = cv2.projectPoints(border_of(things[number]), turn, move, lens.matrix, terms)
        outline = shapely.Polygon(border.reshape(-1, 2))
        if within.contains(outline):
            v, u = np.indices(share.shape)
            assert share.sum() == pytest.approx(outline.area, rel=0.01)
            found = np.average(u, weights=share), np.average(v, weights=share)
            errors.append(math.dist(found, (outline.centroid.x, outline.centroid.y)))
    assert len(errors) >= 5
    assert max(errors) <= LIMIT_PX
