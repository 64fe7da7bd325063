# SPDX-License-Identifier: Apache-2.0
"""Time of a flight from one place in the air to another.

This is the one place that says what a leg costs; routing, plans and tracks ask it. Legs are those
of `rocsafe_geo.motion`, in the wind, from standstill to standstill. Where the straight line comes
too near to the terrain the leg bends over it, and the vehicle stops at the bends.

A vehicle that passes its viewpoints without a stop flies both legs of a corner at once for a
while; how long depends on three places. Here each leg is given its share as if its next were to
lead straight back, which overlaps least. `flight_motion` says what a whole flight takes.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion import MotionLimits
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.motion.route_motion import RouteMotion
from rocsafe_geo.terrain.relief import Relief

_LONG_M = 1e4
_AT_ONCE = 1e12
"""Acceleration and jerk so large that ramps take no time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightTime:
    """Times of a vehicle's flights.

    Attributes
    ----------
    performance
        Of the vehicle, in the wind.
    relief
        That legs keep above; None: level ground.
    passes
        Whether viewpoints are passed without a stop.
    """

    performance: Performance
    relief: Relief | None = None
    passes: bool = False

    def __call__(self, origins: FloatArray, targets: FloatArray) -> FloatArray:
        """Return the times in seconds between places (east, north, up), (..., 3), broadcast."""
        if self.relief is None:
            return self._shared(self.straight(origins, targets))
        origins, targets = np.broadcast_arrays(origins, targets)
        first, second = self.relief.bends(origins, targets)
        bent = (first != targets).any(axis=-1)
        times = self.straight(origins, first)
        if bent.any():
            times[bent] += self.straight(first[bent], second[bent])
            times[bent] += self.straight(second[bent], targets[bent])
        return self._shared(times)

    def straight(self, origins: FloatArray, targets: FloatArray) -> FloatArray:
        """Return the times of straight lines from stop to stop, without regard to the terrain."""
        return self.performance.legs_s(targets - origins)

    def fastest(self) -> MotionLimits:
        """Return a motion at least as fast as any flight of this vehicle, in any direction.

        Overlapping legs still take at least their length at cruise speed.
        """
        fastest = self.performance.fastest()
        if not self.passes:
            return fastest
        return MotionLimits(fastest.cruise_speed_mps, _AT_ONCE, _AT_ONCE**2, 0.0)

    def _shared(self, times: FloatArray) -> FloatArray:
        """Return the times of legs less the parts that overlap the legs before and after."""
        if not self.passes:
            return times
        shared: FloatArray = times - np.minimum(turn_s(self.performance), 0.5 * times)
        return shared


@lru_cache(maxsize=256)
def turn_s(performance: Performance) -> float:
    """Return the overlap in time of two long legs of which the second leads straight back."""
    out, back = (0.0, 0.0, 0.0), (_LONG_M, 0.0, 0.0)
    there = performance.way(out, back, is_passed=True)
    ways = [there, performance.way(back, out)]
    apart = RouteMotion(out, [performance.way(out, back), ways[1]], 0.0).duration_s
    return apart - RouteMotion(out, ways, performance.corner_radius_m).duration_s
