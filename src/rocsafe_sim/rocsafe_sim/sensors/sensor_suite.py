# SPDX-License-Identifier: Apache-2.0
"""The sensors of a vehicle, sampled at the multiples of their periods."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.sensors.barometer import Barometer
from rocsafe_sim.sensors.body_motion import StateAt
from rocsafe_sim.sensors.earth_field import gravity_mps2
from rocsafe_sim.sensors.errors_over_time import Draws
from rocsafe_sim.sensors.imu import Imu
from rocsafe_sim.sensors.magnetometer import Magnetometer
from rocsafe_sim.sensors.rangefinder import FirstHit, Rangefinder
from rocsafe_sim.sensors.readings import Reading
from rocsafe_sim.sensors.sensor_settings import SensorRig

# After a longer pause older samples are left out.
LONGEST_BURST_NS = NS_PER_S


class Sensor(Protocol):
    """A sensor that is sampled at the multiples of `period_ns`, counted from time zero."""

    period_ns: int

    def read(self, time_ns: int, state_at: StateAt) -> Reading:
        """Return the sample at a time."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorSuite:
    """The sensors of one vehicle.

    Attributes
    ----------
    rig
        Their settings.
    sensors
        The sensors, in the order of their topics.
    """

    rig: SensorRig
    sensors: tuple[Sensor, ...]

    def times(self, after_ns: int, until_ns: int) -> list[int]:
        """Return the times of the samples after a time, `until_ns` included, in order."""
        after_ns = max(after_ns, until_ns - LONGEST_BURST_NS)
        times: set[int] = set()
        for sensor in self.sensors:
            period = sensor.period_ns
            times.update(range((after_ns // period + 1) * period, until_ns + 1, period))
        return sorted(times)

    def read(self, time_ns: int, state_at: StateAt) -> Iterator[Reading]:
        """Yield the samples that are due at a time."""
        for sensor in self.sensors:
            if time_ns % sensor.period_ns == 0:
                yield sensor.read(time_ns, state_at)


NO_SENSORS = SensorSuite(rig=SensorRig(), sensors=())


def make_suite(
    rig: SensorRig,
    draws: Draws,
    frame: LocalFrame,
    first_hit_m: FirstHit,
    orientation_std_rad: float,
) -> SensorSuite:
    """Return the sensors of a vehicle.

    Parameters
    ----------
    rig
        Their settings.
    draws
        Random values of the vehicle.
    frame
        Local frame of the mission.
    first_hit_m
        Distance to the ground and to obstacles.
    orientation_std_rad
        Standard deviation of the estimated orientation about each axis.
    """
    sensors: list[Sensor] = []
    if rig.imu is not None:
        gravity = gravity_mps2(frame.origin)
        sensors.append(Imu(rig.imu, draws, orientation_std_rad, gravity))
    if rig.barometer is not None:
        sensors.append(Barometer(rig.barometer, draws, frame))
    if rig.magnetometer is not None:
        sensors.append(Magnetometer(rig.magnetometer, draws, frame.origin))
    if rig.range is not None:
        sensors.append(Rangefinder(rig.range, draws, first_hit_m))
    return SensorSuite(rig=rig, sensors=tuple(sensors))
