# SPDX-License-Identifier: Apache-2.0
"""Photographs of real vehicles -> messages."""

import math
from array import array

import numpy as np
from sensor_msgs.msg import CameraInfo, CompressedImage, NavSatFix, NavSatStatus
from std_msgs.msg import Header

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_interfaces.msg import GeotaggedImage
from rocsafe_mavlink.photograph import Photograph
from rocsafe_ros.conversions import quaternion_message, stamp_of_ns

# Of an autopilot's attitude in quiet flight.
ATTITUDE_STD_RAD = 0.02


def shot_header(photograph: Photograph) -> Header:
    """Return the header of all messages about a photograph."""
    stamp = stamp_of_ns(photograph.time_ns)
    return Header(stamp=stamp, frame_id=f'{photograph.vehicle}/camera_optical')


def camera_info_message(photograph: Photograph, horizontal_fov_rad: float) -> CameraInfo:
    """Return the intrinsics of a camera without distortion."""
    lens = PinholeCamera(horizontal_fov_rad, photograph.width_px, photograph.height_px)
    matrix = lens.matrix
    return CameraInfo(
        header=shot_header(photograph),
        width=photograph.width_px,
        height=photograph.height_px,
        distortion_model='plumb_bob',
        d=[0.0] * 5,
        k=matrix.ravel(),
        r=np.eye(3).ravel(),
        p=np.hstack([matrix, np.zeros((3, 1))]).ravel(),
    )


def compressed_message(photograph: Photograph) -> CompressedImage:
    """Return the image file as a message."""
    image = CompressedImage(header=shot_header(photograph), format='jpeg')
    image.data = array('B', photograph.jpeg)
    return image


def geotagged_message(photograph: Photograph, horizontal_fov_rad: float) -> GeotaggedImage:
    """Return the atomic record of a photograph."""
    header, place = shot_header(photograph), photograph.position
    fix = NavSatFix(
        header=header,
        status=NavSatStatus(status=NavSatStatus.STATUS_FIX, service=NavSatStatus.SERVICE_GPS),
        latitude=place.latitude_deg,
        longitude=place.longitude_deg,
        altitude=place.altitude_m,
    )
    horizontal, vertical = photograph.horizontal_std_m**2, photograph.vertical_std_m**2
    if math.isfinite(horizontal + vertical):
        fix.position_covariance = np.diag([horizontal, horizontal, vertical]).ravel()
        fix.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
    return GeotaggedImage(
        header=header,
        shot_id=photograph.shot_id,
        vehicle=photograph.vehicle,
        sequence=photograph.sequence,
        viewpoint_id=photograph.viewpoint_id,
        fix=fix,
        height_agl_m=photograph.height_m,
        orientation=quaternion_message(photograph.quaternion_xyzw),
        orientation_covariance=(np.eye(3) * ATTITUDE_STD_RAD**2).ravel(),
        camera_info=camera_info_message(photograph, horizontal_fov_rad),
        image=compressed_message(photograph),
        sha256=photograph.sha256,
    )
