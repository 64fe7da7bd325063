# SPDX-License-Identifier: Apache-2.0
"""Flights between battery swaps as routes of their own, searched by the solver.

Every flight that a vehicle may make is a vehicle of its own to the solver: it begins and ends at
home, costs its climb, its descent and the swap, and must not exceed what a battery lasts for. The
least sum tells how few flights do; then vehicles are given so much time each that the sum just
fits in, and more where that was too little.
"""

import dataclasses
from dataclasses import dataclass
from functools import partial
from itertools import chain

from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.problem.flight_time import turn_s
from rocsafe_planner.routing.solver_problem import LegTable, idle_cost, priced, rest_s
from rocsafe_planner.routing.sorties import sorties
from rocsafe_planner.solver import RoutingProblem, SearchOptions, solve
from rocsafe_planner.solver import Vehicle as RoutedVehicle

MOST_FLIGHTS = 400
"""Largest number of flights of a fleet in one search."""

Caps = list[list[float]]
"""For each vehicle the longest time of each of its flights, in seconds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """Points that a vehicle visits with one battery."""

    vehicle: int
    points: Order


@dataclass(frozen=True, slots=True, kw_only=True)
class Slot:
    """Flight `number` of a vehicle, and the longest time that it may take."""

    vehicle: int
    number: int
    of: int
    cap_s: float


def may_search(problem: FleetProblem) -> bool:
    """Return whether the flights of each vehicle are equal, except for the end of the last one."""
    return all(
        v.aloft is None or not (v.is_open or v.end is not None or v.battery_swap_s is None)
        for v in problem.vehicles
    )


def flights_of(problem: FleetProblem, orders: list[Order]) -> list[Flight]:
    """Return the flights into which routes are split."""
    return [
        Flight(vehicle=k, points=points)
        for k, order in enumerate(orders)
        for points in sorties(problem, k, order)
        if points
    ]


def full_caps(problem: FleetProblem, flights: int) -> Caps:
    """Return so many flights for each vehicle that swaps, one for the others, all full."""
    if flights * len(problem.vehicles) > MOST_FLIGHTS:
        return []
    return [
        [v.first_endurance_s] + [v.endurance_s] * (0 if v.battery_swap_s is None else flights - 1)
        for v in problem.vehicles
    ]


def caps_within(problem: FleetProblem, time_s: float) -> Caps:
    """Return the flights that each vehicle can make until then: full ones, and a shorter one."""
    caps: Caps = []
    for k, v in enumerate(problem.vehicles):
        own: list[float] = []
        left_s, endurance_s = time_s, v.first_endurance_s
        while left_s > problem.fixed_s(k) or not own:
            own.append(min(left_s, endurance_s))
            if v.battery_swap_s is None or len(own) > MOST_FLIGHTS:
                break
            left_s -= endurance_s + v.battery_swap_s
            endurance_s = v.endurance_s
        if v.aloft is None and v.used_s == 0.0:
            own.reverse()  # whoever lands elsewhere does so after a full flight
        caps.append(own)
    return caps


def time_of_flights(problem: FleetProblem, count: int) -> float:
    """Return when the fleet has made so many full flights; 0 if it cannot."""
    times: list[float] = []
    for v in problem.vehicles:
        more = 0 if v.battery_swap_s is None else count - 1
        swap_s = v.battery_swap_s or 0.0
        times.extend(
            v.first_endurance_s + number * (v.endurance_s + swap_s) for number in range(more + 1)
        )
    # A tolerance, because sums of times have rounding errors.
    return sorted(times)[count - 1] * (1.0 + 1e-9) if 0 < count <= len(times) else 0.0


def searched(
    table: LegTable,
    caps: Caps,
    known: list[Flight],
    options: SearchOptions,
    objective: str = 'longest_time',
) -> list[Order]:
    """Return the points of each vehicle, flight after flight, with the least sum of costs.

    They are those that an objective of `OBJECTIVES` counts: times, lengths or energy.
    """
    owners = [k for k, own in enumerate(caps) for _ in own]
    start = _dealt(table.problem, caps, known)
    found = solve(_task(table, caps, objective), options, starts=[start])
    return [
        list(chain.from_iterable(r for r, k in zip(found.routes, owners, strict=True) if k == one))
        for one in range(len(caps))
    ]


def _task(table: LegTable, caps: Caps, objective: str) -> RoutingProblem:
    problem = table.problem
    owners = [k for k, own in enumerate(caps) for _ in own]
    vehicles = tuple(
        _flight(table, Slot(vehicle=k, number=number, of=len(own), cap_s=cap), objective)
        for k, own in enumerate(caps)
        for number, cap in enumerate(own)
    )
    return RoutingProblem(
        customers=len(problem.points),
        vehicles=vehicles,
        legs=tuple(table.legs),
        points=problem.sites,
        allowed=None if problem.may_visit is None else problem.may_visit[owners],
        objective='sum',
    )


def _flight(table: LegTable, slot: Slot, objective: str) -> RoutedVehicle:
    """Return a flight as a vehicle of the solver."""
    problem, vehicle, place_of = table.problem, slot.vehicle, table.place_of
    home, end = place_of[problem.home_site(vehicle)], problem.end_site(vehicle)
    is_first, is_last = slot.number == 0, slot.number == slot.of - 1
    spec = problem.vehicles[vehicle]
    spec = spec if is_last else dataclasses.replace(spec, is_open=False, end=None)
    climb_s = problem.first_fixed_s(vehicle) if is_first else problem.fixed_s(vehicle)
    legs, fixed = priced(spec, vehicle, table, objective, climb_s)
    swap_s = 0.0 if is_last or not objective.endswith('time') else spec.battery_swap_s or 0.0
    time = table.time(vehicle)
    flight = problem.flight(vehicle)
    slack_s = 2.0 * turn_s(flight.performance) if flight.passes else 0.0
    return RoutedVehicle(
        start=place_of[problem.start_site(vehicle)] if is_first else home,
        end=home if not is_last else None if end is None else place_of[end],
        legs=legs,
        fixed_cost=fixed + swap_s,
        idle_cost=idle_cost(problem, vehicle, objective) if is_first else 0.0,
        limit=max(0.0, slot.cap_s - climb_s - rest_s(spec, table.legs[time]) - slack_s)
        * table.share(vehicle),
        limit_legs=time,
    )


def _dealt(
    problem: FleetProblem, caps: Caps, flights: list[Flight]
) -> tuple[tuple[int, ...], ...]:
    """Return the flights at places long enough, rather at their own vehicles', longest first."""
    places = [(k, cap) for k, own in enumerate(caps) for cap in own]
    dealt: list[Order] = [[] for _ in places]
    times = [problem.duration_s(flight.vehicle, flight.points) for flight in flights]

    def badness(place: int, number: int) -> tuple[bool, bool, bool, bool, float]:
        flight, (owner, cap) = flights[number], places[place]
        is_able = bool(problem.allowed(owner)[flight.points].all())
        is_short = cap < times[number]
        return (not is_able, bool(dealt[place]), is_short, owner != flight.vehicle, cap)

    for number in sorted(range(len(flights)), key=lambda i: (-times[i], i)):
        best = min(range(len(places)), key=partial(badness, number=number))
        dealt[best].extend(flights[number].points)
    return tuple(map(tuple, dealt))
