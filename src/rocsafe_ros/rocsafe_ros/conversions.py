# SPDX-License-Identifier: Apache-2.0
"""Values of `rocsafe_geo` and plain Python <-> standard and ROCSAFE messages."""

import math
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped, Quaternion, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, CompressedImage, NavSatFix, NavSatStatus
from std_msgs.msg import Header

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.limits import require_between
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_interfaces.msg import GeoPoint, GeoPolygon, GeotaggedImage, Region, VehicleState

EARTH_FRAME = 'earth'
MAP_FRAME = 'map'
# Variance of a fix without error; some readers take 0 for "unknown".
_LEAST_VARIANCE_M2 = 1e-12
# No order is for a place further from the origin of a mission.
FURTHEST_M = 1e6
_NO_DISTORTION = [0.0] * 5
_STATE_NAMES = {
    value: name.lower().replace('_', ' ')
    for name, value in vars(VehicleState).items()
    if name.isupper() and isinstance(value, int)
}
_WARNED_STATES = frozenset({VehicleState.LOST, VehicleState.CRASHED})


def stamp_of_ns(time_ns: int) -> Time:
    """Return a stamp for `time_ns` nanoseconds since the epoch."""
    seconds, nanoseconds = divmod(time_ns, NS_PER_S)
    return Time(sec=seconds, nanosec=nanoseconds)


def ns_of_stamp(stamp: Time) -> int:
    """Return the nanoseconds since the epoch of `stamp`."""
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)


def point_of_position(position: GeoPosition) -> GeoPoint:
    """Return `position` as a message; an unknown altitude stays NaN."""
    return GeoPoint(
        latitude=position.latitude_deg,
        longitude=position.longitude_deg,
        altitude=position.altitude_m,
    )


def position_of_point(point: GeoPoint) -> GeoPosition:
    """Return `point` as a position.

    Raises
    ------
    ValueError
        If latitude or longitude is out of range or not finite.
    """
    return GeoPosition(
        latitude_deg=point.latitude, longitude_deg=point.longitude, altitude_m=point.altitude
    )


def enu_of_point(point: GeoPoint, frame: LocalFrame) -> tuple[float, float, float]:
    """Return the place (east, north, up) of a point in an order, metres.

    An altitude that is not known is that of the origin.

    Raises
    ------
    ValueError
        If the point is no position, or one beyond any flight.
    """
    position = position_of_point(point)
    if math.isnan(position.altitude_m):
        position = replace(position, altitude_m=frame.origin.altitude_m)
    east, north, up = frame.enu_of(position).tolist()
    for name, value in (('east', east), ('north', north), ('up', up)):
        require_between(name, value, -FURTHEST_M, FURTHEST_M, 'm')
    return east, north, up


def has_position(fix: NavSatFix) -> bool:
    """Return whether `fix` has a position."""
    return fix.status.status >= NavSatStatus.STATUS_FIX and math.isfinite(
        fix.latitude + fix.longitude
    )


def fix_message(
    position: GeoPosition,
    stamp: Time,
    frame_id: str,
    std_m: tuple[float, float],
    status: int = NavSatStatus.STATUS_FIX,
) -> NavSatFix:
    """Return a fix; `std_m` is horizontal and vertical standard deviation, NaN if unknown."""
    message = NavSatFix(
        header=Header(stamp=stamp, frame_id=frame_id),
        status=NavSatStatus(status=status, service=NavSatStatus.SERVICE_GPS),
        latitude=position.latitude_deg,
        longitude=position.longitude_deg,
        altitude=position.altitude_m,
    )
    h, v = (max(std * std, _LEAST_VARIANCE_M2) for std in std_m)
    if math.isfinite(h + v):
        message.position_covariance = [h, 0.0, 0.0, 0.0, h, 0.0, 0.0, 0.0, v]
        message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
    return message


def velocity_message(velocity_enu: Enu, stamp: Time) -> TwistStamped:
    """Return the velocity over ground: east, north, up, m/s."""
    message = TwistStamped(header=Header(stamp=stamp, frame_id=MAP_FRAME))
    linear = message.twist.linear
    linear.x, linear.y, linear.z = velocity_enu
    return message


def odometry_message(
    position_enu: Enu, yaw_rad: float, velocity_enu: Enu, stamp: Time, vehicle: str
) -> Odometry:
    """Return the position in the mission's frame; the twist is in the body's frame.

    A yaw that is not known, NaN, is taken for 0: a quaternion must be one.
    """
    yaw_rad = yaw_rad if math.isfinite(yaw_rad) else 0.0
    message = Odometry(
        header=Header(stamp=stamp, frame_id=MAP_FRAME), child_frame_id=f'{vehicle}/base_link'
    )
    position = message.pose.pose.position
    position.x, position.y, position.z = position_enu
    message.pose.pose.orientation = yaw_quaternion(yaw_rad)
    east, north, up = velocity_enu
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    linear = message.twist.twist.linear
    linear.x, linear.y, linear.z = cos * east + sin * north, cos * north - sin * east, up
    return message


def path_pose(position_enu: Enu, stamp: Time) -> PoseStamped:
    """Return one point of the flown track."""
    message = PoseStamped(header=Header(stamp=stamp, frame_id=MAP_FRAME))
    position = message.pose.position
    position.x, position.y, position.z = position_enu
    message.pose.orientation.w = 1.0
    return message


