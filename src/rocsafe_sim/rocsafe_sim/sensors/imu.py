# SPDX-License-Identifier: Apache-2.0
"""Gyroscopes and accelerometers that turn with the vehicle.

A sample is the mean since the sample before, as a sensor integrates: without errors the samples
add up to the vehicle's motion. The rotation of the earth (7e-5 rad/s) is left out.
"""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_body
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.clock.cadence import period_ns
from rocsafe_sim.sensors.body_motion import BodyState, StateAt
from rocsafe_sim.sensors.errors_over_time import Draws, ErrorModel
from rocsafe_sim.sensors.readings import Axes, ImuReading
from rocsafe_sim.sensors.sensor_settings import ImuSettings
from rocsafe_sim.sensors.streams import Stream

# Drifts are independent after ten minutes, those of the estimated orientation after 40 s.
DRIFT_PERIOD_NS = 300 * NS_PER_S
ORIENTATION_PERIOD_NS = 20 * NS_PER_S
# Limits of an MPU-6000 in its widest ranges, 2000 deg/s and 16 g.
LARGEST_RATE_RADPS = math.radians(2000.0)
LARGEST_FORCE_MPS2 = 16.0 * 9.80665


class Imu:
    """An inertial measurement unit with an estimate of its orientation.

    Parameters
    ----------
    settings
        Rate and errors.
    draws
        Random values of the vehicle.
    orientation_std_rad
        Standard deviation of the estimated orientation about each axis.
    gravity_mps2
        Acceleration of free fall.
    """

    def __init__(
        self,
        settings: ImuSettings,
        draws: Draws,
        orientation_std_rad: float,
        gravity_mps2: float,
    ) -> None:
        self.period_ns = period_ns(settings.rate_hz)
        self._draws = draws
        self._orientation_std_rad = orientation_std_rad
        self._gravity_mps2 = gravity_mps2
        root = math.sqrt(settings.rate_hz)
        self._gyroscope = ErrorModel(
            white_std=settings.gyroscope_noise * root,
            drift_std=settings.gyroscope_drift_std_radps,
            drift_period_ns=DRIFT_PERIOD_NS,
            streams=(Stream.GYROSCOPE_WHITE, Stream.GYROSCOPE_DRIFT),
        )
        self._accelerometer = ErrorModel(
            white_std=settings.accelerometer_noise * root,
            drift_std=settings.accelerometer_drift_std_mps2,
            drift_period_ns=DRIFT_PERIOD_NS,
            streams=(Stream.ACCELEROMETER_WHITE, Stream.ACCELEROMETER_DRIFT),
        )

    def read(self, time_ns: int, state_at: StateAt) -> ImuReading:
        """Return the sample that ends at a time."""
        before, now = state_at(time_ns - self.period_ns), state_at(time_ns)
        seconds = self.period_ns / NS_PER_S
        rate = rotation_vector(before.rotation.T @ now.rotation) / seconds
        force = now.rotation.T @ self._force_enu(before, now, seconds)
        return ImuReading(
            time_ns=time_ns,
            orientation_xyzw=self._orientation(now),
            rate_radps=self._measured(rate, self._gyroscope, time_ns, LARGEST_RATE_RADPS),
            force_mps2=self._measured(force, self._accelerometer, time_ns, LARGEST_FORCE_MPS2),
            orientation_variance=self._orientation_std_rad**2,
            rate_variance=self._gyroscope.variance,
            force_variance=self._accelerometer.variance,
        )

    def _force_enu(self, before: BodyState, now: BodyState, seconds: float) -> FloatArray:
        change = np.subtract(now.velocity_enu, before.velocity_enu)
        return np.asarray(change / seconds + (0.0, 0.0, self._gravity_mps2))

    def _measured(
        self, true: FloatArray, errors: ErrorModel, time_ns: int, largest: float
    ) -> Axes:
        error = errors.at(self._draws, time_ns)
        x, y, z = np.clip(true + error, -largest, largest).tolist()
        return x, y, z

    def _orientation(self, now: BodyState) -> tuple[float, float, float, float]:
        drift = self._draws.drift(Stream.ORIENTATION, now.time_ns, ORIENTATION_PERIOD_NS)
        roll, pitch, yaw = (self._orientation_std_rad * value for value in drift)
        estimate = now.rotation @ rotation_enu_from_body(yaw, pitch, roll)
        x, y, z, w = quaternion_of_rotation(estimate).tolist()
        return x, y, z, w


def rotation_vector(rotation: FloatArray) -> FloatArray:
    """Return the axis of a rotation (3, 3) times its angle in rad, shape (3,)."""
    x, y, z, w = quaternion_of_rotation(rotation).tolist()
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 if sine < 1e-12 else 2.0 * math.atan2(sine, w) / sine
    return np.array([scale * x, scale * y, scale * z])
