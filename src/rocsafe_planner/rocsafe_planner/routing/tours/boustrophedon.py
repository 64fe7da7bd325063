# SPDX-License-Identifier: Apache-2.0
"""Boustrophedon as in survey tools: rows of the grid up and down, split among the vehicles."""

import math
from collections.abc import Callable

import numpy as np

from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.tours.sensor_repair import with_sensors
from rocsafe_planner.routing.tours.tour_splitting import equal_parts, makespan_s, min_max_parts

# Points whose rows differ by less lie in one row.
_ROW_M = 0.01


def boustrophedon_equal(problem: FleetProblem) -> list[Order]:
    """Cut the track along rows, or along columns, into equal numbers of points."""
    return _better(problem, lambda rows: equal_parts(problem, serpentine(rows)))


def boustrophedon_minmax(problem: FleetProblem) -> list[Order]:
    """Cut the track along rows, or along columns, where the longest route is shortest."""
    return _better(problem, lambda rows: min_max_parts(problem, serpentine(rows)))


def strips(problem: FleetProblem) -> list[Order]:
    """Give all vehicles equal numbers of whole rows, or columns."""
    return _better(problem, lambda rows: _strips(problem, rows))


def serpentine(rows: list[Order]) -> Order:
    """Return the points row by row, every other row backwards."""
    return [i for k, row in enumerate(rows) for i in (row[::-1] if k % 2 else row)]


def grid_rows(problem: FleetProblem, turn_rad: float = 0.0) -> list[Order]:
    """Return the points of each row, from row to row, for the grid's axes turned by `turn_rad`."""
    angle = problem.grid_rad + turn_rad
    axes = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    along, across = (problem.points @ axes).T
    order = np.lexsort((along, across))
    breaks = np.flatnonzero(np.diff(across[order]) > _ROW_M) + 1
    rows = np.split(order, breaks)
    # Rounded, so that rounding errors do not decide the order in a row.
    return [row[np.argsort(along[row], kind='stable')].tolist() for row in rows]


def _strips(problem: FleetProblem, rows: list[Order]) -> list[Order]:
    shares = np.array_split(np.arange(len(rows)), len(problem.vehicles))
    tour = serpentine(rows)
    sequence = equal_parts(problem, tour)
    holders = sorted(
        range(len(sequence)),
        key=lambda k: tour.index(sequence[k][0]) if sequence[k] else len(tour),
    )
    orders: list[Order] = [[] for _ in problem.vehicles]
    for vehicle, share in zip(holders, shares, strict=True):
        orders[vehicle] = serpentine([rows[k] for k in share])
    return orders


def _better(problem: FleetProblem, cut: Callable[[list[Order]], list[Order]]) -> list[Order]:
    """Return the better of the routes by rows and by columns; those by rows if they are equal."""
    found = [with_sensors(problem, cut(grid_rows(problem, turn))) for turn in (0.0, 0.5 * math.pi)]
    return min(found, key=lambda orders: round(makespan_s(problem, orders), 6))
