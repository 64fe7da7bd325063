# SPDX-License-Identifier: Apache-2.0
"""Cameras of a scenario reach the vehicles and the recorder as they are written."""

import pytest
import yaml

from rocsafe_orchestrator.recording.recorded_topics import recorded_topics
from rocsafe_scenario.camera_blocks import (
    CameraBlock,
    OtherCameraBlock,
    camera_parameters,
)

FRONT = OtherCameraBlock(name='front', pitch_deg=-30.0, image_width_px=320, stream_rate_hz=5.0)


def test_a_plain_camera_needs_no_list():
    """What was written before there were several cameras gives the parameters of before."""
    parameters = camera_parameters(CameraBlock(horizontal_fov_deg=70.0), ())
    assert parameters == {
        'camera_backend': 'flat', 'scene_file': '', 'camera_oversampling': 2,
        'camera_horizontal_fov_deg': 70.0, 'image_width_px': 640, 'image_height_px': 480,
        'jpeg_quality': 90, 'ground': 'scene', 'cameras': [],
    }  # fmt: skip


def test_vehicles_understand_what_is_written():
    """The texts are those that the vehicles' parameter wants, with what was left out left out."""
    pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    from rocsafe_sim.options import RavOptions

    first = CameraBlock(
        gimbal=True, gimbal_highest_deg=-60.0, effects={'distortion': (-0.1,), 'shutter_s': 0.01}
    )
    parameters = camera_parameters(first, (FRONT.model_copy(update={'pitch_deg': -75.0}),))
    assert yaml.safe_load(parameters['cameras'][1]) == {
        'name': 'front', 'pitch_deg': -75.0, 'image_width_px': 320, 'stream_rate_hz': 5.0,
        'yaw_deg': 0.0, 'at_viewpoints': True, 'gimbal': False, 'gimbal_rate_dps': 60.0,
        'gimbal_lowest_deg': -90.0, 'gimbal_highest_deg': 30.0,
        'effects': {
            'distortion': [], 'exposure_ev': 0.0, 'vignetting': 0.0, 'full_well_e': 0.0,
            'read_noise_e': 0.0, 'shutter_s': 0.0, 'readout_s': 0.0,
        },
    }  # fmt: skip
    values = {**parameters, 'cameras': tuple(parameters['cameras'])}
    camera, front = RavOptions(**values).rig()
    assert (camera.gimbal, camera.gimbal_highest_deg) == (True, -60.0)
    assert camera.effects.distortion == (-0.1, 0.0, 0.0, 0.0, 0.0)
    assert (front.name, front.image_width_px, front.image_height_px) == ('front', 320, 480)
    assert front.effects.are_none


def test_all_cameras_are_recorded():
    """Pictures and intrinsics of each, below its own name."""
    names = {(spec.name, vehicle) for spec, vehicle in recorded_topics(['rav1'], ['front'])}
    for camera in ('camera', 'front'):
        assert (f'{camera}/image_raw/compressed', 'rav1') in names
        assert (f'{camera}/camera_info', 'rav1') in names
