# SPDX-License-Identifier: Apache-2.0
"""The nadir camera over level ground."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.pinhole import (
    PinholeCamera,
    ground_corners,
    ground_homography,
    quaternion_of_rotation,
    rotation_enu_from_optical,
    rotation_of_quaternion,
)

CAMERA = PinholeCamera(math.radians(60.0), 640, 480)
ANGLES = st.floats(-math.pi, math.pi)
TILTS = st.floats(-0.5, 0.5)


def pixel(homography, east, north):
    """Return (u, v) of a ground point."""
    u, v, depth = homography @ (east, north, 1.0)
    return u / depth, v / depth


@pytest.mark.parametrize(('fov_deg', 'width'), [(60.0, 36.950), (90.0, 64.000)])
def test_footprint_of_the_paper(fov_deg, width):
    """F = 2 h tan(fov / 2) at 32 m; the height follows the image's aspect."""
    camera = PinholeCamera(math.radians(fov_deg), 640, 480)
    across, along = camera.footprint_m(32.0)
    assert across == pytest.approx(width, abs=5e-4)
    assert along == pytest.approx(across * 480 / 640)


def test_camera_facing_north_has_north_at_the_image_top():
    """Yaw 90 degrees: ground to the north is above, ground to the east right of the centre."""
    homography = ground_homography(
        CAMERA, (100.0, 50.0, 32.0), rotation_enu_from_optical(math.pi / 2)
    )
    metres = 10.0 * CAMERA.focal_px / 32.0
    assert pixel(homography, 100.0, 50.0) == pytest.approx((319.5, 239.5))
    assert pixel(homography, 100.0, 60.0) == pytest.approx((319.5, 239.5 - metres))
    assert pixel(homography, 110.0, 50.0) == pytest.approx((319.5 + metres, 239.5))


def test_nose_down_sees_further_back():
    """Positive pitch lowers the nose, so a camera in the belly looks backward."""
    forward_yaw = rotation_enu_from_optical(0.0, pitch_rad=0.1)
    assert forward_yaw[:, 2] == pytest.approx([-math.sin(0.1), 0.0, -math.cos(0.1)])
    right_down = rotation_enu_from_optical(0.0, roll_rad=0.1)
    assert right_down[:, 2] == pytest.approx([0.0, math.sin(0.1), -math.cos(0.1)])


def test_corners_of_a_level_image_are_its_footprint():
    """Facing east, the top left corner lies ahead and to the left: north-east."""
    across, along = CAMERA.footprint_m(32.0)
    corners = ground_corners(CAMERA, (0.0, 0.0, 42.0), rotation_enu_from_optical(0.0), 10.0)
    x, y = along / 2, across / 2
    np.testing.assert_allclose(corners, [[x, y], [x, -y], [-x, -y], [-x, y]], atol=1e-9)


@given(ANGLES, TILTS, TILTS, st.floats(-5.0, 5.0))
def test_corners_and_homography_agree(yaw, pitch, roll, ground_up):
    """The homography takes each ground corner to the image corner it came from, depth positive."""
    rotation = rotation_enu_from_optical(yaw, pitch, roll)
    position = (30.0, -20.0, 32.0)
    homography = ground_homography(CAMERA, position, rotation, ground_up)
    corners = ground_corners(CAMERA, position, rotation, ground_up)
    expected = [(-0.5, -0.5), (639.5, -0.5), (639.5, 479.5), (-0.5, 479.5)]
    for (east, north), image_corner in zip(corners, expected, strict=True):
        assert pixel(homography, east, north) == pytest.approx(image_corner, abs=1e-6)
        assert (homography @ (east, north, 1.0))[2] > 0.0


@given(ANGLES, ANGLES, ANGLES)
def test_quaternion_round_trip(yaw, pitch, roll):
    """A rotation survives the quaternion, which is of unit length with w not negative."""
    rotation = rotation_enu_from_optical(yaw, pitch, roll)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    quaternion = quaternion_of_rotation(rotation)
    assert np.linalg.norm(quaternion) == pytest.approx(1.0)
    assert quaternion[3] >= 0.0
    np.testing.assert_allclose(rotation_of_quaternion(quaternion), rotation, atol=1e-9)


def test_known_quaternion():
    """A quarter turn about up is (0, 0, sin 45, cos 45)."""
    turn = rotation_of_quaternion((0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)))
    np.testing.assert_allclose(turn @ (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(
        quaternion_of_rotation(turn), (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)), atol=1e-12
    )


@pytest.mark.parametrize(
    ('call', 'message'),
    [
        (lambda: PinholeCamera(math.pi, 640, 480), 'horizontal_fov_rad'),
        (lambda: PinholeCamera(1.0, 0, 480), 'image_width_px is 0: must be 1 to'),
        (lambda: PinholeCamera(1.0, 640, 10.5), 'image_height_px is 10.5: must be a whole'),
        (lambda: CAMERA.footprint_m(0.0), 'height_m is 0 m'),
        (lambda: ground_homography(CAMERA, (0, 0, -1), np.eye(3)), 'height above ground is -1 m'),
        (lambda: ground_corners(CAMERA, (0, 0, 9), rotation_enu_from_optical(0, 1.4)), 'horizon'),
        (lambda: rotation_of_quaternion((0, 0, 0, 0)), 'quaternion length is 0'),
    ],
)
def test_impossible_cameras_are_refused(call, message):
    """The refusal names the argument, its value and the limit."""
    with pytest.raises(ValueError, match=message):
        call()
