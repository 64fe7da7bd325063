# SPDX-License-Identifier: Apache-2.0
"""Lower bounds of the objective over all plans.

All bounds ignore the limits of the vehicles. They use the cheapest legs of any vehicle (see
`Relaxation`), so they hold for different starts, ends, speeds and directions. A function whose
bound needs further conditions states them, and is only used where they hold.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_planner.solver.bounds.forest import Ascent, edge_lengths
from rocsafe_planner.solver.bounds.relaxation import Relaxation, relax
from rocsafe_planner.solver.model.neighbours import near_points
from rocsafe_planner.solver.model.problem import PointLegs, RoutingProblem, Vehicle, leg_cost
from rocsafe_planner.solver.model.tables import Floats, Ints

SAFETY = 1e-9
"""Relative amount by which bounds are lowered, to cover rounding errors."""
SHELLS = 10
SPACING_SHELLS = 200
STEPS = 12
"""Steps of the ascent between two checks of the time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bound:
    """A proven lower bound of the objective, and the name of its proof."""

    value: float
    name: str


def farthest_bound(relaxed: Relaxation) -> float:
    """Return the largest cost of a route to one customer only; needs the triangle inequality."""
    return float(relaxed.around.max(initial=0.0))


def homeward_bound(problem: RoutingProblem) -> float:
    """Return the least cost of the vehicles, whether they serve customers or not."""
    least = [_homeward_cost(problem, vehicle) for vehicle in problem.vehicles]
    return max(least) if problem.objective == 'max' else sum(least)


def _homeward_cost(problem: RoutingProblem, vehicle: Vehicle) -> float:
    """Return the least cost of a vehicle.

    The leg to its end counts only between points: in a matrix a detour may be cheaper.
    """
    flown = 0.0
    if vehicle.end is not None and isinstance(problem.legs[vehicle.legs], PointLegs):
        flown = leg_cost(problem, vehicle.legs, vehicle.start, vehicle.end)
    return min(vehicle.idle_cost, vehicle.fixed_cost + flown)


