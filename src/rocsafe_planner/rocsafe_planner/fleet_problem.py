# SPDX-License-Identifier: Apache-2.0
"""The routing problem in the plane, and its time model.

A vehicle climbs to the survey height at home, flies straight legs from standstill to standstill,
hovers at each viewpoint, returns home at the survey height and descends. A vehicle without
viewpoints stays on the ground.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.motion import leg_duration_s
from rocsafe_planner.vehicle import Vehicle

FloatArray = NDArray[np.float64]
Order = list[int]
"""Indices of points in flying order."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FleetProblem:
    """Points to visit by a fleet: `homes` (m, 2) and `points` (n, 2) are (east, north) metres."""

    vehicles: tuple[Vehicle, ...]
    homes: FloatArray
    points: FloatArray
    height_m: float

    def fixed_s(self, vehicle: int) -> float:
        """Return the time of climb and descent of a vehicle that flies."""
        return self.vehicles[vehicle].vertical_s(self.height_m)

    def length_m(self, vehicle: int, order: Sequence[int]) -> float:
        """Return the horizontal length of a route, home to home."""
        return float(self._legs_m(vehicle, order).sum())

    def duration_s(self, vehicle: int, order: Sequence[int]) -> float:
        """Return the time from take-off to touch-down; 0 for an empty route."""
        if not len(order):
            return 0.0
        spec = self.vehicles[vehicle]
        flying = float(leg_duration_s(self._legs_m(vehicle, order), spec.motion).sum())
        return self.fixed_s(vehicle) + flying + len(order) * spec.hover_s

    def _legs_m(self, vehicle: int, order: Sequence[int]) -> FloatArray:
        if not len(order):
            return np.zeros(0)
        home = self.homes[vehicle][None, :]
        stops = np.vstack([home, self.points[list(order)], home])
        return distances_m(stops[1:], stops[:-1])


def distances_m(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the plane distances of points (..., 2) that broadcast."""
    difference = a - b
    distance: FloatArray = np.hypot(difference[..., 0], difference[..., 1])
    return distance
