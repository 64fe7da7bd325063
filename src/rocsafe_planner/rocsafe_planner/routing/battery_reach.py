# SPDX-License-Identifier: Apache-2.0
"""Reach of batteries: viewpoints beyond all of them, and the most that a fleet can serve.

A fleet whose batteries do not suffice for all viewpoints is mostly known at once: a viewpoint is
too far for a flight of its own, or a lower bound of the makespan exceeds every battery. Then no
search is made for routes that do not exist.
"""

from dataclasses import replace
from itertools import islice

import numpy as np

from rocsafe_geo.arrays import BoolArray
from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.solver_method import search_options
from rocsafe_planner.routing.solver_problem import routing_problem
from rocsafe_planner.routing.sorties import sorties
from rocsafe_planner.solver import PointLegs, RoutingProblem, improving_bounds, solve
from rocsafe_planner.solver import Vehicle as RoutedVehicle
from rocsafe_planner.solver.solve import CHEAP_BOUNDS, relax_far

# Legs that cost nothing, metres a second.
_AT_ONCE_MPS = 1e9


def beyond_reach(problem: FleetProblem) -> dict[int, BeyondEnduranceError]:
    """Return the points that no vehicle can visit with a flight for it alone, and why.

    Raises
    ------
    BeyondEnduranceError
        If a vehicle in the air cannot even land.
    """
    for k, vehicle in enumerate(problem.vehicles):
        if vehicle.aloft is not None:
            sorties(problem, k, [])
    out_of_reach = np.ones(len(problem.points), dtype=bool)
    for k in range(len(problem.vehicles)):
        out_of_reach &= ~(problem.allowed(k) & _is_surely_near(problem, k))
    refusals = {int(i): _refusal(problem, int(i)) for i in np.flatnonzero(out_of_reach)}
    return {point: why for point, why in refusals.items() if why is not None}


def _is_surely_near(problem: FleetProblem, vehicle: int) -> BoolArray:
    """Return which points a vehicle reaches for sure with its first battery, shape (n,)."""
    spec, points = problem.vehicles[vehicle], np.arange(len(problem.points))
    if problem.flight(vehicle).passes:  # its corners are known flight by flight only
        return np.zeros(len(points), dtype=bool)
    end = problem.end_site(vehicle)
    out = problem.legs_s(vehicle, np.array([problem.start_site(vehicle)]), points)
    back = 0.0 if end is None else problem.legs_s(vehicle, points, np.array([end]))
    needed = problem.first_fixed_s(vehicle) + spec.hover_s + out + back
    return np.asarray(needed <= spec.first_endurance_s)


def _refusal(problem: FleetProblem, point: int) -> BeyondEnduranceError | None:
    """Return why no vehicle can visit a point alone; None: one can."""
    why = None
    for k in range(len(problem.vehicles)):
        if not problem.allowed(k)[point]:
            continue
        try:
            sorties(problem, k, [point])
        except BeyondEnduranceError as error:
            why = why or error
        else:
            return None
    return why


def proven_shortage_s(problem: FleetProblem) -> float:
    """Return the time that some route surely takes, if no battery lasts for it; 0: unknown.

    The bound is one of those that need no search; the vehicles may change no battery.
    """
    if any(vehicle.battery_swap_s is not None for vehicle in problem.vehicles):
        return 0.0
    longest_s = max(vehicle.first_endurance_s for vehicle in problem.vehicles)
    routed = routing_problem(problem, 'longest_time', is_bounded=True)
    best = max(bound.value for bound in islice(improving_bounds(routed, longest_s), CHEAP_BOUNDS))
    return best if best > longest_s * (1.0 + 1e-6) else 0.0


def most_served(problem: FleetProblem, effort: Effort) -> list[Order]:
    """Return routes within the batteries that visit as many points as a search finds.

    To the search, points that are left out are those of one more vehicle, which visits each for
    more than any other vehicle would spend on it.
    """
    routed = routing_problem(problem, 'total_time')
    found = solve(_with_leftovers(routed), search_options(len(problem.points), effort))
    return [_shortened(problem, k, list(route)) for k, route in enumerate(found.routes[:-1])]


def _with_leftovers(problem: RoutingProblem) -> RoutingProblem:
    """Return the problem with a last vehicle whose route is what the others leave out."""
    price = 1.0 + relax_far(problem)
    nobody = RoutedVehicle(
        start=problem.vehicles[0].start, end=problem.vehicles[0].start, legs=len(problem.legs)
    )
    allowed = problem.allowed
    if allowed is not None:
        allowed = np.vstack([allowed, np.ones((1, problem.customers), dtype=bool)])
    return replace(
        problem,
        vehicles=(*problem.vehicles, nobody),
        legs=(*problem.legs, PointLegs(speed_mps=_AT_ONCE_MPS, stay=price)),
        allowed=allowed,
    )


def _shortened(problem: FleetProblem, vehicle: int, order: Order) -> Order:
    """Return an order without its last points until the battery lasts.

    The search knows flights that pass their viewpoints by estimates only.
    """
    while order:
        try:
            sorties(problem, vehicle, order)
        except BeyondEnduranceError:
            order = order[:-1]
        else:
            break
    return order
