# SPDX-License-Identifier: Apache-2.0
"""A magnetometer in the field of the earth, which is that at the mission origin."""

import numpy as np

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.clock.cadence import period_ns
from rocsafe_sim.sensors.body_motion import StateAt
from rocsafe_sim.sensors.earth_field import magnetic_field_ut, year_of
from rocsafe_sim.sensors.errors_over_time import Draws, ErrorModel
from rocsafe_sim.sensors.readings import MagneticReading
from rocsafe_sim.sensors.sensor_settings import MagnetometerSettings
from rocsafe_sim.sensors.streams import Stream

DRIFT_PERIOD_NS = 300 * NS_PER_S


class Magnetometer:
    """A sensor of the magnetic field along three axes.

    Parameters
    ----------
    settings
        Rate and errors.
    draws
        Random values of the vehicle.
    origin
        Place of the field; within 10 km it changes by 0.1 microtesla at most.
    """

    def __init__(self, settings: MagnetometerSettings, draws: Draws, origin: GeoPosition) -> None:
        self.period_ns = period_ns(settings.rate_hz)
        self._draws, self._origin = draws, origin
        self._errors = ErrorModel(
            white_std=settings.noise_std_ut,
            drift_std=settings.drift_std_ut,
            drift_period_ns=DRIFT_PERIOD_NS,
            streams=(Stream.MAGNETOMETER_WHITE, Stream.MAGNETOMETER_DRIFT),
        )

    def read(self, time_ns: int, state_at: StateAt) -> MagneticReading:
        """Return the sample at a time."""
        field_enu = magnetic_field_ut(self._origin, year_of(time_ns))
        true = state_at(time_ns).rotation.T @ np.array(field_enu)
        x, y, z = (true + self._errors.at(self._draws, time_ns)).tolist()
        return MagneticReading(time_ns=time_ns, field_ut=(x, y, z), variance=self._errors.variance)
