# SPDX-License-Identifier: Apache-2.0
"""Time of a flight from one place in the air to another, from standstill to standstill.

This is the one place that says what a leg costs; routing, plans and tracks ask it. In wind a
vehicle keeps its track by crabbing: of its airspeed v it gives the wind's cross component c, and
makes sqrt(v^2 - c^2) plus the wind's component along the track over ground. A change of height
that takes longer than the way stretches the leg. Where the straight line comes too near to the
terrain the leg bends over it, and the vehicle stops at the bends.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.motion import MotionLimits, leg_duration_s
from rocsafe_planner.relief import Relief

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightTime:
    """Times of a vehicle with `motion` in a wind that blows towards (east, north), m/s."""

    motion: MotionLimits
    climb_rate_mps: float
    descent_rate_mps: float
    wind_mps: tuple[float, float] = (0.0, 0.0)
    relief: Relief | None = None

    def __call__(self, origins: FloatArray, targets: FloatArray) -> FloatArray:
        """Return the times in seconds between places (east, north, up), (..., 3), broadcast."""
        if self.relief is None:
            return self.straight(origins, targets)
        first, second = self.relief.bends(origins, targets)
        return (
            self.straight(origins, first)
            + self.straight(first, second)
            + self.straight(second, targets)
        )

    def straight(self, origins: FloatArray, targets: FloatArray) -> FloatArray:
        """Return the times of straight lines, whatever lies below."""
        way = targets - origins
        level = self._level_s(way)
        up = way[..., 2]
        vertical = np.where(up > 0.0, up / self.climb_rate_mps, -up / self.descent_rate_mps)
        times: FloatArray = np.maximum(level, vertical)
        return times

    def fastest(self) -> MotionLimits:
        """Return motion that no flight of this vehicle outruns, in whatever direction."""
        speed = self.motion.cruise_speed_mps + float(np.hypot(*self.wind_mps))
        return MotionLimits(speed, self.motion.acceleration_mps2)

    def _level_s(self, way: FloatArray) -> FloatArray:
        distance = np.hypot(way[..., 0], way[..., 1])
        if self.wind_mps == (0.0, 0.0):
            return np.asarray(leg_duration_s(distance, self.motion))
        speed = self._ground_speed(way, distance)
        acceleration = self.motion.acceleration_mps2
        peak = np.minimum(speed, np.sqrt(distance * acceleration))
        cruise = np.divide(distance, peak, out=np.zeros_like(distance), where=peak > 0.0)
        duration: FloatArray = cruise + peak / acceleration
        return duration

    def _ground_speed(self, way: FloatArray, distance: FloatArray) -> FloatArray:
        east, north = self.wind_mps
        length = np.where(distance > 0.0, distance, 1.0)
        along = (way[..., 0] * east + way[..., 1] * north) / length
        across = (way[..., 0] * north - way[..., 1] * east) / length
        speed: FloatArray = along + np.sqrt(self.motion.cruise_speed_mps**2 - across**2)
        return speed
