# SPDX-License-Identifier: Apache-2.0
"""Routes of vehicles that may change their batteries: better few that swap than all.

A search that knows nothing of batteries balances the routes, and every one of them may come to be
a little too long for its battery. Here those who swap are also limited to the vehicles nearest to
the survey, the others kept to what their batteries last for; what lands first is taken.
"""

import dataclasses

import numpy as np

from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.fleet_problem import FleetProblem, Order
from rocsafe_planner.optimised import Optimised
from rocsafe_planner.optimising import Effort, Watch, optimised
from rocsafe_planner.sorties import sorties

MOST_SWAPPING = 3
"""So many vehicles at most are tried as the only ones that swap."""


def optimised_with_swaps(problem: FleetProblem, effort: Effort, watch: Watch) -> Optimised:
    """Return the routes that a search finds, or those of fewer vehicles that swap, if better."""
    able = [k for k, v in enumerate(problem.vehicles) if v.battery_swap_s is not None]
    if not able or effort.objective != 'longest_time':
        return optimised(problem, effort, watch)
    trials = min(len(able), MOST_SWAPPING + 1)
    part = dataclasses.replace(effort, budget_s=effort.budget_s / (1 + trials))
    found = optimised(problem, part, watch)
    best_s = finish_s(problem, found.orders)
    if best_s <= max(problem.duration_s(k, order) for k, order in enumerate(found.orders)):
        return found
    orders = found.orders
    able.sort(key=lambda k: _transit_s(problem, k))
    for number in range(trials):
        if not watch(best_s, found.bound):
            break
        trial = optimised(_limited(problem, set(able[:number])), part)
        time_s = finish_s(problem, trial.orders)
        if time_s < best_s:
            best_s, orders = time_s, trial.orders
    return dataclasses.replace(found, orders=orders)


def finish_s(problem: FleetProblem, orders: list[Order]) -> float:
    """Return when the last vehicle has landed, swaps included; infinite if that cannot be."""
    try:
        return max(_route_s(problem, k, order) for k, order in enumerate(orders))
    except BeyondEnduranceError:
        return np.inf


def _route_s(problem: FleetProblem, vehicle: int, order: Order) -> float:
    flights = sorties(problem, vehicle, order)
    if len(flights) < 2:
        return problem.duration_s(vehicle, order)
    spec, home = problem.vehicles[vehicle], problem.home_site(vehicle)
    total = (len(flights) - 1) * (spec.battery_swap_s or 0.0) + len(order) * spec.hover_s
    for number, flight in enumerate(flights):
        start = problem.start_site(vehicle) if number == 0 else home
        end = problem.end_site(vehicle) if number == len(flights) - 1 else home
        stops = np.array([start, *flight, *([] if end is None else [end])], dtype=np.intp)
        total += float(problem.legs_s(vehicle, stops[:-1], stops[1:]).sum())
        total += problem.fixed_s(vehicle) if number else problem.first_fixed_s(vehicle)
    return total


def _limited(problem: FleetProblem, swapping: set[int]) -> FleetProblem:
    """Return the problem in which only these vehicles swap."""
    vehicles = tuple(
        v if k in swapping else dataclasses.replace(v, battery_swap_s=None)
        for k, v in enumerate(problem.vehicles)
    )
    return dataclasses.replace(problem, vehicles=vehicles)


def _transit_s(problem: FleetProblem, vehicle: int) -> float:
    """Return the time to the nearest point and back home."""
    points = np.arange(len(problem.points))
    home = np.array([problem.home_site(vehicle)])
    ways = problem.legs_s(vehicle, home, points) + problem.legs_s(vehicle, points, home)
    return float(ways.min())
