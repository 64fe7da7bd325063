# SPDX-License-Identifier: Apache-2.0
"""Routing methods by name: they assign points to vehicles and order them."""

from collections.abc import Callable

import numpy as np

from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.tours.boustrophedon import (
    boustrophedon_equal,
    boustrophedon_minmax,
    strips,
)
from rocsafe_planner.routing.tours.christofides import christofides
from rocsafe_planner.routing.tours.insertion import minmax_insertion

# Distances that differ by rounding only are equal: the lower index wins on every machine.
_DECIMALS = 6


def paper_greedy(problem: FleetProblem) -> list[Order]:
    """Let the vehicles take turns, each to the unvisited point nearest to where it stands.

    This is what Algorithm 1 of the ROCSAFE paper means. As printed it cannot run: it reads the
    last point of a path that is still empty, mixes `agent` and `currentAgent`, and takes the
    minimum distance where the point of minimum distance is meant. Its text says nothing of where
    the agents start, so that the first points would be arbitrary: here every vehicle starts at
    its home. Speeds, and the way home, are left out of its choice, as printed; its strict
    rotation does not balance unequal vehicles. A vehicle that lacks the sensors for every
    point left is passed over.

    Returns
    -------
    The order of every vehicle; n points and m vehicles take n steps of O(n).
    """
    tour = _GrowingRoutes(problem)
    turn = 0
    for _ in range(len(problem.points)):
        while not tour.can_extend(turn % len(problem.vehicles)):
            turn += 1
        tour.extend(turn % len(problem.vehicles))
        turn += 1
    return tour.orders


def nearest_to_shortest(problem: FleetProblem) -> list[Order]:
    """Let the vehicle that would be home first take the unvisited point nearest to it.

    Unlike `paper_greedy` it balances vehicles of unequal speed or distance to the region.
    """
    tour = _GrowingRoutes(problem)
    for _ in range(len(problem.points)):
        able = [tour.can_extend(k) for k in range(len(problem.vehicles))]
        ends = np.where(able, np.round(tour.home_s, _DECIMALS), np.inf)
        tour.extend(int(np.argmin(ends)))
    return tour.orders


def solver(problem: FleetProblem) -> list[Order]:
    """Search for the routes with the shortest makespan; equal problems give equal routes.

    `solver_method.optimised` is the same with a time limit, other objectives and a bound.
    """
    # Imported here, because loading the compiled code takes time that no other method needs.
    from rocsafe_planner.routing.solver_method import optimised

    return optimised(problem, Effort()).orders


METHODS: dict[str, Callable[[FleetProblem], list[Order]]] = {
    'paper_greedy': paper_greedy,
    'nearest_to_shortest': nearest_to_shortest,
    'insertion': minmax_insertion,
    'boustrophedon_equal': boustrophedon_equal,
    'boustrophedon_minmax': boustrophedon_minmax,
    'strips': strips,
    'christofides': christofides,
    'solver': solver,
}
"""Routing methods by the name that a request states."""


class _GrowingRoutes:
    """Routes that grow at their ends, and the landing time of each vehicle."""

    def __init__(self, problem: FleetProblem) -> None:
        self.problem = problem
        self.orders: list[Order] = [[] for _ in problem.vehicles]
        self.home_s = np.zeros(len(problem.vehicles))
        self._at = [problem.start_site(k) for k in range(len(problem.vehicles))]
        self._elapsed_s = np.zeros(len(problem.vehicles))
        self._is_open = np.ones(len(problem.points), dtype=bool)

    def can_extend(self, vehicle: int) -> bool:
        """Return whether an unvisited point is left that `vehicle` has the sensors for."""
        return bool((self._is_open & self.problem.allowed(vehicle)).any())

    def extend(self, vehicle: int) -> None:
        """Append the nearest unvisited point that `vehicle` has the sensors for to its route."""
        problem, spec = self.problem, self.problem.vehicles[vehicle]
        here = self._at[vehicle]
        distances = np.round(problem.distances_m(here)[: len(problem.points)], _DECIMALS)
        is_candidate = self._is_open & problem.allowed(vehicle)
        chosen = int(np.argmin(np.where(is_candidate, distances, np.inf)))
        if not self.orders[vehicle]:
            self._elapsed_s[vehicle] = problem.first_fixed_s(vehicle)
        self._elapsed_s[vehicle] += self._leg_s(vehicle, here, chosen) + spec.hover_s
        self._at[vehicle] = chosen
        self._is_open[chosen] = False
        self.orders[vehicle].append(chosen)
        end = problem.end_site(vehicle)
        way_home = 0.0 if end is None else self._leg_s(vehicle, chosen, end)
        self.home_s[vehicle] = self._elapsed_s[vehicle] + way_home

    def _leg_s(self, vehicle: int, origin: int, target: int) -> float:
        return float(self.problem.legs_s(vehicle, np.array([origin]), np.array([target]))[0])
