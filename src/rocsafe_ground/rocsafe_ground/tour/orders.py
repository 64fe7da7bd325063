# SPDX-License-Identifier: Apache-2.0
"""The cheapest round trip through a set of points: exact up to twelve, beyond by the solver.

A set of points is a number: bit k is point k + 1; 0 is the start.
"""

import math
from typing import Protocol

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.route.constrained import ROUNDING
from rocsafe_ground.tour.order_kernels import best_orders
from rocsafe_planner.solver.bounds.certificate import held_karp_bound
from rocsafe_planner.solver.model.problem import MatrixLegs, RoutingProblem, Vehicle
from rocsafe_planner.solver.search.outcome import SearchOptions
from rocsafe_planner.solver.solve import solve

EXACT_POINTS = 12
"""More points take tables of more than 2 ** 12 sets: the solver finds their orders."""
MOST_POINTS = 60
# Proposals of the solver for each point of a trip, a number of its own and no time: the same trip
# on every machine. All of 60 random trips of 2 to 10 points were optimal with it.
PROPOSALS_A_POINT = 2000


class Orders(Protocol):
    """The cheapest round trips for given costs between all points."""

    def order(self, chosen: int) -> tuple[int, ...]:
        """Return the points of the trip through a set, from 1, in their order."""

    def cost(self, chosen: int) -> float:
        """Return the cost of that trip."""

    def bound(self, chosen: int) -> float:
        """Return a cost that no trip through a set is below."""


class ExactOrders:
    """The cheapest round trip through every set of up to `EXACT_POINTS` points.

    Parameters
    ----------
    costs : (points + 1, points + 1)
        Of the way from row to column, 0 is the start; infinite where there is none.

    Attributes
    ----------
    costs : (sets,)
        Of the trips, infinite where there is none; set 0 costs nothing.
    """

    def __init__(self, costs: FloatArray) -> None:
        points = len(costs) - 1
        if points > EXACT_POINTS:
            raise ValueError(f'points = {points}: must be at most {EXACT_POINTS}')
        shape = (1 << points, points)
        best, self._before = np.full(shape, math.inf), np.full(shape, -1, np.int64)
        best_orders(np.ascontiguousarray(costs), best, self._before)
        closed = best + costs[1:, 0]
        self._last = closed.argmin(axis=1)
        self.costs = closed[np.arange(1 << points), self._last]
        self.costs[0] = 0.0

    def order(self, chosen: int) -> tuple[int, ...]:
        """Return the points of the trip through a set, from 1, in their order."""
        found, last = [], int(self._last[chosen])
        while chosen:
            found.append(last + 1)
            before = int(self._before[chosen, last])
            chosen, last = chosen & ~(1 << last), before
        return tuple(reversed(found))

    def cost(self, chosen: int) -> float:
        """Return the cost of that trip."""
        return float(self.costs[chosen])

    def bound(self, chosen: int) -> float:
        """Return the same cost: no trip is below it."""
        return self.cost(chosen)


class SearchedOrders:
    """Round trips by the planner's solver, with its bound; each set is searched once.

    Parameters
    ----------
    costs : (points + 1, points + 1)
        Of the way from row to column, 0 is the start; finite.
    """

    def __init__(self, costs: FloatArray) -> None:
        self._costs = costs
        self._found: dict[int, tuple[tuple[int, ...], float, float]] = {}

    def order(self, chosen: int) -> tuple[int, ...]:
        """Return the points of the trip through a set, from 1, in their order."""
        return self._searched(chosen)[0]

    def cost(self, chosen: int) -> float:
        """Return the cost of that trip."""
        return self._searched(chosen)[1]

    def bound(self, chosen: int) -> float:
        """Return a cost that no trip through a set is below."""
        return self._searched(chosen)[2]

    def _searched(self, chosen: int) -> tuple[tuple[int, ...], float, float]:
        if chosen not in self._found:
            self._found[chosen] = self._search(members_of(chosen))
        return self._found[chosen]

    def _search(self, members: list[int]) -> tuple[tuple[int, ...], float, float]:
        if not members:
            return (), 0.0, 0.0
        # The solver counts customers first and the start behind them.
        sites = np.array([*members, 0])
        scale = float(self._costs[np.ix_(sites, sites)].max()) or 1.0
        problem = RoutingProblem(
            customers=len(members),
            vehicles=(Vehicle(start=len(members), end=len(members)),),
            legs=(MatrixLegs(matrix=self._costs[np.ix_(sites, sites)] / scale),),
        )
        found = solve(problem, SearchOptions(proposals=PROPOSALS_A_POINT * len(members)))
        order = tuple(members[customer] for customer in found.routes[0])
        cost = trip_cost(self._costs, order)
        # None where a trip ends elsewhere than it begins.
        bound = held_karp_bound(problem, found.value) or found.bound.value
        return order, cost, min(cost, bound * scale * (1.0 - ROUNDING))


def members_of(chosen: int) -> list[int]:
    """Return the points of a set, from 1."""
    return [k + 1 for k in range(chosen.bit_length()) if chosen >> k & 1]


def trip_cost(costs: FloatArray, order: tuple[int, ...]) -> float:
    """Return the cost of the round trip through points in an order."""
    stops = np.array([0, *order, 0])
    return float(costs[stops[:-1], stops[1:]].sum())


def orders_of(costs: FloatArray) -> Orders:
    """Return the cheapest round trips, exact where there are few points."""
    return ExactOrders(costs) if len(costs) - 1 <= EXACT_POINTS else SearchedOrders(costs)
