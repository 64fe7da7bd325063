# SPDX-License-Identifier: Apache-2.0
"""Messages of the sensors of motion, air, field and distance."""

from geometry_msgs.msg import Vector3
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, Range
from std_msgs.msg import Header

from rocsafe_geo.evidence.shot import Quaternion
from rocsafe_geo.pinhole import quaternion_of_rotation
from rocsafe_ros.conversions import quaternion_message, stamp_of_ns
from rocsafe_sim.sensors.rangefinder import mount_of
from rocsafe_sim.sensors.readings import (
    ImuReading,
    MagneticReading,
    PressureReading,
    RangeReading,
)
from rocsafe_sim.sensors.sensor_settings import SensorRig

RANGE_FRAME = 'range'
_T_PER_UT = 1e-6


def imu_message(reading: ImuReading, vehicle: str) -> Imu:
    """Return a sample of the inertial sensors; orientation of base_link in east, north, up."""
    return Imu(
        header=_header(reading.time_ns, f'{vehicle}/base_link'),
        orientation=quaternion_message(reading.orientation_xyzw),
        orientation_covariance=_diagonal(reading.orientation_variance),
        angular_velocity=_vector(reading.rate_radps),
        angular_velocity_covariance=_diagonal(reading.rate_variance),
        linear_acceleration=_vector(reading.force_mps2),
        linear_acceleration_covariance=_diagonal(reading.force_variance),
    )


def pressure_message(reading: PressureReading, vehicle: str) -> FluidPressure:
    """Return a sample of the barometer."""
    return FluidPressure(
        header=_header(reading.time_ns, f'{vehicle}/base_link'),
        fluid_pressure=reading.pressure_pa,
        variance=reading.variance,
    )


def magnetic_message(reading: MagneticReading, vehicle: str) -> MagneticField:
    """Return a sample of the magnetometer, T."""
    x, y, z = (_T_PER_UT * value for value in reading.field_ut)
    return MagneticField(
        header=_header(reading.time_ns, f'{vehicle}/base_link'),
        magnetic_field=_vector((x, y, z)),
        magnetic_field_covariance=_diagonal(_T_PER_UT**2 * reading.variance),
    )


def range_message(reading: RangeReading, vehicle: str) -> Range:
    """Return a sample of the rangefinder."""
    return Range(
        header=_header(reading.time_ns, f'{vehicle}/{RANGE_FRAME}'),
        radiation_type=Range.INFRARED,
        field_of_view=reading.beam_rad,
        min_range=reading.min_m,
        max_range=reading.max_m,
        range=reading.distance_m,
        variance=reading.variance,
    )


def sensor_mounts(rig: SensorRig) -> dict[str, Quaternion]:
    """Return the rotations to the body of the sensors that have a frame of their own."""
    if rig.range is None:
        return {}
    x, y, z, w = quaternion_of_rotation(mount_of(rig.range)).tolist()
    return {RANGE_FRAME: (x, y, z, w)}


def _header(time_ns: int, frame_id: str) -> Header:
    return Header(stamp=stamp_of_ns(time_ns), frame_id=frame_id)


def _vector(values: tuple[float, float, float]) -> Vector3:
    x, y, z = values
    return Vector3(x=x, y=y, z=z)


def _diagonal(variance: float) -> list[float]:
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
