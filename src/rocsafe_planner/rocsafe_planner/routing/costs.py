# SPDX-License-Identifier: Apache-2.0
"""Costs of routes as they are flown, with battery changes and corners."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import IndexArray
from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.plan.survey_options import PEAK_OBJECTIVES
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.queues import waits_s
from rocsafe_planner.routing.sorties import sorties


@dataclass(frozen=True, slots=True, kw_only=True)
class Optimised:
    """Routes, a lower bound of their value (NaN: not known), and the name of its proof."""

    orders: list[Order]
    bound: float = math.nan
    bound_name: str = ''


def finish_s(problem: FleetProblem, orders: list[Order]) -> float:
    """Return the time of the last landing, with battery swaps; infinite if not feasible."""
    return objective_value(problem, orders, 'longest_time')


def objective_value(problem: FleetProblem, orders: list[Order], objective: str) -> float:
    """Return the value of an objective, flights to change batteries included.

    It is in seconds, metres or watt seconds; infinite if a battery is too weak. The longest time
    is that with the waits for others at the same place.
    """
    try:
        costs = [vehicle_value(problem, k, order, objective) for k, order in enumerate(orders)]
    except BeyondEnduranceError:
        return math.inf
    if objective == 'longest_time':
        flying = [k for k, order in enumerate(orders) if problem.flies(k, order)]
        costs = [c + w for c, w in zip(costs, waits_s(problem, flying), strict=True)]
    return max(costs) if objective in PEAK_OBJECTIVES else sum(costs)


def vehicle_value(problem: FleetProblem, vehicle: int, order: Order, objective: str) -> float:
    """Return the cost of the flights of one vehicle."""
    flights, spec = sorties(problem, vehicle, order), problem.vehicles[vehicle]
    if objective.endswith('distance'):
        return _length_m(problem, vehicle, flights)
    swaps_s = max(0, len(flights) - 1) * (spec.battery_swap_s or 0.0)
    time_s = _route_s(problem, vehicle, order, flights)
    if objective == 'energy':
        hover_s = len(order) * spec.hover_s
        moving_s = time_s - swaps_s - hover_s
        return moving_s * spec.cruise_power_w + hover_s * spec.hover_power_w
    return time_s


def _length_m(problem: FleetProblem, vehicle: int, flights: list[Order]) -> float:
    legs = (problem.legs_m(stops[:-1], stops[1:]) for stops in _stops(problem, vehicle, flights))
    return (problem.exit_m(vehicle) if flights else 0.0) + float(sum(leg.sum() for leg in legs))


def _route_s(problem: FleetProblem, vehicle: int, order: Order, flights: list[Order]) -> float:
    if len(flights) < 2:
        return problem.duration_s(vehicle, order)
    spec = problem.vehicles[vehicle]
    total = (len(flights) - 1) * (spec.battery_swap_s or 0.0) + len(order) * spec.hover_s
    total += problem.first_fixed_s(vehicle) + (len(flights) - 1) * problem.fixed_s(vehicle)
    for stops in _stops(problem, vehicle, flights):
        total += float(problem.legs_s(vehicle, stops[:-1], stops[1:]).sum())
    return total


def _stops(problem: FleetProblem, vehicle: int, flights: list[Order]) -> Iterator[IndexArray]:
    """Yield the sites of each flight."""
    home = problem.home_site(vehicle)
    for number, flight in enumerate(flights):
        start = problem.start_site(vehicle) if number == 0 else home
        end = problem.end_site(vehicle) if number == len(flights) - 1 else home
        yield np.array([start, *flight, *([] if end is None else [end])], dtype=np.intp)
