# SPDX-License-Identifier: Apache-2.0
"""Values of this package <-> messages."""

import math

from sensor_msgs.msg import CameraInfo, NavSatFix

from rocsafe_interfaces.msg import GeotaggedImage, Mosaic, ShotReceipt
from rocsafe_mapping.live import LiveMap
from rocsafe_mapping.map_files import MapFiles
from rocsafe_mapping.shot import Intrinsics, ShotRecord
from rocsafe_mapping.store import Answer, Status
from rocsafe_ros.conversions import (
    EARTH_FRAME,
    has_position,
    ns_of_stamp,
    point_of_position,
    quaternion_values,
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
    ValueError: naming the field, its value and the limit.
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
    ValueError: naming the field, its value and the limit.
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


def receipt_of_answer(message: GeotaggedImage, answer: Answer) -> ShotReceipt:
    """Return the receipt, without a stamp, for the photograph of `message`."""
    return ShotReceipt(
        vehicle=message.vehicle,
        shot_id=message.shot_id,
        sha256=answer.sha256,
        status=RECEIPT_STATUS[answer.status],
        path='' if answer.path is None else str(answer.path),
        reason=answer.reason,
    )


def mosaic_message(live: LiveMap, files: MapFiles) -> Mosaic:
    """Return the map as a message, without a stamp."""
    south_west, north_east = live.preview.corners()
    message = Mosaic(
        path=files.geotiff,
        is_final=files.is_final,
        images_placed=len(live),
        images_by_features=live.by_features,
        epsg_code=live.maker.epsg,
        ground_resolution_m=files.ground_resolution_m,
        south_west=point_of_position(south_west),
        north_east=point_of_position(north_east),
        stated_error_m=files.stated_error_m,
        is_georeferenced=files.is_georeferenced,
        tiles_path=files.tiles,
        quality_path=files.quality,
    )
    message.header.frame_id = EARTH_FRAME
    message.preview.format = 'png'
    message.preview.data = live.preview.png()
    return message


def _floats(values: object) -> tuple[float, ...]:
    return tuple(float(value) for value in values)  # type: ignore[attr-defined]
