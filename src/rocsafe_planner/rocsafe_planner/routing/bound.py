# SPDX-License-Identifier: Apache-2.0
"""Lower bounds of the makespan of all plans, from each vehicle's own home to its own end.

The ROCSAFE paper divides the optimal tour by the number of agents, which holds only for closed
routes from one shared depot: two drones that stand on their own waypoints need no time at all.
Here every vehicle has its own home, end, speed and time of climb, and `rocsafe_planner.solver`
proves what no routes undercut. Where batteries are changed, their changes and the ways to and
from them are counted too. Where legs share corners, or are very many, they count as the shorter
ones of `routing_task`. Delays and layers are left out, which only lowers the bound.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import islice

from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_planner.routing.solver_problem import routing_problem, same_places
from rocsafe_planner.solver import RoutingProblem, improving_bounds
from rocsafe_planner.solver import Vehicle as RoutedVehicle
from rocsafe_planner.solver.bounds.flights import Batteries, flight_bounds
from rocsafe_planner.solver.bounds.stepped_flights import BatteryChanges
from rocsafe_planner.solver.bounds.walk_prices import PriceOptions, price_bounds
from rocsafe_planner.solver.model.compiled import IS_COMPILED

# Number of computed bounds: a count and no time, so that the bound is reproducible.
_LOOKS_TIMES_POINTS = 8_000
CLOSE_ENOUGH = 1.01
"""A plan is not worth a better bound if it is at most so many times as long as the best one."""
_FEWEST_LOOKS, _MOST_LOOKS = 6, 40
# The same without compiled loops: only the bounds that need none.
_PLAIN_LOOKS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class LowerBound:
    """Lower bound `makespan_s` of the makespan of all plans, and the name of its proof."""

    makespan_s: float
    method: str


def lower_bound(
    problem: FleetProblem,
    known_makespan_s: float,
    keep_going: Callable[[float], bool],
    prices: PriceOptions | None = None,
) -> LowerBound:
    """Return the best of the bounds; docs/planning.md lists their names.

    Parameters
    ----------
    problem
        With at least one point.
    known_makespan_s
        Of any plan; it steers the ascent and does not change what is proven.
    keep_going
        Told the best bound so far, once there is one; the work ends early when it returns False.
    prices
        How the prices of viewpoints are sought, the longest part of the work; None: not at all.
    """
    best = LowerBound(makespan_s=0.0, method='none')
    for value, name in _bounds(problem, known_makespan_s, prices):
        if value > best.makespan_s:
            best = LowerBound(makespan_s=value, method=name)
        if best.makespan_s > 0.0 and not keep_going(best.makespan_s):
            break
        if best.makespan_s <= known_makespan_s <= best.makespan_s * CLOSE_ENOUGH:
            break
    return best


def _bounds(
    problem: FleetProblem, known_s: float, prices: PriceOptions | None
) -> Iterator[tuple[float, str]]:
    """Yield bounds and their names."""
    routed = routing_problem(problem, 'longest_time', is_bounded=True)
    looks = _looks(len(problem.points)) if IS_COMPILED else _PLAIN_LOOKS
    for bound in islice(improving_bounds(routed, known_s), looks):
        yield bound.value, bound.name
    if IS_COMPILED and prices is not None:
        for value in price_bounds(routed, known_s, prices, battery_changes(problem)):
            yield value, 'prices'
    swaps_s = [v.battery_swap_s for v in problem.vehicles if v.battery_swap_s is not None]
    if not swaps_s or not IS_COMPILED:
        return
    batteries = Batteries(
        endurance=max(vehicle.endurance_s for vehicle in problem.vehicles), change=min(swaps_s)
    )
    flights = _flights(problem, routed)
    for value in islice(flight_bounds(routed, flights, batteries, known_s), looks):
        yield value * (1.0 - 1e-9), 'batteries'


def battery_changes(problem: FleetProblem) -> list[BatteryChanges | None]:
    """Return how each vehicle changes its battery; None: it does not."""
    place_of = same_places(problem)
    return [
        None
        if vehicle.battery_swap_s is None
        else BatteryChanges(
            home=place_of[problem.home_site(k)],
            fixed=problem.fixed_s(k),
            first_fixed=problem.first_fixed_s(k),
            longest=vehicle.endurance_s,
            first_longest=vehicle.first_endurance_s,
            change=vehicle.battery_swap_s,
        )
        for k, vehicle in enumerate(problem.vehicles)
    ]


def _looks(points: int) -> int:
    """Return the number of bounds that are computed: small problems need fewer steps."""
    affordable = max(_LOOKS_TIMES_POINTS // points, _FEWEST_LOOKS)
    return min(_FEWEST_LOOKS + points, affordable, _MOST_LOOKS)


def _flights(problem: FleetProblem, routed: RoutingProblem) -> RoutingProblem:
    """Return the problem in which every way to begin and to end a flight has a vehicle.

    A vehicle that changes batteries begins at its start or home, and ends at home or its end.
    """
    ways: list[RoutedVehicle] = []
    for k, vehicle in enumerate(routed.vehicles):
        ways.append(vehicle)
        if problem.vehicles[k].battery_swap_s is None:
            continue
        home = problem.home_site(k)
        fixed = min(vehicle.fixed_cost, problem.fixed_s(k))
        afresh = replace(vehicle, start=home, fixed_cost=fixed, limit=math.inf)
        ways += [replace(way, end=home) for way in (vehicle, afresh)]
        ways.append(afresh)
    return replace(routed, vehicles=tuple(ways), allowed=None)
