# SPDX-License-Identifier: Apache-2.0
"""A sensor of the distance to the ground or to what stands on it, along one beam."""

import math
from collections.abc import Callable

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import rotation_enu_from_body
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.clock.cadence import period_ns
from rocsafe_sim.sensors.body_motion import StateAt
from rocsafe_sim.sensors.errors_over_time import Draws, ErrorModel
from rocsafe_sim.sensors.readings import RangeReading
from rocsafe_sim.sensors.sensor_settings import RangefinderSettings
from rocsafe_sim.sensors.streams import Stream

# Distance from a place along a unit direction up to a limit; infinite if there is nothing.
FirstHit = Callable[[Enu, Enu, float], float]


class Rangefinder:
    """A distance sensor with a narrow beam.

    Parameters
    ----------
    settings
        Rate, errors, limits and direction.
    draws
        Random values of the vehicle.
    first_hit_m
        Distance to the ground and to obstacles.
    """

    def __init__(self, settings: RangefinderSettings, draws: Draws, first_hit_m: FirstHit) -> None:
        self.period_ns = period_ns(settings.rate_hz)
        self._settings, self._draws, self._first_hit_m = settings, draws, first_hit_m
        self._axis = mount_of(settings)[:, 0]
        self._errors = ErrorModel(
            white_std=settings.noise_std_m,
            drift_std=0.0,
            drift_period_ns=NS_PER_S,
            streams=(Stream.RANGE_WHITE, Stream.RANGE_DRIFT),
        )

    def read(self, time_ns: int, state_at: StateAt) -> RangeReading:
        """Return the sample at a time."""
        settings, state = self._settings, state_at(time_ns)
        east, north, up = (state.rotation @ self._axis).tolist()
        true_m = self._first_hit_m(state.position_enu, (east, north, up), settings.max_m)
        measured_m = true_m + self._errors.at(self._draws, time_ns)[0]
        return RangeReading(
            time_ns=time_ns,
            distance_m=_by_rep_117(measured_m, settings),
            min_m=settings.min_m,
            max_m=settings.max_m,
            beam_rad=math.radians(settings.beam_deg),
            variance=self._errors.variance,
        )


def mount_of(settings: RangefinderSettings) -> FloatArray:
    """Return the rotation (3, 3) to the body from the sensor, which looks along its x axis."""
    # A positive pitch of REP 103 lowers the nose.
    yaw, pitch = math.radians(settings.yaw_deg), -math.radians(settings.pitch_deg)
    return rotation_enu_from_body(yaw, pitch, 0.0)


def above_level_ground_m(place: Enu, direction: Enu, limit_m: float) -> float:
    """Return the distance to the level ground, the plane up = 0."""
    if direction[2] >= 0.0:
        return math.inf
    distance_m = max(0.0, place[2]) / -direction[2]
    return distance_m if distance_m <= limit_m else math.inf


def _by_rep_117(measured_m: float, settings: RangefinderSettings) -> float:
    if measured_m > settings.max_m:
        return math.inf
    return measured_m if measured_m >= settings.min_m else -math.inf
