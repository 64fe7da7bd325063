# SPDX-License-Identifier: Apache-2.0
"""Cameras of a flying vehicle: what they take, with and without a lens, a shutter and noise."""

import math

import cv2
import numpy as np
import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from std_msgs.msg import Header
from test.sim.flights import HOME, ROUTE, START_NS
from test.sim.vehicle_files import cameras_file

from rocsafe_geo.pinhole import rotation_enu_from_optical
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.cameras.ground_camera import jpeg_of
from rocsafe_sim.cameras.gimbal import Direction
from rocsafe_sim.messages.picture_conversions import info_message, pose_message
from rocsafe_sim.options import RavOptions
from rocsafe_sim.rav.assembly import make_rav
from rocsafe_sim.rav.shared_parts import make_shared

SMALL = {'image_width_px': 160, 'image_height_px': 120}


def flown(folder, *cameras, spool=None, **values):
    """Return a vehicle after its first photograph, that photograph, and all pictures of then."""
    files = cameras_file(folder, *({**SMALL, **camera} for camera in cameras or ({},)))
    options = RavOptions(cameras_file=files, origin_latitude_deg=53.28, **values)
    home = options.frame().position_of(HOME)
    place = GeoPosition(home.latitude_deg, home.longitude_deg, 0.0)
    rav = make_rav(options, 'rav1', place, make_shared(options), spool)
    begin_ns = max(START_NS, rav.vehicle.time_ns)
    rav.step(begin_ns)
    rav.vehicle.fly_route(ROUTE)
    for time_ns in range(begin_ns, begin_ns + 300 * 10**9, 2 * 10**8):
        _, shots = rav.step(time_ns)
        if shots:
            return rav, shots[0], list(rav.pictures)
    raise AssertionError('no photograph in five minutes')


def test_a_plain_camera_photographs_as_a_nadir_pinhole(tmp_path):
    """Nothing said of lens or mount, the file is to the byte that of the ground's picture."""
    rav, shot, (picture,) = flown(tmp_path)
    model = rav.parts.cameras[0].model
    assert model.optics is None
    roll, pitch = rav.parts.noise.sway_rad(0)
    waypoint = ROUTE.waypoints[0]
    rotation = rotation_enu_from_optical(waypoint.yaw_rad, pitch, roll)
    expected = model.camera.photograph(waypoint.position_enu, rotation)
    assert shot.jpeg == jpeg_of(expected, 90)
    assert np.array_equal(picture.rotation_enu_from_optical, rotation)


def test_noise_differs_by_camera_and_is_repeated_by_a_restart(tmp_path):
    """Two cameras alike see the same ground with noise of their own, again and again the same."""
    noisy = {'effects': {'full_well_e': 500, 'read_noise_e': 5}}
    other = {'name': 'other', **noisy}
    _, shot, (first, second) = flown(tmp_path, noisy, other, tilt_std_deg=0.0)
    _, again, _ = flown(tmp_path, noisy, other, tilt_std_deg=0.0)
    _, calm, _ = flown(tmp_path, tilt_std_deg=0.0)
    assert shot.jpeg == again.jpeg != calm.jpeg
    assert not np.array_equal(first.image, second.image)
    blurs = [cv2.GaussianBlur(each.image, (0, 0), 6.0).astype(int) for each in (first, second)]
    assert np.abs(blurs[0] - blurs[1]).mean() < 3.0


def test_the_camera_info_tells_the_distortion_of_the_picture(tmp_path):
    """Straightened by its own CameraInfo, the photograph is that of a pinhole."""
    _, _, (photo,) = flown(tmp_path, {'effects': {'distortion': [-0.2, 0.04, 0.002, -0.001]}})
    info = info_message(photo, Header())
    assert info.distortion_model == 'plumb_bob'
    assert list(info.d) == [-0.2, 0.04, 0.002, -0.001, 0.0]
    matrix = np.array(info.k).reshape(3, 3)
    straight = cv2.undistort(photo.image, matrix, np.array(info.d)).astype(int)
    _, _, (pinhole,) = flown(tmp_path)
    gap = np.abs(straight - pinhole.image)[10:-10, 10:-10]
    bent = np.abs(photo.image.astype(int) - pinhole.image)[10:-10, 10:-10]
    assert gap.mean() < 0.5 * bent.mean()


def test_in_passing_a_long_exposure_smears_along_the_way(tmp_path):
    """A vehicle that does not stop blurs its photograph in the direction of its flight."""
    passing = {'hover_s': 0.0, 'cruise_speed_mps': 12.0, 'tilt_std_deg': 0.0}
    large = {'image_width_px': 400, 'image_height_px': 300}
    _, _, (sharp,) = flown(tmp_path, large, **passing)
    rav, _, (smeared,) = flown(tmp_path, {**large, 'effects': {'shutter_s': 0.15}}, **passing)
    before, after = (rav.vehicle.pose_at(sharp.time_ns + shift) for shift in (-(10**7), 10**7))
    way = np.subtract(after.position_enu, before.position_enu)
    across_x, across_y, _ = sharp.rotation_enu_from_optical.T @ way
    assert math.hypot(across_x, across_y) > 0.05
    along = np.array([across_x, across_y]) / math.hypot(across_x, across_y)

    def steepness(image, direction):
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float32)
        slope = [cv2.Sobel(grey, cv2.CV_32F, *axis) for axis in ((1, 0), (0, 1))]
        return float(np.abs(direction[0] * slope[0] + direction[1] * slope[1]).mean())

    kept_along = steepness(smeared.image, along) / steepness(sharp.image, along)
    normal = np.array([-along[1], along[0]])
    kept_across = steepness(smeared.image, normal) / steepness(sharp.image, normal)
    assert kept_along < 0.7 * kept_across


def test_a_gimbal_points_on_after_a_restart(tmp_path):
    """What it was told is in the spool, and the photographs look there."""
    turned = {
        'name': 'turned', 'gimbal': True, 'horizontal_fov_deg': 30, 'gimbal_highest_deg': -45
    }  # fmt: skip
    rav, _, _ = flown(tmp_path, {}, turned, spool=tmp_path / 'spool')
    rav.point(rav.parts.cameras[1], Direction(pitch_rad=-1.0, yaw_rad=0.7))
    again, _, pictures = flown(tmp_path, {}, turned, spool=tmp_path / 'spool')
    assert again.parts.cameras[1].gimbal.turn == rav.parts.cameras[1].gimbal.turn
    ahead = pictures[1].rotation_enu_from_optical[:, 2]
    assert ahead[2] == pytest.approx(-math.sin(1.0), abs=1e-9)
    message = pose_message(pictures[1])
    assert message.header.frame_id == 'map'
    assert message.pose.position.z == pytest.approx(32.0)