def shot_header(shot: Shot) -> Header:
    """Return the header of all messages about a photograph."""
    return Header(stamp=stamp_of_ns(shot.time_ns), frame_id=f'{shot.vehicle}/camera_optical')


def camera_info_message(
    lens: PinholeCamera, header: Header, distortion: Sequence[float] = ()
) -> CameraInfo:
    """Return the intrinsics of a camera; `distortion` k1, k2, p1, p2, k3, or empty for none."""
    rows: list[list[float]] = lens.matrix.tolist()
    return CameraInfo(
        header=header,
        width=lens.image_width_px,
        height=lens.image_height_px,
        distortion_model='plumb_bob',
        d=list(distortion or _NO_DISTORTION),
        k=[value for row in rows for value in row],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[value for row in rows for value in (*row, 0.0)],
    )


def compressed_message(shot: Shot) -> CompressedImage:
    """Return the image file as a message."""
    return jpeg_message(shot.jpeg, shot_header(shot))


def jpeg_message(jpeg: bytes, header: Header) -> CompressedImage:
    """Return the content of a JPEG file as a message."""
    image = CompressedImage(header=header, format='jpeg')
    # An array is taken as it is, where a list is checked number by number.
    image.data = array('B', jpeg)
    return image


def geotagged_message(
    shot: Shot, lens: PinholeCamera, attitude_std_rad: float, distortion: Sequence[float] = ()
) -> GeotaggedImage:
    """Return the atomic record of a photograph; `distortion` as in `camera_info_message`."""
    header, variance = shot_header(shot), attitude_std_rad**2
    std_m = (shot.horizontal_std_m, shot.vertical_std_m)
    return GeotaggedImage(
        header=header,
        shot_id=shot.shot_id,
        vehicle=shot.vehicle,
        sequence=shot.sequence,
        viewpoint_id=shot.viewpoint_id,
        fix=fix_message(shot.position, header.stamp, header.frame_id, std_m),
        height_agl_m=shot.height_m,
        orientation=quaternion_message(shot.quaternion_xyzw),
        orientation_covariance=[variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance],
        camera_info=camera_info_message(lens, header, distortion),
        image=compressed_message(shot),
        sha256=shot.sha256,
    )


def region_of_area(area: SurveyArea) -> Region:
    """Return `area` as a message without a stamp."""
    region = Region(name=area.name, boundary=_polygon(area.boundary))
    region.header.frame_id = EARTH_FRAME
    region.holes = [_polygon(hole) for hole in area.holes]
    return region


def area_of_region(region: Region) -> SurveyArea:
    """Return `region` as an area.

    Raises
    ------
    ValueError
        If its polygons do not make an area, see `SurveyArea`.
    """
    return SurveyArea(
        name=region.name,
        boundary=_positions(region.boundary),
        holes=tuple(_positions(hole) for hole in region.holes),
    )


def quaternion_message(quaternion: tuple[float, float, float, float]) -> Quaternion:
    """Return a unit quaternion (x, y, z, w) as a message."""
    x, y, z, w = (float(part) for part in quaternion)
    return Quaternion(x=x, y=y, z=z, w=w)


def yaw_quaternion(yaw_rad: float) -> Quaternion:
    """Return the attitude of a level vehicle."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(0.5 * yaw_rad), w=math.cos(0.5 * yaw_rad))


def quaternion_values(message: Quaternion) -> tuple[float, float, float, float]:
    """Return a quaternion message as (x, y, z, w)."""
    return (message.x, message.y, message.z, message.w)


def _polygon(points: tuple[GeoPosition, ...]) -> GeoPolygon:
    return GeoPolygon(points=[point_of_position(point) for point in points])


def _positions(polygon: GeoPolygon) -> tuple[GeoPosition, ...]:
    return tuple(position_of_point(point) for point in polygon.points)


def diagnostic(
    message: str,
    *,
    name: str = '',
    is_warning: bool = False,
    values: Mapping[str, Any] | None = None,
) -> DiagnosticStatus:
    """Return a status of /diagnostics; names of values end with the unit: ``battery_percent``."""
    return DiagnosticStatus(
        name=name,
        hardware_id=name,
        level=DiagnosticStatus.WARN if is_warning else DiagnosticStatus.OK,
        message=message,
        values=key_values(values or {}),
    )


def vehicle_diagnostic(state: VehicleState) -> DiagnosticStatus:
    """Return the status of a vehicle from its last state."""
    is_warning = bool(state.taken_by) or state.state in _WARNED_STATES
    return diagnostic(
        state.text or _STATE_NAMES.get(state.state, 'unknown'),
        name=state.vehicle,
        is_warning=is_warning,
        values={
            'state': _STATE_NAMES.get(state.state, 'unknown'),
            'battery_percent': round(100.0 * state.battery_fraction, 1),
            'speed_mps': round(state.speed_mps, 2),
            'distance_flown_m': round(state.distance_flown_m, 1),
            'viewpoints_visited': f'{state.viewpoints_visited} of {state.viewpoint_count}',
            'photographs_pending': state.shots_pending,
            'taken_by': state.taken_by or 'nobody',
        },
    )


def key_values(values: Mapping[str, Any]) -> list[KeyValue]:
    """Return values as text."""
    return [KeyValue(key=key, value=str(value)) for key, value in values.items()]
