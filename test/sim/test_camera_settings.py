# SPDX-License-Identifier: Apache-2.0
"""Cameras as a parameter describes them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.pinhole import rotation_body_from_optical
from rocsafe_scene.optics.effects import Effects
from rocsafe_sim.cameras.camera_settings import CameraSettings, cameras_of
from rocsafe_sim.options import RavOptions

FIRST = CameraSettings(image_width_px=320, image_height_px=240, stream_rate_hz=2.0)


def test_nothing_said_is_one_camera():
    """The other parameters describe it."""
    assert cameras_of((), FIRST) == (FIRST,)
    assert RavOptions().rig() == (CameraSettings(),)


def test_what_is_left_out_is_as_of_the_first():
    """Keys and effects are read; integers serve as floats."""
    texts = (
        '{gimbal: true, effects: {distortion: [-0.1, 0.02], shutter_s: 0.01}}',
        '{name: front, pitch_deg: -30, image_width_px: 160, stream_rate_hz: 5}',
    )
    first, front = cameras_of(texts, FIRST)
    assert (first.gimbal, first.image_width_px, first.name) == (True, 320, 'camera')
    assert first.effects == Effects(distortion=(-0.1, 0.02, 0.0, 0.0, 0.0), shutter_s=0.01)
    assert (front.name, front.pitch_deg, front.image_width_px) == ('front', -30.0, 160)
    assert (front.image_height_px, front.stream_rate_hz, front.gimbal) == (240, 5.0, False)
    assert front.effects.are_none


@pytest.mark.parametrize(
    ('texts', 'reason'),
    [
        (('[',), r"cameras\[0\] is '\[': must be YAML"),
        (('5',), 'must be a mapping of keys to values'),
        (('{}', '{}'), 'names must differ'),
        (('{pitch_deg: -45}',), 'look straight down'),
        (('{}', '{name: "9", pitch_deg: -45}'), r"cameras\[1\]: name is '9'"),
        (('{}', '{name: a, pitch_deg: -91}'), 'pitch_deg is -91 deg: must be -90 to 90 deg'),
        (('{}', '{name: a, zoom: 3}'), 'zoom is unknown: must be one of name'),
        (('{}', '{name: a, gimbal: 1}'), 'gimbal is 1: must be bool'),
        (('{}', '{name: a, image_width_px: 8000, image_height_px: 8000}'), '12000000 at most'),
        (('{}', '{name: a, gimbal: true, gimbal_rate_dps: 0}'), 'must be above 0'),
        (('{}', '{name: a, effects: 3}'), 'effects is 3: must be a mapping'),
        (('{effects: {vignetting: 2}}',), 'vignetting is 2: must be 0 to 1'),
        (('{effects: {read_noise_e: 2}}',), 'must be 0 without full_well_e'),
        (('{effects: {distortion: [1, 2, 3, 4, 5, 6]}}',), 'must have 5 at most'),
    ],
)
def test_what_cannot_be_is_refused(texts, reason):
    """One line names the camera, the key, its value and the limit."""
    with pytest.raises(ValueError, match=reason):
        cameras_of(texts, FIRST)


def test_flat_ground_has_no_horizon_to_be_seen():
    """Over the flat picture a camera must not look too far up; in a scene it may."""
    front = ('{}', '{name: front, pitch_deg: -20}')
    with pytest.raises(ValueError, match=r'vertical of cameras\[1\] is .*must be 0 to 70 deg'):
        RavOptions(cameras=front)
    scene = {'camera_backend': 'engine', 'scene_file': 'x.yaml'}
    assert RavOptions(cameras=front, **scene).rig()[1].pitch_deg == -20.0


@given(st.floats(-90.0, 90.0), st.floats(20.0, 120.0))
def test_the_steepest_view_is_that_of_the_corner_that_looks_highest(pitch_deg, fov_deg):
    """By the rays through all four corners."""
    settings = CameraSettings(pitch_deg=pitch_deg, horizontal_fov_deg=fov_deg)
    lens = settings.lens
    x, y = (0.5 * side / lens.focal_px for side in (lens.image_width_px, lens.image_height_px))
    corners = np.array([[i * x, j * y, 1.0] for i in (-1, 1) for j in (-1, 1)])
    up = (corners @ rotation_body_from_optical(math.radians(pitch_deg)).T)[:, 2]
    steepest = np.degrees(np.arccos(-up / np.linalg.norm(corners, axis=1))).max()
    assert settings.steepest_view_deg == pytest.approx(steepest, abs=1e-6)
