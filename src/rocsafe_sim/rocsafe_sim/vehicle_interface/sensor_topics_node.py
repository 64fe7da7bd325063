# SPDX-License-Identifier: Apache-2.0
"""ROS topics of the sensors of motion, air, field and distance of a simulated vehicle."""

from collections.abc import Callable, Iterable
from typing import Any

from rclpy.publisher import Publisher

from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.interface_spec import TopicSpec
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_sim.messages.sensor_conversions import (
    imu_message,
    magnetic_message,
    pressure_message,
    range_message,
)
from rocsafe_sim.sensors.readings import (
    ImuReading,
    MagneticReading,
    PressureReading,
    RangeReading,
    Reading,
)
from rocsafe_sim.sensors.sensor_settings import SensorRig

Convert = Callable[[Any, str], Any]


class SensorTopics:
    """Publishes imu, barometer, magnetometer and range: those that the vehicle has."""

    def __init__(self, node: VehicleScopeNode, rig: SensorRig) -> None:
        self._vehicle = node.vehicle_name
        table: tuple[tuple[object, type, TopicSpec, Convert], ...] = (
            (rig.imu, ImuReading, topics.IMU, imu_message),
            (rig.barometer, PressureReading, topics.BAROMETER, pressure_message),
            (rig.magnetometer, MagneticReading, topics.MAGNETOMETER, magnetic_message),
            (rig.range, RangeReading, topics.RANGE, range_message),
        )
        self._outlets: dict[type, tuple[Publisher, Convert]] = {
            kind: (topics.create_publisher(node, spec), convert)
            for settings, kind, spec, convert in table
            if settings is not None
        }

    def publish(self, readings: Iterable[Reading]) -> None:
        """Publish samples in their order."""
        for reading in readings:
            publisher, convert = self._outlets[type(reading)]
            publisher.publish(convert(reading, self._vehicle))
