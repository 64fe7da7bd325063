# SPDX-License-Identifier: Apache-2.0
"""Photographs and receipts <-> messages."""

import math

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image, NavSatFix, NavSatStatus
from std_msgs.msg import Header

from rocsafe_interfaces.msg import GeotaggedImage, ShotReceipt
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord
from rocsafe_mapping.store.store import Answer, Status
from rocsafe_ros.conversions import (
    EARTH_FRAME,
    has_position,
    ns_of_stamp,
    quaternion_message,
    quaternion_values,
    stamp_of_ns,
)

_NO_FIX = NavSatFix(
    status=NavSatStatus(status=NavSatStatus.STATUS_NO_FIX),
    latitude=math.nan,
    longitude=math.nan,
    altitude=math.nan,
)
RECEIPT_STATUS = {
    Status.STORED: ShotReceipt.STORED,
    Status.DUPLICATE: ShotReceipt.DUPLICATE,
    Status.REJECTED: ShotReceipt.REJECTED,
}


def record_of_message(message: GeotaggedImage) -> ShotRecord:
    """Return the record of a photograph.

    Raises
    ------
    ValueError
        Naming the field, its value and the limit.
    """
    fix: NavSatFix = message.fix
    position = (fix.latitude, fix.longitude, fix.altitude)
    latitude, longitude, altitude = position if has_position(fix) else (math.nan,) * 3
    return ShotRecord(
        shot_id=message.shot_id,
        vehicle=message.vehicle,
        sequence=message.sequence,
        viewpoint_id=message.viewpoint_id,
        time_ns=ns_of_stamp(message.header.stamp),
        latitude_deg=latitude,
        longitude_deg=longitude,
        altitude_m=altitude,
        position_covariance_m2=_floats(fix.position_covariance),
        height_agl_m=message.height_agl_m,
        orientation_xyzw=quaternion_values(message.orientation),
        orientation_covariance_rad2=_floats(message.orientation_covariance),
        camera=intrinsics_of_message(message.camera_info),
        sha256=message.sha256,
    )


def intrinsics_of_message(info: CameraInfo) -> Intrinsics:
    """Return the intrinsics of a camera.

    Raises
    ------
    ValueError
        Naming the field, its value and the limit.
    """
    is_distorted = any(info.d)
    return Intrinsics(
        width_px=info.width,
        height_px=info.height,
        fx_px=float(info.k[0]),
        fy_px=float(info.k[4]),
        cx_px=float(info.k[2]),
        cy_px=float(info.k[5]),
        distortion_model=info.distortion_model if is_distorted else '',
        distortion=_floats(info.d) if is_distorted else (),
    )


def numbers_of(message: Image) -> NDArray[np.uint16]:
    """Return the numbers of a label image, shape (height, width).

    Raises
    ------
    ValueError
        If it is not 16 bit numbers in little-endian order, or too short.
    """
    if message.encoding != 'mono16' or message.is_bigendian:
        raise ValueError(f'label image has encoding {message.encoding!r}: must be mono16')
    if message.step != 2 * message.width or len(message.data) != message.step * message.height:
        raise ValueError(
            f'label image of {message.width} x {message.height} has {len(message.data)} bytes'
        )
    numbers = np.frombuffer(bytes(message.data), '<u2').reshape(message.height, message.width)
    return numbers.astype(np.uint16)


def receipt_of_answer(
    vehicle: str, shot_id: str, answer: Answer, record: ShotRecord | None
) -> ShotReceipt:
    """Return the receipt, without a stamp, for a photograph of a vehicle.

    Parameters
    ----------
    record
        None of a photograph whose record cannot be read.
    """
    receipt = ShotReceipt(
        vehicle=vehicle,
        shot_id=shot_id,
        sha256=answer.sha256,
        status=RECEIPT_STATUS[answer.status],
        path='' if answer.path is None else str(answer.path),
        reason=answer.reason,
        fix=_NO_FIX,
    )
    if record is None:
        receipt.height_agl_m = math.nan
        return receipt
    receipt.taken = stamp_of_ns(record.time_ns)
    receipt.viewpoint_id = record.viewpoint_id
    receipt.height_agl_m = record.height_agl_m
    receipt.orientation = quaternion_message(record.orientation_xyzw)
    receipt.orientation_covariance = record.orientation_covariance_rad2
    if record.has_fix:
        receipt.fix = NavSatFix(
            header=Header(stamp=receipt.taken, frame_id=EARTH_FRAME),
            status=NavSatStatus(status=NavSatStatus.STATUS_FIX, service=NavSatStatus.SERVICE_GPS),
            latitude=record.latitude_deg,
            longitude=record.longitude_deg,
            altitude=record.altitude_m,
            position_covariance=record.position_covariance_m2,
            position_covariance_type=NavSatFix.COVARIANCE_TYPE_KNOWN,
        )
    return receipt


def _floats(values: object) -> tuple[float, ...]:
    return tuple(float(value) for value in values)  # type: ignore[attr-defined]
