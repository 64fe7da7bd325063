# SPDX-License-Identifier: Apache-2.0
"""Cameras as a file describes them."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test.sim.vehicle_files import cameras_file

from rocsafe_geo.pinhole import rotation_body_from_optical
from rocsafe_geo.storage.value_file import ValueFileError, values_of
from rocsafe_geo.storage.yaml_source import parse_yaml
from rocsafe_scene.optics.effects import Effects
from rocsafe_sim.cameras.camera_settings import CameraRig, CameraSettings
from rocsafe_sim.options import RavOptions

REPOSITORY = Path(__file__).parents[2]


def rig_of(text):
    """Return the cameras of the content of a file."""
    return values_of(parse_yaml(text, 'cameras.yaml'), CameraRig, 'cameras.yaml').cameras


def test_nothing_said_is_one_camera():
    """Without a file a vehicle has one plain camera that looks down."""
    assert RavOptions().cameras() == (CameraSettings(),)


def test_cameras_are_read_from_the_file(tmp_path):
    """Keys and effects are read; integers serve as floats; what is left out has its default."""
    path = tmp_path / 'cameras.yaml'
    path.write_text("""
cameras:
  - gimbal: true
    gimbal_highest_deg: -60
    effects: {distortion: [-0.1, 0.02], shutter_s: 0.01}
  - {name: front, pitch_deg: -80, image_width_px: 160, image_height_px: 90, stream_rate_hz: 5}
""")
    first, front = RavOptions(cameras_file=str(path)).cameras()
    assert (first.gimbal, first.image_width_px, first.name) == (True, 640, 'camera')
    assert first.effects == Effects(distortion=(-0.1, 0.02, 0.0, 0.0, 0.0), shutter_s=0.01)
    assert (front.name, front.pitch_deg, front.image_width_px) == ('front', -80.0, 160)
    assert (front.image_height_px, front.stream_rate_hz, front.gimbal) == (90, 5.0, False)
    assert front.effects.are_none


def test_the_manual_s_file_is_read(tmp_path):
    """The example of docs/cameras.md is a file of cameras over flat ground."""
    manual = (REPOSITORY / 'docs' / 'cameras.md').read_text(encoding='utf-8')
    text = re.search(r'```yaml\n(cameras:.*?)```', manual, re.DOTALL)[1]
    path = tmp_path / 'cameras.yaml'
    path.write_text(text)
    cameras = RavOptions(cameras_file=str(path)).cameras()
    assert [camera.name for camera in cameras] == ['camera', 'front', 'turret']


@pytest.mark.parametrize(
    ('second', 'reason'),
    [
        ('5', r'cameras\[1\] = 5: must be a block of keys'),
        ('{}', 'names must differ'),
        ('{name: "9", pitch_deg: -45}', r"cameras\[1\]: name is '9'"),
        (
            '{name: a, pitch_deg: -91}',
            'pitch_deg is -91 deg: must be -90 to 90 deg',
        ),
        ('{name: a, zoom: 3}', r'cameras\[1\].zoom: unknown key'),
        ('{name: a, gimbal: 1}', r'cameras\[1\].gimbal = 1: must be true or false'),
        ('{name: a, image_width_px: 8000, image_height_px: 8000}', '12000000 at most'),
        ('{name: a, gimbal: true, gimbal_rate_dps: 0}', 'must be above 0'),
        ('{name: a, effects: 3}', r'cameras\[1\].effects = 3: must be a block'),
        ('{name: a, effects: {vignetting: 2}}', 'vignetting is 2: must be 0 to 1'),
        ('{name: a, effects: {read_noise_e: 2}}', 'must be 0 without full_well_e'),
        ('{name: a, effects: {distortion: [1, 2, 3, 4, 5, 6]}}', 'must have 5 at most'),
    ],
)
def test_what_cannot_be_is_refused(second, reason):
    """One line names the file, the camera, the key, its value and the limit."""
    with pytest.raises(ValueFileError, match=f'cameras.yaml: .*{reason}'):
        rig_of(f'cameras: [{{}}, {second}]')


@pytest.mark.parametrize('first', ['{name: front}', '{pitch_deg: -45}', '{yaw_deg: 90}'])
def test_the_first_camera_is_that_of_the_survey(first):
    """It has the name of the topics of before and looks straight down."""
    with pytest.raises(ValueFileError, match=r'cameras\[0\]: must be called camera and look'):
        rig_of(f'cameras: [{first}]')


def test_flat_ground_has_no_horizon_to_be_seen(tmp_path):
    """Over the flat picture a camera must not look too far up; in a scene it may."""
    front = cameras_file(tmp_path, {}, {'name': 'front', 'pitch_deg': -20})
    with pytest.raises(ValueError, match=r'of cameras\[1\], .*must be 0 to 70 deg'):
        RavOptions(cameras_file=front).cameras()
    scene = {'camera_backend': 'engine', 'scene_file': 'x.yaml'}
    assert RavOptions(cameras_file=front, **scene).cameras()[1].pitch_deg == -20.0


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
