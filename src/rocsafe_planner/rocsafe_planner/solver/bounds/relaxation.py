# SPDX-License-Identifier: Apache-2.0
"""Relaxation of a routing problem: the cheapest cost of each leg over all vehicles."""

from dataclasses import dataclass

import numpy as np

from rocsafe_planner.solver.model.problem import PointLegs, RoutingProblem, Vehicle
from rocsafe_planner.solver.model.tables import Floats

CLOSURE_SITES = 800
"""Most sites of a given matrix that is changed to satisfy the triangle inequality."""
DENSE_CUSTOMERS = 800
"""Most customers whose legs are kept as a table."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Relaxation:
    """Cheapest legs over a set of vehicles: lower bounds of the legs of each vehicle.

    All starts are merged into one: the first leg to a customer costs at least the cheapest leg
    from any start. The same holds for the ends and for the two directions of a leg.
    """

    costs: Floats
    """(n, n) cheapest leg between customers; empty if `points` are used instead."""
    points: Floats
    """(n, 3) places of the customers, if there are too many for a table; empty otherwise."""
    pace: Floats
    """(measures, 5) pace and whole stay of each measure, if `points` are used; empty otherwise."""
    start: Floats
    """(n,) cheapest first leg to each customer; in units of `shares` for the objective `max`."""
    end: Floats
    """(n,) cheapest last leg from each customer, in the same units."""
    own: Floats
    """(2, m, n) `start` and `end` of each vehicle alone; (2, 0, n) if these are equal for all."""
    around: Floats
    """(n,) cheapest route that serves only this customer, with fixed cost; 0 if not known."""
    shares: Floats
    """(m,) at k: sum of the k + 1 largest 1/a; legs of a vehicle cost at least a times `costs`."""
    fixed: Floats
    """(m,) at k: lower bound of the fixed cost of the costliest of k + 1 routes."""
    closed: bool
    """Whether leaving out a customer never makes a route costlier (triangle inequality)."""
    one_depot: bool
    """Whether all routes start and end at one site, to and from which legs cost the same."""
    longest: float = np.inf
    """Largest allowed cost of the legs of a route."""
    fewest: int = 1
    """Smallest number of routes that can serve all customers."""


def leg_tables(problem: RoutingProblem) -> tuple[list[Floats], bool]:
    """Return directed cost tables, (sites, sites) each, with the triangle inequality if possible.

    The flag tells whether all tables satisfy it. Legs between points always do; a given matrix
    with at most `CLOSURE_SITES` sites is changed to its shortest paths.
    """
    tables, closed = [], True
    for legs in problem.legs:
        if isinstance(legs, PointLegs):
            tables.append(legs.costs(problem.places, problem.customers))
            continue
        table = np.array(legs.matrix, np.float64)
        np.fill_diagonal(table, 0.0)
        if len(table) > CLOSURE_SITES:
            closed = False
        else:
            for k in range(len(table)):
                np.minimum(table, table[:, k, None] + table[None, k, :], out=table)
        tables.append(table)
    return tables, closed


def relax(problem: RoutingProblem, crew: tuple[int, ...]) -> Relaxation:
    """Return the relaxation of a problem served by some of its vehicles."""
    if problem.customers > DENSE_CUSTOMERS and all(isinstance(k, PointLegs) for k in problem.legs):
        return _relax_points(problem, crew)
    return _relax_tables(problem, crew)


def _relax_tables(problem: RoutingProblem, crew: tuple[int, ...]) -> Relaxation:
    """Return the relaxation with tables of legs."""
    n = problem.customers
    tables, closed = leg_tables(problem)
    vehicles = [problem.vehicles[v] for v in crew]
    between = {v.legs: np.minimum(tables[v.legs], tables[v.legs].T)[:n, :n] for v in vehicles}
    costs = np.minimum.reduce(list(between.values()))
    factors = {kind: _least_ratio(table, costs) for kind, table in between.items()}
    # For the objective `sum`, the legs are not divided by the factor of the vehicle.
    worth = [factors[v.legs] if problem.objective == 'max' else 1.0 for v in vehicles]
    halves = end_stays(problem)
    starts = [tables[v.legs][v.start, :n] for v in vehicles]
    ends = [halves[v.legs] if v.end is None else tables[v.legs][:n, v.end] for v in vehicles]
    around = [v.fixed_cost + s + e for v, s, e in zip(vehicles, starts, ends, strict=True)]
    symmetric = all(
        np.array_equal(tables[v.legs][v.start], tables[v.legs][:, v.start]) for v in vehicles
    )
    own_starts = [legs / a for legs, a in zip(starts, worth, strict=True)]
    own_ends = [legs / a for legs, a in zip(ends, worth, strict=True)]
    return Relaxation(
        costs=costs,
        points=np.zeros((0, 3)),
        pace=np.zeros((0, 5)),
        start=np.minimum.reduce(own_starts),
        end=np.minimum.reduce(own_ends),
        own=_own(vehicles, own_starts, own_ends),
        around=_allowed_around(problem, crew, around) if closed else np.zeros(n),
        shares=_shares([factors[v.legs] for v in vehicles]),
        fixed=_fixed(problem, vehicles, factors),
        closed=closed,
        one_depot=symmetric
        and len({(v.start, v.end) for v in vehicles}) == 1
        and vehicles[0].start == vehicles[0].end,
    )


def _relax_points(problem: RoutingProblem, crew: tuple[int, ...]) -> Relaxation:
    """Return the relaxation whose legs are computed from points when needed."""
    n = problem.customers
    vehicles = [problem.vehicles[v] for v in crew]
    kinds = sorted({v.legs for v in vehicles})
    point_legs = [problem.legs[k] for k in kinds]
    starts = [_point_leg(problem, v.legs, v.start) for v in vehicles]
    ends = [_point_leg(problem, v.legs, v.end) for v in vehicles]
    around = [v.fixed_cost + s + e for v, s, e in zip(vehicles, starts, ends, strict=True)]
    points = np.zeros((n, 3))
    points[:, : problem.places.shape[1]] = problem.places[:n]
    return Relaxation(
        costs=np.zeros((0, 0)),
        points=points,
        pace=np.array([(*k.pace(), k.stay) for k in point_legs if isinstance(k, PointLegs)]),
        start=np.minimum.reduce(starts),
        end=np.minimum.reduce(ends),
        own=_own(vehicles, starts, ends),
        around=_allowed_around(problem, crew, around),
        shares=_shares([1.0] * len(vehicles)),
        fixed=_fixed(problem, vehicles, {}),
        closed=True,
        one_depot=len({(v.start, v.end) for v in vehicles}) == 1
        and vehicles[0].start == vehicles[0].end,
    )


def _point_leg(problem: RoutingProblem, kind: int, site: int | None) -> Floats:
    """Return the costs of the legs between a site and each customer, half a stay included.

    For the site None (an open route) they are half a stay only.
    """
    legs = problem.legs[kind]
    if not isinstance(legs, PointLegs):
        raise TypeError(f'legs {kind} are no PointLegs')
    half = np.full(problem.customers, legs.stay / 2)
    if site is None:
        return half
    distance = np.linalg.norm(problem.places[: problem.customers] - problem.places[site], axis=1)
    slowness, ramp, short, factor = legs.pace()
    flown = np.where(distance >= short, distance * slowness + ramp, factor * np.sqrt(distance))
    return np.asarray(flown + half, np.float64)


def end_stays(problem: RoutingProblem) -> list[Floats]:
    """Return, for each kind of legs, the stay left at the last customer of an open route."""
    stays = [legs.stay / 2 if isinstance(legs, PointLegs) else 0.0 for legs in problem.legs]
    return [np.full(problem.customers, stay) for stay in stays]


def _allowed_around(
    problem: RoutingProblem, crew: tuple[int, ...], around: list[Floats]
) -> Floats:
    """Return the cheapest route that serves one customer only, by a vehicle that may serve it."""
    table = np.array(around)
    if problem.allowed is not None:
        table = np.where(problem.allowed[list(crew)], table, np.inf)
    least = np.asarray(table.min(axis=0), np.float64)
    return np.where(np.isfinite(least), least, 0.0)


def _least_ratio(table: Floats, least: Floats) -> float:
    """Return the largest a with table >= a * least."""
    rated = least > 0
    return float((table[rated] / least[rated]).min()) if rated.any() else 1.0


def _own(vehicles: list[Vehicle], starts: list[Floats], ends: list[Floats]) -> Floats:
    """Return first and last legs of each vehicle, if their starts or ends differ."""
    if len({(v.start, v.end) for v in vehicles}) == 1:
        return np.zeros((2, 0, len(starts[0])))
    return np.array([starts, ends])


def _fixed(problem: RoutingProblem, vehicles: list[Vehicle], factors: dict[int, float]) -> Floats:
    """Return at k the least mean of what k + 1 routes cost besides their legs.

    Where legs of vehicles differ, waits for others are left out: whose they are would matter.
    """
    apart = problem.apart if set(factors.values()) <= {1.0} else 0.0
    waits: Floats = 0.5 * apart * np.arange(len(vehicles), dtype=np.float64)
    return waits + min(v.fixed_cost for v in vehicles)


def _shares(factors: list[float]) -> Floats:
    """Return at k the sum of the k + 1 largest reciprocals of the factors."""
    return np.cumsum(np.sort(1 / np.array(factors))[::-1])
