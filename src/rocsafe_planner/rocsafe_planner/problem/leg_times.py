# SPDX-License-Identifier: Apache-2.0
"""Lengths of straight legs, and times of a vehicle's legs with a table of all of them."""

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_planner.problem.detours import Air, Detours

MOST_KEPT = 16_000_000
"""Most times in the tables of all vehicles of a problem: 128 MB."""
# A call for fewer legs than this takes as long as one for this number.
_LEAST_LEGS = 300
# Limits the memory: the computation takes some hundred bytes for each leg.
_MOST_AT_ONCE = 200_000
# Share of all legs that are computed singly before the whole table is computed.
_SHARE = 0.25


class LegTimes:
    """Times of a vehicle between sites, without hovering.

    The time of a leg is the same whether it is computed singly or in the table.

    Parameters
    ----------
    air
        Places of the vehicle at the sites, and times of its flights.
    detours
        Shortest paths among the sites; None: legs are straight.
    most
        Most times in the table; if there are more legs, no table is computed.
    """

    def __init__(self, air: Air, detours: Detours | None, most: int) -> None:
        self._air, self._detours = air, detours
        self._may_keep = len(air.sites) ** 2 <= most
        self._reckoned = 0
        self._kept: FloatArray | None = None

    def __call__(self, origins: IndexArray, targets: IndexArray) -> FloatArray:
        """Return the times of legs between sites, broadcast."""
        if self._kept is None and self._pays(np.broadcast(origins, targets).size):
            every = np.arange(len(self._air.sites))
            self._kept = self._flown(every[:, None], every[None, :])
        if self._kept is None:
            return self._flown(origins, targets)
        times: FloatArray = self._kept[origins, targets]
        return times

    def _pays(self, legs: int) -> bool:
        """Count the requested legs, and return whether to compute the table of all legs."""
        self._reckoned += max(legs, _LEAST_LEGS)
        return self._may_keep and self._reckoned >= _SHARE * len(self._air.sites) ** 2

    def _flown(self, origins: IndexArray, targets: IndexArray) -> FloatArray:
        shape = np.broadcast_shapes(origins.shape, targets.shape)
        rows = max(1, _MOST_AT_ONCE // max(shape[-1], 1))
        if len(shape) < 2 or shape[0] <= rows:
            return self._flown_at_once(origins, targets)
        origins, targets = np.broadcast_to(origins, shape), np.broadcast_to(targets, shape)
        parts = (slice(first, first + rows) for first in range(0, shape[0], rows))
        times = np.empty(shape)
        for part in parts:
            times[part] = self._flown_at_once(origins[part], targets[part])
        return times

    def _flown_at_once(self, origins: IndexArray, targets: IndexArray) -> FloatArray:
        air = self._air
        if self._detours is not None:
            return self._detours.duration_s(origins, targets, air)
        return air.flight(air.sites[origins], air.sites[targets])


def distances_m(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the plane distances of points (..., 2) that broadcast."""
    difference = a - b
    distance: FloatArray = np.hypot(difference[..., 0], difference[..., 1])
    return distance
