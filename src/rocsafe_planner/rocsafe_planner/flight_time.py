# SPDX-License-Identifier: Apache-2.0
"""Time of a straight horizontal flight from standstill to standstill, in a steady wind.

In wind a vehicle keeps its track by crabbing: of its airspeed v it gives the wind's cross
component c, and makes sqrt(v^2 - c^2) plus the wind's component along the track over ground.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.motion import MotionLimits, leg_duration_s

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FlightTime:
    """Times of a vehicle with `motion` in a wind that blows towards (east, north), m/s."""

    motion: MotionLimits
    wind_mps: tuple[float, float] = (0.0, 0.0)

    def __call__(self, displacement: FloatArray) -> FloatArray:
        """Return the times in seconds of displacements (..., 2) in metres."""
        distance = np.hypot(displacement[..., 0], displacement[..., 1])
        if self.wind_mps == (0.0, 0.0):
            return np.asarray(leg_duration_s(distance, self.motion))
        speed = self._ground_speed(displacement, distance)
        acceleration = self.motion.acceleration_mps2
        peak = np.minimum(speed, np.sqrt(distance * acceleration))
        cruise = np.divide(distance, peak, out=np.zeros_like(distance), where=peak > 0.0)
        duration: FloatArray = cruise + peak / acceleration
        return duration

    def fastest(self) -> MotionLimits:
        """Return motion that no flight of this vehicle outruns, in whatever direction."""
        speed = self.motion.cruise_speed_mps + float(np.hypot(*self.wind_mps))
        return MotionLimits(speed, self.motion.acceleration_mps2)

    def _ground_speed(self, displacement: FloatArray, distance: FloatArray) -> FloatArray:
        east, north = self.wind_mps
        length = np.where(distance > 0.0, distance, 1.0)
        along = (displacement[..., 0] * east + displacement[..., 1] * north) / length
        across = (displacement[..., 0] * north - displacement[..., 1] * east) / length
        speed: FloatArray = along + np.sqrt(self.motion.cruise_speed_mps**2 - across**2)
        return speed
