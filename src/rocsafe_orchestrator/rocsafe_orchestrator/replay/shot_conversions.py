# SPDX-License-Identifier: Apache-2.0
"""Photographs of the image store -> messages as their vehicles sent them."""

import math
from hashlib import sha256
from typing import Any

from sensor_msgs.msg import CameraInfo, NavSatFix, NavSatStatus
from std_msgs.msg import Header

from rocsafe_interfaces.msg import GeotaggedImage
from rocsafe_ros.conversions import jpeg_message, quaternion_message, stamp_of_ns

_NO_ROTATION = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]


def shot_message(record: dict[str, Any], jpeg: bytes) -> GeotaggedImage:
    """Return the message of a stored photograph and its record.

    Raises
    ------
    ValueError
        If the record lacks something.
    """
    try:
        header = Header(
            stamp=stamp_of_ns(record['time_ns']), frame_id=f'{record["vehicle"]}/camera_optical'
        )
        return GeotaggedImage(
            header=header,
            shot_id=record['shot_id'],
            vehicle=record['vehicle'],
            sequence=record['sequence'],
            viewpoint_id=record['viewpoint_id'],
            fix=_fix(record, header),
            height_agl_m=_number(record['height_agl_m']),
            orientation=quaternion_message(tuple(record['orientation_xyzw'])),
            orientation_covariance=list(map(_number, record['orientation_covariance_rad2'])),
            camera_info=_camera_info(record['camera'], header),
            image=jpeg_message(jpeg, header),
            # The store wrote tags into the file: it is not that of the vehicle any more.
            sha256=sha256(jpeg).hexdigest(),
        )
    except (KeyError, TypeError, AssertionError) as error:
        raise ValueError(f'not the record of a photograph: {error!r}') from error


def _fix(record: dict[str, Any], header: Header) -> NavSatFix:
    place = [_number(record[name]) for name in ('latitude_deg', 'longitude_deg', 'altitude_m')]
    is_known = math.isfinite(place[0] + place[1])
    return NavSatFix(
        header=header,
        status=NavSatStatus(
            status=NavSatStatus.STATUS_FIX if is_known else NavSatStatus.STATUS_NO_FIX,
            service=NavSatStatus.SERVICE_GPS,
        ),
        latitude=place[0],
        longitude=place[1],
        altitude=place[2],
        position_covariance=list(map(_number, record['position_covariance_m2'])),
        position_covariance_type=NavSatFix.COVARIANCE_TYPE_KNOWN,
    )


def _camera_info(camera: dict[str, Any], header: Header) -> CameraInfo:
    fx, fy, cx, cy = (camera[name] for name in ('fx_px', 'fy_px', 'cx_px', 'cy_px'))
    return CameraInfo(
        header=header,
        width=int(camera['width_px']),
        height=int(camera['height_px']),
        distortion_model=camera['distortion_model'],
        d=list(map(float, camera['distortion'])),
        k=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r=_NO_ROTATION,
        p=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
