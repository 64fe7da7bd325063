# SPDX-License-Identifier: Apache-2.0
"""Photographs -> messages."""

from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_interfaces.msg import GeotaggedImage
from rocsafe_ros.conversions import quaternion_message, stamp_of_ns
from rocsafe_sim.camera import Truth, image_of
from rocsafe_sim.conversions import fix_message
from rocsafe_sim.sensing_noise import SensorNoise
from rocsafe_sim.shot import Shot

_NO_DISTORTION = [0.0] * 5


def shot_header(shot: Shot) -> Header:
    """Return the header of all messages about a photograph."""
    return Header(stamp=stamp_of_ns(shot.time_ns), frame_id=f'{shot.vehicle}/camera_optical')


def camera_info_message(lens: PinholeCamera, header: Header) -> CameraInfo:
    """Return the intrinsics of a camera without distortion."""
    matrix = lens.matrix
    return CameraInfo(
        header=header,
        width=lens.image_width_px,
        height=lens.image_height_px,
        distortion_model='plumb_bob',
        d=_NO_DISTORTION,
        k=matrix.ravel(),
        r=np.eye(3).ravel(),
        p=np.hstack([matrix, np.zeros((3, 1))]).ravel(),
    )


def compressed_message(shot: Shot) -> CompressedImage:
    """Return the image file as a message."""
    image = CompressedImage(header=shot_header(shot), format='jpeg')
    # An array is taken as it is, where a list is checked number by number.
    image.data = array('B', shot.jpeg)
    return image


def raw_image_message(shot: Shot) -> Image:
    """Return the picture itself, 8 bits blue, green, red."""
    pixels = image_of(shot.jpeg)
    height, width, _ = pixels.shape
    message = Image(
        header=shot_header(shot), height=height, width=width, encoding='bgr8', step=3 * width
    )
    message.data = array('B', pixels.tobytes())
    return message


def depth_message(shot: Shot, truth: Truth) -> Image:
    """Return planar depth, metres, 32 bit floats; infinite where the sky is (REP 118)."""
    return _plane_message(shot, truth.depth_m.astype('<f4'), '32FC1')


def labels_message(shot: Shot, truth: Truth) -> Image:
    """Return instance numbers, 16 bits; those beyond 65535 show as 65535."""
    return _plane_message(shot, np.minimum(truth.numbers, 65_535).astype('<u2'), 'mono16')


def _plane_message(shot: Shot, plane: NDArray[Any], encoding: str) -> Image:
    height, width = plane.shape
    step = plane.itemsize * width
    message = Image(
        header=shot_header(shot), height=height, width=width, encoding=encoding, step=step
    )
    message.data = array('B', plane.tobytes())
    return message


def geotagged_message(shot: Shot, lens: PinholeCamera, noise: SensorNoise) -> GeotaggedImage:
    """Return the atomic record of a photograph."""
    header = shot_header(shot)
    attitude_variance = noise.attitude_std_rad**2
    return GeotaggedImage(
        header=header,
        shot_id=shot.shot_id,
        vehicle=shot.vehicle,
        sequence=shot.sequence,
        viewpoint_id=shot.viewpoint_id,
        fix=fix_message(shot.position, header.stamp, header.frame_id, noise),
        height_agl_m=shot.height_m,
        orientation=quaternion_message(shot.quaternion_xyzw),
        orientation_covariance=(np.eye(3) * attitude_variance).ravel(),
        camera_info=camera_info_message(lens, header),
        image=compressed_message(shot),
        sha256=shot.sha256,
    )
