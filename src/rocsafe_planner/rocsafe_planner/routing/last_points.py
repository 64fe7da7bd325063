# SPDX-License-Identifier: Apache-2.0
"""Routes on which each vehicle visits certain points after all its others.

The search is told that a leg from one of the last points to another point costs more than all
other legs together: from a start that needs no such leg it comes to routes without one.
"""

import dataclasses
from collections.abc import Collection

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.solver_method import search_options
from rocsafe_planner.routing.solver_problem import routing_problem
from rocsafe_planner.routing.tours.insertion import minmax_insertion
from rocsafe_planner.solver import MatrixLegs, PointLegs, solve


def orders_with_last(problem: FleetProblem, effort: Effort, last: Collection[int]) -> list[Order]:
    """Return the order of each vehicle: the other points, then its share of those of `last`."""
    start = minmax_insertion(problem, last)
    routing = routing_problem(problem, effort.objective)
    is_last = np.isin(np.arange(routing.sites), list(last))
    is_first = np.arange(routing.sites) < routing.customers
    backwards = is_last[:, None] & (is_first & ~is_last)[None, :]
    legs = tuple(
        MatrixLegs(matrix=_without(backwards, _matrix(problem, kind))) for kind in routing.legs
    )
    options = search_options(len(problem.points), effort)
    found = solve(
        dataclasses.replace(routing, legs=legs),
        # A bound would be one of these legs, not of the flights.
        dataclasses.replace(options, bound_share=0.0),
        starts=[tuple(tuple(order) for order in start)],
    )
    orders = [list(route) for route in found.routes]
    return orders if all(_is_in_order(order, last) for order in orders) else start


def _matrix(problem: FleetProblem, legs: PointLegs | MatrixLegs) -> FloatArray:
    if isinstance(legs, MatrixLegs):
        return np.asarray(legs.matrix, dtype=float)
    return legs.costs(problem.sites, len(problem.points))


def _without(backwards: BoolArray, matrix: FloatArray) -> FloatArray:
    """Return a table of legs in which forbidden legs cost more than any routes without them."""
    return np.where(backwards, matrix.max(axis=1).sum(), matrix)


def _is_in_order(order: Order, last: Collection[int]) -> bool:
    """Return whether the points of `last` come last."""
    is_last = [point in last for point in order]
    return is_last == sorted(is_last)
