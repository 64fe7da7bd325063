# SPDX-License-Identifier: Apache-2.0
"""Gimbals turn no faster than they can, and how a camera hangs decides what it sees."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.pinhole import (
    rotation_body_from_optical,
    rotation_enu_from_body,
    rotation_enu_from_optical,
)
from rocsafe_sim.cameras.camera_settings import CameraSettings
from rocsafe_sim.cameras.gimbal import NADIR_RAD, Direction, Gimbal, GimbalLimits
from rocsafe_sim.cameras.gimbal_file import read_gimbal, write_gimbal
from rocsafe_sim.cameras.mounted_camera import Attitude, CameraModel, MountedCamera
from rocsafe_sim.errors import JournalError

LIMITS = GimbalLimits(rate_radps=0.5, lowest_rad=NADIR_RAD, highest_rad=0.3)
angles = st.floats(-3.1, 3.1)
pitches = st.floats(NADIR_RAD, -NADIR_RAD)


@given(angles, angles, angles)
def test_straight_down_is_exactly_the_nadir_camera(yaw, pitch, roll):
    """A camera with the default direction sees to the last bit what a nadir camera sees."""
    body = rotation_enu_from_body(yaw, pitch, roll)
    mounted = body @ rotation_body_from_optical()
    assert np.array_equal(mounted, rotation_enu_from_optical(yaw, pitch, roll))


@given(pitches, angles)
def test_the_view_goes_where_pitch_and_yaw_say(pitch, yaw):
    """Ahead is at the angle above the horizon and from the nose; the image is upright."""
    rotation = rotation_body_from_optical(pitch, yaw)
    ahead = (
        math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), math.sin(pitch),
    )  # fmt: skip
    assert rotation[:, 2] == pytest.approx(ahead, abs=1e-12)
    assert rotation[2, 0] == pytest.approx(0.0, abs=1e-12)
    assert rotation[2, 1] <= 1e-12
    assert np.linalg.det(rotation) == pytest.approx(1.0)


@settings(max_examples=40)
@given(pitches, angles, st.lists(st.tuples(st.floats(0.0, 5.0), pitches, angles), max_size=4))
def test_never_faster_than_the_limit_and_within_reach(pitch, yaw, commands):
    """Sampled through any commands, neither angle turns faster, and the pitch keeps its limits."""
    gimbal = Gimbal(LIMITS, Direction(pitch_rad=min(pitch, 0.3), yaw_rad=yaw))
    time_ns, step_ns = 0, 100_000_000
    before = gimbal.direction(0)
    for wait_s, to_pitch, to_yaw in [*commands, (8.0, 0.0, 0.0)]:
        for _ in range(int(wait_s * 1e9) // step_ns):
            time_ns += step_ns
            after = gimbal.direction(time_ns)
            turned = (after.yaw_rad - before.yaw_rad + math.pi) % math.tau - math.pi
            assert abs(turned) <= 0.05 + 1e-9
            assert abs(after.pitch_rad - before.pitch_rad) <= 0.05 + 1e-9
            assert NADIR_RAD <= after.pitch_rad <= 0.3
            before = after
        gimbal.point(Direction(pitch_rad=to_pitch, yaw_rad=to_yaw), time_ns)


def test_arrives_when_its_rate_says_and_stays():
    """1 rad at 0.5 rad/s takes 2 s, the short way round; out of reach means as far as it goes."""
    gimbal = Gimbal(LIMITS, Direction(pitch_rad=-1.0, yaw_rad=3.0))
    assert gimbal.is_settled(5)
    gimbal.point(Direction(pitch_rad=1.2, yaw_rad=-3.0), 1_000_000_000)
    assert not gimbal.is_settled(1_000_000_000)
    half = gimbal.direction(2_000_000_000)
    assert half.pitch_rad == pytest.approx(-0.5)
    assert half.yaw_rad == pytest.approx(-3.0)
    assert not gimbal.is_settled(3_500_000_000)
    assert gimbal.is_settled(3_700_000_000)
    assert gimbal.direction(9_000_000_000) == Direction(pitch_rad=0.3, yaw_rad=-3.0)


def test_a_gimbal_keeps_level_and_a_fixed_camera_sways():
    """Roll and pitch of the vehicle reach only the camera that is bolted to it."""
    attitude = Attitude(yaw_rad=0.4, pitch_rad=0.05, roll_rad=-0.08)
    settings = CameraSettings(name='front', pitch_deg=-30.0)
    for is_gimbal in (False, True):
        hung = replace(settings, gimbal=is_gimbal)
        camera = MountedCamera(CameraModel(settings=hung, camera=None))
        right = camera.rotation(camera.held(attitude), 0)[:, 0]
        assert bool(abs(right[2]) < 1e-12) == is_gimbal


def test_a_turn_outlives_the_process(tmp_path):
    """Written and read back it is the same; a damaged file is said."""
    gimbal = Gimbal(LIMITS, Direction())
    gimbal.point(Direction(pitch_rad=-0.123456789, yaw_rad=1.1), 1_700_000_000_123_456_789)
    folder = tmp_path / 'spool'
    assert read_gimbal(folder, 'front') is None
    write_gimbal(folder, 'front', gimbal.turn)
    assert read_gimbal(folder, 'front') == gimbal.turn
    (folder / 'front.gimbal').write_text('{')
    with pytest.raises(JournalError, match='not the turn of a gimbal'):
        read_gimbal(folder, 'front')
