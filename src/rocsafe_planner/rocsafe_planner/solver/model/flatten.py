# SPDX-License-Identifier: Apache-2.0
"""Conversion of a routing problem to the flat tables that the kernels read."""

import numpy as np

from rocsafe_planner.solver.model.neighbours import near_all_round, near_points, near_rows
from rocsafe_planner.solver.model.problem import MatrixLegs, PointLegs, RoutingProblem
from rocsafe_planner.solver.model.tables import Costs, Floats, Ints, Tables, Words

DENSE_SITES = 800
"""Up to here a matrix of legs stays in the processor's cache and beats computing square roots."""
NEAREST, EACH_SIDE = 4, 2
"""Neighbours of a customer that has a place: that many anywhere, and in each quadrant."""
NEIGHBOURS = 10
"""Neighbours of a customer that has none, or of few customers."""
FREE = np.uint64(1)


def tables_of(problem: RoutingProblem) -> Tables:
    """Return the tables of a problem; legs between points stay points if a matrix is too large."""
    dense = problem.sites <= DENSE_SITES or any(
        isinstance(legs, MatrixLegs) for legs in problem.legs
    )
    matrix = _matrix(problem) if dense else np.zeros((1, 1, 1), np.float32)
    vehicles = problem.vehicles
    nowhere = problem.sites
    limit = np.array([v.limit for v in vehicles])
    ability, needs = _abilities(problem)
    return Tables(
        matrix=matrix,
        points=np.zeros((1, 3)) if dense else _points(problem),
        pace=np.array([_pace(legs) for legs in problem.legs]),
        stay=_stays(problem),
        first=np.array([v.start for v in vehicles], np.int32),
        last=np.array([nowhere if v.end is None else v.end for v in vehicles], np.int32),
        measure=np.array([v.legs for v in vehicles], np.int32),
        limit_measure=np.array([v.limiting_legs for v in vehicles], np.int32),
        fixed=np.array([v.fixed_cost + v.wait_cost for v in vehicles]),
        idle=np.array([v.idle_cost for v in vehicles]),
        limit=limit,
        ability=ability,
        needs=needs,
        near=_near(problem, matrix),
        dense=dense,
        symmetric=not dense or bool((matrix == matrix.transpose(0, 2, 1)).all()),
        limited=bool(np.isfinite(limit).any()),
        restricted=problem.allowed is not None and not bool(problem.allowed.all()),
    )


def _matrix(problem: RoutingProblem) -> Costs:
    """Return the cost of every leg under every measure, with a free last site `nowhere`."""
    sites = problem.sites
    matrix = np.zeros((len(problem.legs), sites + 1, sites + 1), np.float32)
    for c, legs in enumerate(problem.legs):
        if isinstance(legs, MatrixLegs):
            matrix[c, :sites, :sites] = legs.matrix
            continue
        matrix[c, :sites, :sites] = legs.costs(_points(problem)[:sites], problem.customers)
        half = legs.halves(sites, problem.customers)
        matrix[c, :sites, sites] = half
        matrix[c, sites, :sites] = half
    return matrix


def _points(problem: RoutingProblem) -> Floats:
    """Return the coordinates of the sites, (sites + 1, 3), with a last row for `nowhere`."""
    points = np.zeros((problem.sites + 1, 3))
    points[:-1, : problem.places.shape[1]] = problem.places
    return points


def _pace(legs: PointLegs | MatrixLegs) -> tuple[float, float, float, float]:
    """Return the pace of legs; legs of a matrix have none."""
    return legs.pace() if isinstance(legs, PointLegs) else (0.0, 0.0, 0.0, 0.0)


def _stays(problem: RoutingProblem) -> Floats:
    """Return half of the time of each stay, (measures, sites + 1)."""
    stays = np.zeros((len(problem.legs), problem.sites + 1))
    for c, legs in enumerate(problem.legs):
        if isinstance(legs, PointLegs):
            stays[c, :-1] = legs.halves(problem.sites, problem.customers)
    return stays


def _abilities(problem: RoutingProblem) -> tuple[Words, Words]:
    """Return the bit of each vehicle, and for each customer the bits of its vehicles.

    Vehicles that may serve the same customers share a bit.

    Raises
    ------
    ValueError
        If vehicles differ in more than 64 ways.
    """
    m, n = len(problem.vehicles), problem.customers
    if problem.allowed is None:
        return np.full(m, FREE), np.full(n, FREE)
    kinds, kind_of = np.unique(problem.allowed, axis=0, return_inverse=True)
    if len(kinds) > 64:
        raise ValueError(f'allowed has {len(kinds)} different rows: at most 64 are supported')
    bits = FREE << np.arange(len(kinds), dtype=np.uint64)
    needs = np.bitwise_or.reduce(np.where(kinds, bits[:, None], np.uint64(0)), axis=0)
    return bits[kind_of.reshape(-1)], needs.astype(np.uint64)


def _near(problem: RoutingProblem, matrix: Costs) -> Ints:
    """Return the neighbours of each customer: by distance, or by mean cost of both directions."""
    n = problem.customers
    if n < 2:
        return np.zeros((n, 0), np.int32)
    mean = matrix[:, :n, :n].mean(axis=0)
    costs = (mean + mean.T).astype(np.float64) if len(mean) == n else None
    if problem.points is not None and n > NEAREST + 4 * EACH_SIDE:
        return near_all_round(_points(problem)[:n], NEAREST, EACH_SIDE, costs)
    count = min(NEIGHBOURS, n - 1)
    return near_points(_points(problem)[:n], count) if costs is None else near_rows(costs, count)
