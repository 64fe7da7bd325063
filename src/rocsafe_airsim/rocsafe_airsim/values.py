# SPDX-License-Identifier: Apache-2.0
"""Answers in the form of AirSim's types: maps with the names that its clients read."""

import math
from collections.abc import Sequence
from typing import Any

from rocsafe_airsim.ned import Quaternion, Vector, attitude_ned, swapped
from rocsafe_airsim.vehicle import AIRBORNE, CRASHED, Vehicle, VehicleNow

Plain = dict[str, Any]
_GRAVITY_MPS2 = 9.80665
_LANDED, _FLYING = 0, 1
_FIX_3D = 3


def vector(value: Sequence[float]) -> Plain:
    """Return a Vector3r."""
    return dict(zip(('x_val', 'y_val', 'z_val'), map(float, value), strict=True))


def quaternion(value: Quaternion) -> Plain:
    """Return a Quaternionr."""
    x, y, z, w = value
    return {'w_val': w, 'x_val': x, 'y_val': y, 'z_val': z}


def pose(place_ned: Vector, attitude: Quaternion) -> Plain:
    """Return a Pose."""
    return {'position': vector(place_ned), 'orientation': quaternion(attitude)}


def geo_point(position: Vector) -> Plain:
    """Return a GeoPoint."""
    return dict(zip(('latitude', 'longitude', 'altitude'), map(float, position), strict=True))


def kinematics(vehicle: Vehicle, now: VehicleNow, *, is_true: bool) -> Plain:
    """Return a KinematicsState; what is not measured is zero."""
    place = now.true_enu if is_true else now.place_enu
    still = vector((0.0, 0.0, 0.0))
    return {
        'position': vector(vehicle.origin.to_ned(place)),
        'orientation': quaternion(attitude_ned(now.attitude)),
        'linear_velocity': vector(swapped(now.velocity_enu)),
        'angular_velocity': still,
        'linear_acceleration': still,
        'angular_acceleration': still,
    }


def collision(vehicle: Vehicle, now: VehicleNow) -> Plain:
    """Return a CollisionInfo."""
    has_collided = now.state == CRASHED
    place = vehicle.origin.to_ned(now.true_enu)
    return {
        'has_collided': has_collided,
        'normal': vector((0.0, 0.0, -1.0 if has_collided else 0.0)),
        'impact_point': vector(place),
        'position': vector(place),
        'penetration_depth': 0.0,
        'time_stamp': now.stamp_ns if has_collided else 0,
        'object_name': now.text if has_collided else '',
        'object_id': -1,
    }


def multirotor_state(vehicle: Vehicle, now: VehicleNow) -> Plain:
    """Return a MultirotorState."""
    return {
        'collision': collision(vehicle, now),
        'kinematics_estimated': kinematics(vehicle, now, is_true=False),
        'gps_location': geo_point(now.position),
        'timestamp': now.stamp_ns,
        'landed_state': _FLYING if now.state in AIRBORNE else _LANDED,
        'rc_data': {'timestamp': 0, 'is_initialized': False, 'is_valid': False},
        'ready': now.state != CRASHED,
        'ready_message': now.text,
        'can_arm': now.state != CRASHED,
    }


def gps_data(now: VehicleNow) -> Plain:
    """Return a GpsData; the accuracies are the standard deviations of the fix."""
    return {
        'time_stamp': now.stamp_ns,
        'gnss': {
            'geo_point': geo_point(now.position),
            'eph': now.std_m[0],
            'epv': now.std_m[1],
            'velocity': vector(swapped(now.velocity_enu)),
            'fix_type': _FIX_3D,
            'time_utc': now.stamp_ns // 1000,
        },
        'is_valid': math.isfinite(now.position[0]),
    }


def environment(vehicle: Vehicle, now: VehicleNow) -> Plain:
    """Return an EnvironmentState, of the standard atmosphere (ISO 2533)."""
    altitude_m = now.position[2] if math.isfinite(now.position[2]) else 0.0
    kelvin = 288.15 - 0.0065 * altitude_m
    pascal = 101_325.0 * (kelvin / 288.15) ** 5.25588
    return {
        'position': vector(vehicle.origin.to_ned(now.true_enu)),
        'geo_point': geo_point(now.position),
        'gravity': vector((0.0, 0.0, _GRAVITY_MPS2)),
        'air_pressure': pascal,
        'temperature': kelvin,
        'air_density': pascal / (287.053 * kelvin),
    }
