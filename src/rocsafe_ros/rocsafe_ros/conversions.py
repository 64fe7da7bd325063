# SPDX-License-Identifier: Apache-2.0
"""Values of `rocsafe_geo` and plain Python <-> standard and ROCSAFE messages."""

import math

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion
from sensor_msgs.msg import NavSatFix, NavSatStatus

from rocsafe_geo.area import SurveyArea
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.msg import GeoPoint, GeoPolygon, Region

NS_PER_S = 1_000_000_000
EARTH_FRAME = 'earth'


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
    ValueError: if latitude or longitude is out of range or not finite.
    """
    return GeoPosition(
        latitude_deg=point.latitude, longitude_deg=point.longitude, altitude_m=point.altitude
    )


def has_position(fix: NavSatFix) -> bool:
    """Whether `fix` says where the receiver is."""
    return fix.status.status >= NavSatStatus.STATUS_FIX and math.isfinite(
        fix.latitude + fix.longitude
    )


def position_of_fix(fix: NavSatFix) -> GeoPosition:
    """Return where `fix` is; its altitude is above the ellipsoid, NaN if unknown.

    Raises
    ------
    ValueError: if it has no position.
    """
    if not has_position(fix):
        raise ValueError(f'fix has no position (status {fix.status.status})')
    return GeoPosition(
        latitude_deg=fix.latitude, longitude_deg=fix.longitude, altitude_m=fix.altitude
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
    ValueError: if its polygons do not make an area, see `SurveyArea`.
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


def quaternion_values(message: Quaternion) -> tuple[float, float, float, float]:
    """Return a quaternion message as (x, y, z, w)."""
    return (message.x, message.y, message.z, message.w)


def _polygon(points: tuple[GeoPosition, ...]) -> GeoPolygon:
    return GeoPolygon(points=[point_of_position(point) for point in points])


def _positions(polygon: GeoPolygon) -> tuple[GeoPosition, ...]:
    return tuple(position_of_point(point) for point in polygon.points)
