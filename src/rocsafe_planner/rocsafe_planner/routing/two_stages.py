# SPDX-License-Identifier: Apache-2.0
"""Routes on which each vehicle visits certain points after all its others.

The first points are routed without the way home. Each vehicle then begins the last ones where and
when it has visited the first; the search balances the sum of both.
"""

import dataclasses
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.solver_method import search_options
from rocsafe_planner.routing.solver_problem import routing_problem
from rocsafe_planner.solver import MatrixLegs, PointLegs, RoutingProblem, Vehicle, solve

MOST_OF_THE_SEARCH = 0.5
"""Part of the proposals that each of the two stages has."""


def orders_in_two_stages(
    problem: FleetProblem, effort: Effort, last: Collection[int]
) -> list[Order]:
    """Return the order of each vehicle: first the other points, then those of `last`."""
    whole = routing_problem(problem, effort.objective)
    first = [point for point in range(len(problem.points)) if point not in last]
    begun: list[Order] = [[] for _ in problem.vehicles]
    if first:
        begun = _first_stage(whole, effort, first)
    return _last_stage(whole, effort, sorted(last), begun)


def _first_stage(whole: RoutingProblem, effort: Effort, first: Sequence[int]) -> list[Order]:
    """Return routes over the first points that end anywhere."""
    vehicles = tuple(dataclasses.replace(v, end=None, idle_cost=0.0) for v in whole.vehicles)
    part = _part(whole, vehicles, first)
    return _solved(part, effort, first)


def _last_stage(
    whole: RoutingProblem, effort: Effort, last: Sequence[int], begun: Sequence[Order]
) -> list[Order]:
    """Return the routes `begun`, continued over the last points."""
    vehicles = []
    for vehicle, order in zip(whole.vehicles, begun, strict=True):
        stops = [vehicle.start, *order]
        flown = _cost(whole.legs[vehicle.legs], whole, stops)
        used = _cost(whole.legs[vehicle.limiting_legs], whole, stops)
        home = [] if vehicle.end is None else [stops[-1], vehicle.end]
        landing = _cost(whole.legs[vehicle.legs], whole, home)
        vehicles.append(
            dataclasses.replace(
                vehicle,
                start=stops[-1],
                fixed_cost=vehicle.fixed_cost + flown,
                idle_cost=vehicle.fixed_cost + flown + landing if order else vehicle.idle_cost,
                limit=max(0.0, vehicle.limit - used),
            )
        )
    part = _part(whole, vehicles, last)
    tails = _solved(part, effort, last)
    return [[*order, *tail] for order, tail in zip(begun, tails, strict=True)]


def _cost(legs: PointLegs | MatrixLegs, whole: RoutingProblem, stops: Sequence[int]) -> float:
    """Return the cost of the legs between stops in order."""
    if len(stops) < 2:
        return 0.0
    if isinstance(legs, MatrixLegs):
        return float(legs.matrix[stops[:-1], stops[1:]].sum())
    steps = float(np.diagonal(legs.costs(whole.places[list(stops)], 0), 1).sum())
    return steps + sum(stop < whole.customers for stop in stops[1:]) * legs.stay


def _part(
    whole: RoutingProblem, vehicles: Iterable[Vehicle], points: Sequence[int]
) -> RoutingProblem:
    """Return the problem of some points and other vehicles; the other points are only places."""
    chosen = set(points)
    sites = whole.sites
    order = [*points, *(site for site in range(sites) if site not in chosen)]
    place = {site: number for number, site in enumerate(order)}
    return dataclasses.replace(
        whole,
        customers=len(points),
        points=None if whole.points is None else whole.points[order],
        legs=tuple(
            MatrixLegs(matrix=legs.matrix[np.ix_(order, order)])
            if isinstance(legs, MatrixLegs)
            else legs
            for legs in whole.legs
        ),
        vehicles=tuple(
            dataclasses.replace(
                vehicle,
                start=place[vehicle.start],
                end=None if vehicle.end is None else place[vehicle.end],
            )
            for vehicle in vehicles
        ),
        allowed=None if whole.allowed is None else whole.allowed[:, points],
    )


def _solved(part: RoutingProblem, effort: Effort, points: Sequence[int]) -> list[Order]:
    options = search_options(len(points), effort)
    if options.proposals:
        proposals = max(1, int(options.proposals * MOST_OF_THE_SEARCH))
        options = dataclasses.replace(options, proposals=proposals)
    else:
        options = dataclasses.replace(options, budget_s=options.budget_s * MOST_OF_THE_SEARCH)
    solution = solve(part, options)
    return [[points[customer] for customer in route] for route in solution.routes]