def spacing_bound(
    relaxed: Relaxation, total: bool, shortest: float, members: Ints | None = None
) -> float:
    """Return the bound from the shortest leg between any two customers; it is tight on grids.

    m routes over n customers fly at least n - m legs between them, each no shorter than the
    shortest. If q routes serve more than one customer, they have 2q different ends; the others
    serve one each. With the triangle inequality it also holds for a subset, `members`.
    """
    start = relaxed.start if members is None else relaxed.start[members]
    end = relaxed.end if members is None else relaxed.end[members]
    n, m = len(start), len(relaxed.shares)
    routes = np.arange(1, min(m, n // 2) + 1)
    if n <= m or not len(routes):
        return 0.0
    either = np.cumsum(np.sort(np.minimum(start, end)))[2 * routes - 1]
    apart = (np.cumsum(np.sort(start)) + np.cumsum(np.sort(end)))[routes - 1]
    legs = shortest * (n - m) + np.maximum(either, apart)
    levels = legs if total else legs / relaxed.shares[routes - 1] + relaxed.fixed[routes - 1]
    return float(levels.min())


def shell_spacing_bound(relaxed: Relaxation, shortest: float) -> float:
    """Return the best spacing bound of the customers outside a circle around the depot.

    At most m routes leave the circle. On a grid it is as tight as the forest bound of a shell.
    """
    away = relaxed.start + relaxed.end
    order = np.argsort(-away, kind='stable').astype(np.int32)
    sizes = np.unique(np.linspace(1, len(order), SPACING_SHELLS).astype(np.int64))
    return max(spacing_bound(relaxed, False, shortest, order[:size]) for size in sizes)


def shortest_leg(relaxed: Relaxation) -> float:
    """Return the cheapest leg between two different customers."""
    if len(relaxed.start) < 2:
        return 0.0
    if len(relaxed.costs):
        table = relaxed.costs + np.diag(np.full(len(relaxed.costs), np.inf))
        return float(table.min())
    n = len(relaxed.start)
    near = near_points(relaxed.points, 1)[:, 0]
    return float(edge_lengths(relaxed, np.arange(n, dtype=np.int32), near).min())


def improving_bounds(problem: RoutingProblem, target: float) -> Iterator[Bound]:
    """Yield better and better bounds, cheap ones first, until the ascents stall.

    Parameters
    ----------
    problem
        Problem whose objective is bounded.
    target
        Cost of a known plan: sets the steps of the ascent, is no part of the bounds.
    """
    if problem.customers == 0:
        yield Bound(value=homeward_bound(problem) * (1 - SAFETY), name='homeward')
        return
    best = -np.inf
    for value, name in _all_bounds(problem, target):
        if value > best:
            best = value
            yield Bound(value=value * (1 - SAFETY), name=name)
        else:
            yield Bound(value=best * (1 - SAFETY), name='')


def _all_bounds(problem: RoutingProblem, target: float) -> Iterator[tuple[float, str]]:
    """Yield bounds in the order of their computing time."""
    total = problem.objective == 'sum'
    crew = tuple(range(len(problem.vehicles)))
    yield homeward_bound(problem), 'homeward'
    relaxed = relax(problem, crew)
    base = idle_base(problem) if total else 0.0
    if relaxed.closed:
        yield farthest_bound(relaxed), 'farthest'
    shortest = shortest_leg(relaxed)
    yield spacing_bound(relaxed, total, shortest) + base, 'spacing'
    if relaxed.closed and not total:
        yield shell_spacing_bound(relaxed, shortest), 'shell spacing'
    everybody = np.arange(problem.customers, dtype=np.int32)
    ascent = Ascent(relaxed=relaxed, members=everybody, total=total)
    for value in climb(ascent, target - base, 60):
        yield value + base, 'forest'
    if relaxed.closed and not total:
        yield from _shell_bounds(relaxed, ascent, target)
        yield from _ability_bounds(problem, target)
    for value in climb(ascent, target - base, 1000):
        yield value + base, 'forest'


def idle_base(problem: RoutingProblem) -> float:
    """Return the sum of the costs of the vehicles without legs, whichever vehicles fly."""
    return sum(min(v.idle_cost, v.fixed_cost) for v in problem.vehicles)


def climb(ascent: Ascent, target: float, steps: int) -> Iterator[float]:
    """Yield the proven bound of an ascent every `STEPS` steps, until it stalls."""
    proven = 0.0
    for step in range(steps):
        ascent.step(target)
        if step % STEPS == STEPS - 1:
            if ascent.best > proven:
                proven = max(proven, ascent.proven())
            yield proven
            if ascent.exhausted:
                return


def _shell_bounds(
    relaxed: Relaxation, whole: Ascent, target: float
) -> Iterator[tuple[float, str]]:
    """Yield bounds from the customers outside larger and larger shells around starts and ends.

    At most m routes leave a shell. Needs the triangle inequality, to leave out those inside.
    """
    away = relaxed.start + relaxed.end
    levels = np.quantile(away, np.linspace(0, 1, SHELLS + 2)[1:-1])
    ascents = []
    for level in levels:
        members = np.flatnonzero(away >= level).astype(np.int32)
        ascents.append(
            Ascent(relaxed=relaxed, members=members, total=False, price=whole.best_price.copy())
        )
    for steps in (24, 120, 600):
        ascents.sort(key=lambda ascent: -ascent.best)
        for ascent in ascents[: max(2, SHELLS * 24 // steps)]:
            for value in climb(ascent, target, steps):
                yield value, 'shell'


def _ability_bounds(problem: RoutingProblem, target: float) -> Iterator[tuple[float, str]]:
    """Yield bounds from customers that only some vehicles may serve."""
    if problem.allowed is None:
        return
    for crew_mask in np.unique(problem.allowed.T, axis=0):
        if crew_mask.all():
            continue
        inside = ~(problem.allowed & ~crew_mask[:, None]).any(axis=0)
        relaxed = relax(problem, tuple(int(v) for v in np.flatnonzero(crew_mask)))
        members = np.flatnonzero(inside).astype(np.int32)
        ascent = Ascent(relaxed=relaxed, members=members, total=False)
        for value in climb(ascent, target, 60):
            yield value, 'ability'


def held_karp_bound(problem: RoutingProblem, target: float, steps: int = 200) -> float | None:
    """Return the Held-Karp bound of one tour, divided by the number of vehicles, as in the paper.

    Valid for routes that start and end at one depot, with the triangle inequality and for the
    objective `max`; None otherwise.
    """
    relaxed = relax(problem, tuple(range(len(problem.vehicles))))
    if not (relaxed.one_depot and relaxed.closed) or problem.objective == 'sum':
        return None
    alone = replace(relaxed, shares=np.ones(1))
    everybody: Ints = np.arange(problem.customers, dtype=np.int32)
    ascent = Ascent(relaxed=alone, members=everybody, total=True)
    share: Floats = relaxed.shares
    levels = list(climb(ascent, target * float(share[-1]), steps))
    return float(max(levels, default=0.0) / share[-1] + relaxed.fixed[0])
