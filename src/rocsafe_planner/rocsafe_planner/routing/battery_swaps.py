# SPDX-License-Identifier: Apache-2.0
"""Routes of vehicles that may change their batteries.

A search that knows nothing of batteries balances the routes, and every one of them may come to be
a little too long for its battery. Here routes that batteries last for, and the flights themselves,
are searched for too; what lands first is taken, or what has least of another objective.
"""

import dataclasses
import math
from collections import Counter
from collections.abc import Callable, Sequence

from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.costs import Optimised, finish_s, objective_value, vehicle_value
from rocsafe_planner.routing.flight_search import (
    Flight,
    caps_within,
    flights_of,
    full_caps,
    may_search,
    searched,
    time_of_flights,
)
from rocsafe_planner.routing.solver_method import Watch, optimised, search_options
from rocsafe_planner.routing.solver_problem import LegTable

# Shares of the time: of the search that ignores batteries, and of each search that counts them.
_FIRST_SHARE = 0.35
_SHARE = 0.13
# The same shares of a number of proposals; the first search has all of them.
_PROPOSALS_SHARE = 0.4
_ROUNDS = 3
# Share of the way from the time for divisible flights to the best time so far.
_STEP = 0.4
# A plan so near to that time is not searched further.
_CLOSE = 0.99


def optimised_with_swaps(
    problem: FleetProblem, effort: Effort, watch: Watch, known: Sequence[list[Order]] = ()
) -> Optimised:
    """Return the routes that a search finds, or those of a search for flights, if better.

    They are no worse than those `known`.
    """
    if all(v.battery_swap_s is None for v in problem.vehicles):
        return optimised(problem, effort, watch, known)
    found = optimised(problem, _part_of_time(effort, _FIRST_SHARE), watch, known)
    best = _Best(problem, found.orders, effort.objective)
    if best.is_without_swaps:
        # What is left of the time; a search that counts proposals has had all of them.
        if effort.budget_s == 0.0:
            return found
        again = optimised(problem, _part_of_time(effort, 1.0 - _FIRST_SHARE), watch)
        best.offer(again.orders)
        bound = max(found, again, key=lambda one: one.bound)
        return dataclasses.replace(bound, orders=best.orders)
    if not _must_swap(problem, effort, found.bound) and watch(best.value, found.bound):
        best.offer(optimised(_without_swaps(problem), _later_part(problem, effort)).orders)
    if may_search(problem):
        _search_flights(problem, effort, best, lambda: watch(best.value, found.bound))
    return dataclasses.replace(found, orders=best.orders)


class _Best:
    """The routes with the least value of an objective: by default those that are flown first."""

    def __init__(self, problem: FleetProblem, orders: list[Order], objective: str) -> None:
        self._problem, self._objective = problem, objective
        self.orders, self.value = orders, objective_value(problem, orders, objective)

    def offer(self, orders: list[Order]) -> bool:
        """Take routes if they are better, and return whether they are."""
        value = objective_value(self._problem, orders, self._objective)
        if value >= self.value:
            return False
        self.orders, self.value = orders, value
        return True

    @property
    def is_without_swaps(self) -> bool:
        """Whether no battery is changed."""
        limits = [vehicle.first_endurance_s for vehicle in self._problem.vehicles]
        return all(
            self._problem.duration_s(k, order) <= limits[k] for k, order in enumerate(self.orders)
        )


def _search_flights(
    problem: FleetProblem, effort: Effort, best: _Best, go_on: Callable[[], bool]
) -> None:
    """Search for the fewest flights, then for such as let all vehicles land at about one time."""
    options = search_options(len(problem.points), _later_part(problem, effort))
    options = dataclasses.replace(options, bound_share=0.0)
    flights = _flights(problem, best.orders)
    most = max(Counter(flight.vehicle for flight in flights).values(), default=0) + 1
    caps = full_caps(problem, most)
    if not flights or not caps:
        return
    table = LegTable(problem)
    orders = searched(table, caps, flights, options, effort.objective)
    best.offer(orders)
    if effort.objective != 'longest_time':
        return
    low_s = _mean_s(problem, orders)
    flights = _flights(problem, orders) or flights
    target_s = time_of_flights(problem, len(flights))
    for _ in range(_ROUNDS):
        if not low_s < target_s < best.value:
            target_s = low_s + _STEP * (best.value - low_s)
        if not go_on() or low_s >= best.value * _CLOSE:
            break
        orders = searched(table, caps_within(problem, target_s), flights, options)
        best.offer(orders)
        if finish_s(problem, orders) > target_s:
            low_s = target_s


def _flights(problem: FleetProblem, orders: list[Order]) -> list[Flight]:
    """Return the flights into which routes are cut; none if one of them cannot be."""
    try:
        return flights_of(problem, orders)
    except BeyondEnduranceError:
        return []


def _mean_s(problem: FleetProblem, orders: list[Order]) -> float:
    """Return the mean of the vehicles' times; 0 if one of them cannot be."""
    try:
        times = [vehicle_value(problem, k, order, 'total_time') for k, order in enumerate(orders)]
    except BeyondEnduranceError:
        return 0.0
    return sum(times) / len(times)


def _part_of_time(effort: Effort, share: float) -> Effort:
    """Return a part of the time, or with a number of proposals all of it."""
    return dataclasses.replace(effort, budget_s=share * effort.budget_s)


def _later_part(problem: FleetProblem, effort: Effort) -> Effort:
    """Return the effort of each search that knows of batteries."""
    proposals = search_options(len(problem.points), effort).proposals
    if proposals is None:
        return _part_of_time(effort, _SHARE)
    return dataclasses.replace(effort, proposals=math.ceil(_PROPOSALS_SHARE * proposals))


def _must_swap(problem: FleetProblem, effort: Effort, bound: float) -> bool:
    """Return whether a proven bound of all plans says that one battery each does not do."""
    longest_s = max(vehicle.first_endurance_s for vehicle in problem.vehicles)
    return effort.minimises_makespan and bound > longest_s


def _without_swaps(problem: FleetProblem) -> FleetProblem:
    """Return the problem in which nobody changes a battery."""
    vehicles = tuple(dataclasses.replace(v, battery_swap_s=None) for v in problem.vehicles)
    return dataclasses.replace(problem, vehicles=vehicles)
