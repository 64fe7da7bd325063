# SPDX-License-Identifier: Apache-2.0
"""Messages -> values of this package, and back."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from geometry_msgs.msg import Point
from sensor_msgs.msg import FluidPressure, Image, Imu, MagneticField, NavSatFix, Range
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from rocsafe_airsim import values
from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.ned import Quaternion, Vector, attitude_ned
from rocsafe_airsim.vehicle import Picture
from rocsafe_interfaces.msg import GasReading, RadiationReading
from rocsafe_interfaces.srv import Look
from rocsafe_ros.conversions import MAP_FRAME, ns_of_stamp

SEA_LEVEL_PA = 101_325.0
_DTYPES = {'bgr8': (np.uint8, 3), '32FC1': (np.float32, 1), 'mono16': (np.uint16, 1)}


def vector_of(message: Any) -> Vector:
    """Return a Point or a Vector3."""
    return message.x, message.y, message.z


def quaternion_of(message: Any) -> Quaternion:
    """Return a quaternion, x, y, z, w."""
    return message.x, message.y, message.z, message.w


def position_of(fix: NavSatFix) -> Vector:
    """Return latitude, longitude and altitude."""
    return fix.latitude, fix.longitude, fix.altitude


def std_of(fix: NavSatFix) -> tuple[float, float]:
    """Return the horizontal and the vertical standard deviation, metres."""
    covariance = fix.position_covariance
    return math.sqrt(max(covariance[0], 0.0)), math.sqrt(max(covariance[8], 0.0))


def picture_of(response: Look.Response) -> Picture:
    """Return an image with its pose.

    Raises
    ------
    AirsimError
        If an image has another encoding than the cameras of this suite send.
    """
    pose, info = response.pose.pose, response.camera_info
    has_truth = bool(response.depth.width)
    focal_px = info.k[0]
    fov_rad = 2.0 * math.atan2(info.width, 2.0 * focal_px) if focal_px else math.nan
    return Picture(
        stamp_ns=ns_of_stamp(response.image.header.stamp),
        pixels=_pixels(response.image),
        place_enu=vector_of(pose.position),
        attitude=quaternion_of(pose.orientation),
        fov_deg=math.degrees(fov_rad),
        depth_m=_pixels(response.depth) if has_truth else None,
        labels=_pixels(response.labels) if has_truth else None,
    )


def radiation_of(message: RadiationReading) -> dict[str, Any]:
    """Return a reading, units in the names."""
    return {
        'time_stamp': ns_of_stamp(message.header.stamp),
        'dose_rate_usvh': message.dose_rate_usvh,
        'dose_rate_std_usvh': message.dose_rate_std_usvh,
        'counts': int(message.counts),
        'detector': message.detector,
        'saturated': bool(message.saturated),
    }


def gas_of(message: GasReading) -> dict[str, Any]:
    """Return a reading, in the unit that it names."""
    return {
        'time_stamp': ns_of_stamp(message.header.stamp),
        'sensor': message.sensor,
        'raw': message.raw,
        'std': message.std,
        'unit': message.unit,
    }


def imu_of(message: Imu) -> dict[str, Any]:
    """Return an ImuData: axes of the body ahead, right, down."""
    return {
        'time_stamp': ns_of_stamp(message.header.stamp),
        'orientation': values.quaternion(attitude_ned(quaternion_of(message.orientation))),
        'angular_velocity': values.vector(_body(message.angular_velocity)),
        'linear_acceleration': values.vector(_body(message.linear_acceleration)),
    }


def barometer_of(message: FluidPressure) -> dict[str, Any]:
    """Return a BarometerData: pressure in pascal, altitude by the standard atmosphere."""
    ratio = message.fluid_pressure / SEA_LEVEL_PA
    return {
        'time_stamp': ns_of_stamp(message.header.stamp),
        'altitude': 44_330.77 * (1.0 - ratio**0.190263),
        'pressure': message.fluid_pressure,
        'qnh': SEA_LEVEL_PA / 100.0,
    }


def magnetometer_of(message: MagneticField) -> dict[str, Any]:
    """Return a MagnetometerData: gauss along the axes of the body."""
    gauss = tuple(1e4 * value for value in _body(message.magnetic_field))
    return {
        'time_stamp': ns_of_stamp(message.header.stamp),
        'magnetic_field_body': values.vector(gauss),
        'magnetic_field_covariance': [1e8 * part for part in message.magnetic_field_covariance],
    }


def distance_of(message: Range) -> dict[str, Any]:
    """Return a DistanceSensorData, metres."""
    down = (0.0, math.sin(-math.pi / 4.0), 0.0, math.cos(math.pi / 4.0))
    return {
        'time_stamp': ns_of_stamp(message.header.stamp),
        'distance': message.range,
        'min_distance': message.min_range,
        'max_distance': message.max_range,
        'relative_pose': values.pose((0.0, 0.0, 0.0), down),
    }


# What a vehicle's reading of a topic is made of.
READINGS: Mapping[str, Callable[[Any], dict[str, Any]]] = {
    'radiation': radiation_of,
    'gas': gas_of,
    'imu': imu_of,
    'barometer': barometer_of,
    'magnetometer': magnetometer_of,
    'range': distance_of,
}


def _body(vector: Any) -> Vector:
    """Return a vector of the body ahead, left, up as ahead, right, down."""
    return vector.x, -vector.y, -vector.z


def marker_of(
    number: int, lines: Sequence[Sequence[Vector]], rgba: Sequence[float], size_m: float, kind: str
) -> Marker:
    """Return lines or points as a marker in the frame of the mission."""
    marker = Marker(ns='airsim', id=number, action=Marker.ADD)
    marker.type = Marker.POINTS if kind == 'points' else Marker.LINE_LIST
    marker.header.frame_id = MAP_FRAME
    marker.scale.x = marker.scale.y = size_m
    marker.pose.orientation.w = 1.0
    red, green, blue, alpha = (min(max(float(part), 0.0), 1.0) for part in rgba)
    marker.color = ColorRGBA(r=red, g=green, b=blue, a=alpha)
    for line in lines:
        # A list of lines has the two ends of each.
        ends = line if kind == 'points' else [end for pair in pairwise(line) for end in pair]
        marker.points.extend(Point(x=x, y=y, z=z) for x, y, z in ends)
    return marker


def text_marker_of(
    number: int, text: str, place: Vector, rgba: Sequence[float], size_m: float
) -> Marker:
    """Return a text, letters of this height, as a marker in the frame of the mission."""
    marker = marker_of(number, [], rgba, size_m, 'text')
    marker.type, marker.text, marker.scale.z = Marker.TEXT_VIEW_FACING, text, size_m
    marker.pose.position = Point(x=place[0], y=place[1], z=place[2])
    return marker


def _pixels(image: Image) -> Any:
    if image.encoding not in _DTYPES:
        known = ', '.join(_DTYPES)
        raise AirsimError(f'an image has the encoding {image.encoding!r}: must be one of {known}')
    dtype, channels = _DTYPES[image.encoding]
    values = np.frombuffer(bytes(image.data), dtype)
    shape = (image.height, image.width, channels)[: 2 if channels == 1 else 3]
    return values.reshape(shape)
