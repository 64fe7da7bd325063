# SPDX-License-Identifier: Apache-2.0
"""Methods that share out points among vehicles and order them, by name."""

from collections.abc import Callable

import numpy as np

from rocsafe_geo.motion import leg_duration_s
from rocsafe_planner.fleet_problem import FleetProblem, Order, distances_m

# Distances that differ by rounding only are equal: the lower index wins on every machine.
_DECIMALS = 6


def paper_greedy(problem: FleetProblem) -> list[Order]:
    """Let the vehicles take turns, each to the unvisited point nearest to where it stands.

    This is what Algorithm 1 of the ROCSAFE paper means. As printed it cannot run: it reads the
    last point of a path that is still empty, mixes `agent` and `currentAgent`, and takes the
    minimum distance where the point of minimum distance is meant. Its text says nothing of where
    the agents start, so that the first points would be arbitrary: here every vehicle starts at
    its home. Speeds, and the way home, are left out of its choice, as printed; its strict
    rotation does not balance unequal vehicles.

    Returns
    -------
    The order of every vehicle; n points and m vehicles take n steps of O(n).
    """
    tour = _GrowingRoutes(problem)
    for step in range(len(problem.points)):
        tour.extend(step % len(problem.vehicles))
    return tour.orders


def nearest_to_shortest(problem: FleetProblem) -> list[Order]:
    """Let the vehicle that would be home first take the unvisited point nearest to it.

    Unlike `paper_greedy` it balances vehicles of unequal speed or distance to the region.
    """
    tour = _GrowingRoutes(problem)
    for _ in range(len(problem.points)):
        tour.extend(int(np.argmin(np.round(tour.home_s, _DECIMALS))))
    return tour.orders


METHODS: dict[str, Callable[[FleetProblem], list[Order]]] = {
    'paper_greedy': paper_greedy,
    'nearest_to_shortest': nearest_to_shortest,
}
"""Routing methods by the name under which a request asks for them."""


class _GrowingRoutes:
    """Routes that grow at their ends; knows when each vehicle would be back on the ground."""

    def __init__(self, problem: FleetProblem) -> None:
        self.problem = problem
        self.orders: list[Order] = [[] for _ in problem.vehicles]
        self.home_s = np.zeros(len(problem.vehicles))
        self._ends = problem.homes.copy()
        self._elapsed_s = np.zeros(len(problem.vehicles))
        self._is_open = np.ones(len(problem.points), dtype=bool)

    def extend(self, vehicle: int) -> None:
        """Send `vehicle` on to the nearest open point."""
        spec = self.problem.vehicles[vehicle]
        distances = distances_m(self.problem.points, self._ends[vehicle])
        chosen = int(np.argmin(np.where(self._is_open, np.round(distances, _DECIMALS), np.inf)))
        if not self.orders[vehicle]:
            self._elapsed_s[vehicle] = self.problem.fixed_s(vehicle)
        leg = leg_duration_s(float(distances[chosen]), spec.motion)
        self._elapsed_s[vehicle] += leg + spec.hover_s
        self._ends[vehicle] = self.problem.points[chosen]
        self._is_open[chosen] = False
        self.orders[vehicle].append(chosen)
        way_home = float(distances_m(self._ends[vehicle], self.problem.homes[vehicle]))
        self.home_s[vehicle] = self._elapsed_s[vehicle] + leg_duration_s(way_home, spec.motion)
