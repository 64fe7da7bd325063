# SPDX-License-Identifier: Apache-2.0
"""Repair of routes that ignore sensors: points go to vehicles that have the sensors."""

import numpy as np

from rocsafe_planner.problem.fleet_problem import FleetProblem, Order


def with_sensors(problem: FleetProblem, orders: list[Order]) -> list[Order]:
    """Move each point that its vehicle lacks the sensors for to where it costs least.

    That is the place in the route of an able vehicle that lets the latest of all come home first.
    """
    if problem.may_visit is None:
        return orders
    mended = [[i for i in order if problem.allowed(k)[i]] for k, order in enumerate(orders)]
    strays = sorted({i for order in orders for i in order} - {i for o in mended for i in o})
    for point in strays:
        able = np.flatnonzero(problem.may_visit[:, point]).tolist()
        offers = [_cheapest_place(problem, k, mended[k], point) for k in able]
        chosen = min(range(len(able)), key=lambda i: (offers[i][0], i))
        mended[able[chosen]].insert(offers[chosen][1], point)
    return mended


def _cheapest_place(
    problem: FleetProblem, vehicle: int, order: Order, point: int
) -> tuple[float, int]:
    """Return the estimated least duration of the route with the point, and its position there."""
    stops = problem.stops(vehicle, order)
    spot = np.array([point])
    into = problem.legs_s(vehicle, stops, spot)
    out_of = problem.legs_s(vehicle, spot, stops[1:])
    detour = into[: len(order) + 1].copy()
    detour[: len(out_of)] += out_of - problem.legs_s(vehicle, stops[:-1], stops[1:])
    place = int(np.argmin(np.round(detour, 6)))
    longer = [*order[:place], point, *order[place:]]
    return problem.reckoned_s(vehicle, longer), place
