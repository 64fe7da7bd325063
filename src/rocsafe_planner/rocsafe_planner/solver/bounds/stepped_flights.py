# SPDX-License-Identifier: Apache-2.0
"""Flights of vehicles in steps of time, to which legs are rounded down."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_planner.solver.bounds.relaxation import end_stays, leg_tables
from rocsafe_planner.solver.model.problem import RoutingProblem
from rocsafe_planner.solver.model.tables import Floats, Ints

ROUNDING = 1e-9
COARSE_STEPS = 500
"""Steps of a known plan from which the work of shorter ones is told."""
MOST_STEPS = 10_000
"""Steps of a known plan at most, which bounds the memory."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryChanges:
    """Flights of a vehicle that changes its battery at home.

    Attributes
    ----------
    home
        Site of the changes.
    fixed, first_fixed
        Fixed cost of a flight from home, and of the first one if others follow.
    longest, first_longest
        Most that a flight costs, fixed cost included, and the first one.
    change
        Cost of a change.
    """

    home: int
    fixed: float
    first_fixed: float
    longest: float
    first_longest: float
    change: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Flight:
    """Steps of the first and last leg of a flight, and most steps of the whole."""

    first: Ints
    last: Ints
    longest: int

    def is_like(self, other: 'Flight') -> bool:
        """Return whether two flights are of the same steps."""
        return (
            np.array_equal(self.first, other.first)
            and np.array_equal(self.last, other.last)
            and self.longest == other.longest
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Kind:
    """Vehicles that fly alike: their legs in steps, and whom they may serve.

    Attributes
    ----------
    flights
        Flights that differ; the first of them is all that a vehicle without changes flies.
    chain
        Numbers of the flight before the first change, of one between changes, and of that after
        the last; None: no battery is changed.
    change
        Steps of a change.
    """

    legs: Ints
    allowed: Floats
    count: int
    flights: tuple[Flight, ...]
    chain: tuple[int, int, int] | None
    change: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Walks:
    """All kinds of vehicles, the length of a step, and the number of those of a known plan.

    `apart` are the steps that vehicles wait for each other, see `RoutingProblem`.
    """

    kinds: tuple[Kind, ...]
    unit: float
    steps: int
    apart: float = 0.0

    @property
    def longest(self) -> int:
        """Steps of the longest flight."""
        most = max(flight.longest for kind in self.kinds for flight in kind.flights)
        return min(most, self.steps)

    @property
    def work(self) -> float:
        """Additions of a round."""
        total = 0.0
        for kind in self.kinds:
            for flight in kind.flights:
                longest = min(flight.longest, self.steps)
                chained = 0 if kind.chain is None else self.steps
                total += longest * (float(kind.legs.size) + chained)
        return total


def walks_of(
    problem: RoutingProblem,
    known: float,
    changes: Sequence[BatteryChanges | None],
    finest: float,
    work: float,
) -> Walks | None:
    """Return the walks, in steps so long that a short leg takes at most `finest` of them.

    They are longer if a round would take more work. None if a leg is shorter than a step: rounded
    down it would cost nothing.
    """
    if known <= 0.0:
        return None
    tables, _ = leg_tables(problem)
    n = problem.customers
    near = np.concatenate([np.sort(table[:n, :n], axis=1)[:, 1:5].ravel() for table in tables])
    coarse = _walks(problem, tables, known / COARSE_STEPS, known, changes)
    least = max(coarse.unit * coarse.work / work, known / MOST_STEPS)
    if n == 1:
        return _walks(problem, tables, least, known, changes)
    unit = _unit(near, max(least, float(np.median(near)) / finest))
    return None if near.min() < unit else _walks(problem, tables, unit, known, changes)


def _walks(
    problem: RoutingProblem,
    tables: list[Floats],
    unit: float,
    known: float,
    changes: Sequence[BatteryChanges | None],
) -> Walks:
    """Return the walks in steps of a length."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for k, vehicle in enumerate(problem.vehicles):
        who = b'' if problem.allowed is None else problem.allowed[k].tobytes()
        ends = (vehicle.legs, vehicle.start, vehicle.end, vehicle.fixed_cost)
        alike.setdefault((*ends, _longest(problem, k), changes[k], who), []).append(k)
    kinds = tuple(
        _kind(problem, members, tables, unit, changes[members[0]]) for members in alike.values()
    )
    # Vehicles of different kinds could give each other the longer waits.
    apart = problem.apart / unit if len(kinds) == 1 else 0.0
    return Walks(kinds=kinds, unit=unit, steps=int(known / unit) + 1, apart=apart)


def _kind(
    problem: RoutingProblem,
    members: list[int],
    tables: list[Floats],
    unit: float,
    changes: BatteryChanges | None,
) -> Kind:
    """Return vehicles that fly alike."""
    n, number = problem.customers, members[0]
    vehicle = problem.vehicles[number]
    table = tables[vehicle.legs]
    stays = end_stays(problem)[vehicle.legs]

    def flight(start: int, end: int | None, fixed: float, longest: float) -> Flight:
        return Flight(
            first=_in_steps(fixed + table[start, :n], unit),
            last=_in_steps(stays if end is None else table[:n, end], unit),
            longest=int(min(longest / unit * (1.0 + ROUNDING) + ROUNDING, 2**30)),
        )

    limit = _longest(problem, number) if changes is None else changes.first_longest
    flown = [flight(vehicle.start, vehicle.end, vehicle.fixed_cost, limit)]
    if changes is not None:
        home, longest = changes.home, changes.longest
        flown += [
            flight(vehicle.start, home, changes.first_fixed, limit),
            flight(home, home, changes.fixed, longest),
            flight(home, vehicle.end, changes.fixed, longest),
        ]
    different: list[Flight] = []
    numbers = []
    for one in flown:
        like = [k for k, other in enumerate(different) if one.is_like(other)]
        numbers.append(like[0] if like else len(different))
        different += [] if like else [one]
    return Kind(
        legs=_in_steps(table[:n, :n], unit),
        allowed=np.ones(n) if problem.allowed is None else problem.allowed[number].astype(float),
        count=len(members),
        flights=tuple(different),
        chain=None if changes is None else (numbers[1], numbers[2], numbers[3]),
        change=0 if changes is None else int(changes.change / unit + ROUNDING),
    )


def _longest(problem: RoutingProblem, k: int) -> float:
    """Return the most that a route of a vehicle may cost by its limit."""
    vehicle = problem.vehicles[k]
    is_same = vehicle.limiting_legs == vehicle.legs
    return vehicle.fixed_cost + vehicle.limit if is_same else np.inf


def _in_steps(costs: Floats, unit: float) -> Ints:
    return np.floor(costs / unit + ROUNDING).astype(np.int32)


def _unit(near: Floats, least: float) -> float:
    """Return the length of a step, up to twice the least, that loses least of the short legs."""
    units = np.linspace(2.0 * least, least, 400)
    lost = [float((near - unit * np.floor(near / unit + ROUNDING)).mean()) for unit in units]
    return float(units[int(np.argmin(lost))])
