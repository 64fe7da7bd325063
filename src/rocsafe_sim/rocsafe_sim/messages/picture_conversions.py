# SPDX-License-Identifier: Apache-2.0
"""Messages of images and gimbals, and commands to gimbals."""

from array import array
from collections.abc import Iterable
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from rocsafe_geo.evidence.shot import Quaternion
from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_body_from_optical
from rocsafe_interfaces.msg import GimbalCommand, GimbalState
from rocsafe_ros.conversions import (
    MAP_FRAME,
    camera_info_message,
    quaternion_message,
    stamp_of_ns,
)
from rocsafe_scene.cameras.camera import Truth
from rocsafe_sim.cameras.gimbal import Direction, Gimbal
from rocsafe_sim.cameras.mounted_camera import CameraPicture, MountedCamera


def picture_header(vehicle: str, picture: CameraPicture) -> Header:
    """Return the header of all messages about an image."""
    stamp = stamp_of_ns(picture.time_ns)
    return Header(stamp=stamp, frame_id=f'{vehicle}/{picture.camera}_optical')


def info_message(picture: CameraPicture, header: Header) -> CameraInfo:
    """Return the intrinsics of an image, with its distortion."""
    settings = picture.settings
    return camera_info_message(settings.lens, header, settings.effects.distortion)


def image_message(picture: CameraPicture, header: Header) -> Image:
    """Return the pixels, 8 bits blue, green, red."""
    return _plane_message(picture.image, 'bgr8', header)


def depth_message(truth: Truth, header: Header) -> Image:
    """Return planar depth, metres, 32 bit floats; infinite where the sky is (REP 118)."""
    return _plane_message(truth.depth_m.astype('<f4'), '32FC1', header)


def labels_message(truth: Truth, header: Header) -> Image:
    """Return instance numbers, 16 bits; larger ones become 65535."""
    return _plane_message(np.minimum(truth.numbers, 65_535).astype('<u2'), 'mono16', header)


def pose_message(picture: CameraPicture) -> PoseStamped:
    """Return the true pose of the optical frame in the mission's frame."""
    message = PoseStamped(header=Header(stamp=stamp_of_ns(picture.time_ns), frame_id=MAP_FRAME))
    place = message.pose.position
    place.x, place.y, place.z = picture.position_enu
    x, y, z, w = quaternion_of_rotation(picture.rotation_enu_from_optical).tolist()
    message.pose.orientation = quaternion_message((x, y, z, w))
    return message


def direction_of(command: GimbalCommand) -> Direction:
    """Return the direction of a command to a gimbal.

    Raises
    ------
    ValueError
        If a value is outside its limits; it names the value.
    """
    return Direction(pitch_rad=command.pitch_rad, yaw_rad=command.yaw_rad)


def gimbal_message(vehicle: str, camera: str, gimbal: Gimbal, time_ns: int) -> GimbalState:
    """Return the state of a gimbal at a time."""
    points, target = gimbal.direction(time_ns), gimbal.turn.target
    return GimbalState(
        header=Header(stamp=stamp_of_ns(time_ns), frame_id=f'{vehicle}/base_link'),
        camera=camera,
        pitch_rad=points.pitch_rad,
        yaw_rad=points.yaw_rad,
        pitch_target_rad=target.pitch_rad,
        yaw_target_rad=target.yaw_rad,
        is_settled=gimbal.is_settled(time_ns),
    )


def _plane_message(plane: NDArray[Any], encoding: str, header: Header) -> Image:
    height, width = plane.shape[:2]
    message = Image(header=header, height=height, width=width, encoding=encoding)
    message.step = plane.nbytes // height
    message.data = array('B', plane.tobytes())
    return message


def mounts_of(cameras: Iterable[MountedCamera]) -> dict[str, Quaternion]:
    """Return the rotations to the vehicle's body of the cameras that are fixed to it, by frame."""
    return dict(mount_of(camera, 0) for camera in cameras if camera.gimbal is None)


def mount_of(camera: MountedCamera, time_ns: int) -> tuple[str, Quaternion]:
    """Return the frame of a camera, without the vehicle's name, and its rotation to the body."""
    looks = camera.direction(time_ns)
    rotation = rotation_body_from_optical(looks.pitch_rad, looks.yaw_rad)
    x, y, z, w = map(float, quaternion_of_rotation(rotation))
    return f'{camera.name}_optical', (x, y, z, w)
