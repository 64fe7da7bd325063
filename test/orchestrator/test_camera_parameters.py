# SPDX-License-Identifier: Apache-2.0
"""Cameras of a scenario reach the vehicles and the recorder as they are written."""

from rocsafe_geo.storage.value_file import values_of
from rocsafe_orchestrator.recording.recorded_topics import recorded_topics
from rocsafe_scenario.blocks.cameras import CameraBlock, OtherCameraBlock, camera_parameters
from rocsafe_sim.cameras.camera_settings import CameraRig, CameraSettings

FRONT = OtherCameraBlock(name='front', pitch_deg=-30.0, image_width_px=320, stream_rate_hz=5.0)


def test_a_plain_camera_is_a_rig_of_one():
    """It looks down, and has what the scenario says of it."""
    parameters = camera_parameters(CameraBlock(horizontal_fov_deg=70.0), ())
    rig = values_of(parameters.pop('cameras_file'), CameraRig, 'cameras')
    assert rig.cameras == (CameraSettings(horizontal_fov_deg=70.0),)
    assert parameters == {'camera_backend': 'flat', 'scene_file': '', 'ground': 'scene'}


def test_vehicles_understand_what_is_written():
    """What a further camera leaves out is as of the survey's."""
    first = CameraBlock(
        gimbal=True, gimbal_highest_deg=-60.0, jpeg_quality=80,
        effects={'distortion': (-0.1,), 'shutter_s': 0.01},
    )  # fmt: skip
    parameters = camera_parameters(first, (FRONT,))
    camera, front = values_of(parameters['cameras_file'], CameraRig, 'cameras').cameras
    assert (camera.gimbal, camera.gimbal_highest_deg) == (True, -60.0)
    assert camera.effects.distortion == (-0.1, 0.0, 0.0, 0.0, 0.0)
    assert (front.name, front.pitch_deg, front.stream_rate_hz) == ('front', -30.0, 5.0)
    assert (front.image_width_px, front.image_height_px, front.jpeg_quality) == (320, 480, 80)
    assert front.effects.are_none
    assert not front.gimbal


def test_all_cameras_are_recorded():
    """Pictures and intrinsics of each, below its own name."""
    names = {(spec.name, vehicle) for spec, vehicle in recorded_topics(['rav1'], ['front'])}
    for camera in ('camera', 'front'):
        assert (f'{camera}/image_raw/compressed', 'rav1') in names
        assert (f'{camera}/camera_info', 'rav1') in names
