# SPDX-License-Identifier: Apache-2.0
"""The method `insertion`: each point where it lengthens the longest route least.

It needs no compiled code and little memory: the farthest point first (Rosenkrantz, Stearns, Lewis
1977), at the place, of all routes, that makes the longest route shortest, then the sum.
"""

from collections.abc import Collection

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order

# Times that differ by less are equal: the lower number wins on every machine, seconds.
_ROUNDING_S = 1e-6


def minmax_insertion(problem: FleetProblem, last: Collection[int] = ()) -> list[Order]:
    """Return the order of each vehicle; points of `last` come after all others."""
    routes = _GrowingRoutes(problem)
    points = range(len(problem.points))
    nearest = np.min([routes.from_start_s(k) for k in range(len(problem.vehicles))], axis=0)
    for is_last in (False, True):
        group = [point for point in points if (point in last) == is_last]
        for point in sorted(group, key=lambda point: (-round(float(nearest[point]), 6), point)):
            routes.insert(point)
        routes.close()
    return routes.orders


class _GrowingRoutes:
    """Routes into which points are inserted."""

    def __init__(self, problem: FleetProblem) -> None:
        self._problem = problem
        vehicles = range(len(problem.vehicles))
        self.orders: list[Order] = [[] for _ in vehicles]
        self._closed = [0 for _ in vehicles]
        self._durations = [problem.reckoned_s(k, []) for k in vehicles]
        self._tables = [self._table(k) for k in vehicles]
        self._allowed = [problem.allowed(k) for k in vehicles]

    def _table(self, vehicle: int) -> FloatArray:
        every = np.arange(len(self._problem.sites))
        return self._problem.legs_s(vehicle, every[:, None], every[None, :])

    def from_start_s(self, vehicle: int) -> FloatArray:
        """Return the times of the legs from where a vehicle begins to all points."""
        start = self._problem.start_site(vehicle)
        return self._tables[vehicle][start, : len(self._problem.points)]

    def close(self) -> None:
        """Insert from now on behind what is there."""
        self._closed = [len(order) for order in self.orders]

    def insert(self, point: int) -> None:
        """Insert a point at its best place."""
        options = []
        for vehicle, order in enumerate(self.orders):
            if not self._allowed[vehicle][point]:
                continue
            position, more_s = self._cheapest(vehicle, point)
            duration = self._durations[vehicle] + more_s
            spec = self._problem.vehicles[vehicle]
            is_beyond = spec.battery_swap_s is None and duration > spec.first_endurance_s
            idle = not order and spec.aloft is None
            others = max((d for k, d in enumerate(self._counted()) if k != vehicle), default=0.0)
            peak = round(max(duration, others) / _ROUNDING_S)
            grown = round((duration if idle else more_s) / _ROUNDING_S)
            options.append((is_beyond, peak, grown, vehicle, position, duration))
        *_, vehicle, position, duration = min(options)
        self.orders[vehicle].insert(position, point)
        self._durations[vehicle] = duration

    def _counted(self) -> list[float]:
        """Return the durations of the routes, 0 for those that stay on the ground."""
        flies = self._problem.flies
        return [
            duration if flies(k, self.orders[k]) else 0.0
            for k, duration in enumerate(self._durations)
        ]

    def _cheapest(self, vehicle: int, point: int) -> tuple[int, float]:
        """Return where a point lengthens a route least, and by how much, seconds."""
        table, stops = self._tables[vehicle], self._problem.stops(vehicle, self.orders[vehicle])
        first = self._closed[vehicle]
        more = table[stops[first:-1], point] + table[point, stops[first + 1 :]]
        more = more - table[stops[first:-1], stops[first + 1 :]]
        if self._problem.end_site(vehicle) is None:
            more = np.append(more, table[stops[-1], point])
        best = int(np.argmin(np.round(more / _ROUNDING_S)))
        return first + best, float(more[best]) + self._problem.vehicles[vehicle].hover_s
