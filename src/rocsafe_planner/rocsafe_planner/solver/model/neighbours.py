# SPDX-License-Identifier: Apache-2.0
"""Nearest customers of each customer, which limit the moves that the search tries."""

import numpy as np

from rocsafe_planner.solver.model.compiled import inner, kernel
from rocsafe_planner.solver.model.tables import Floats, Ints


@inner
def insert_sorted(near: Ints, apart: Floats, row: int, candidate: int, distance: float) -> None:
    """Insert a candidate into a row of nearest customers, sorted by distance, then by number."""
    k = near.shape[1] - 1
    last = apart[row, k]
    if distance > last or (distance == last and candidate > near[row, k]):
        return
    while k > 0 and (
        distance < apart[row, k - 1]
        or (distance == apart[row, k - 1] and candidate < near[row, k - 1])
    ):
        near[row, k] = near[row, k - 1]
        apart[row, k] = apart[row, k - 1]
        k -= 1
    near[row, k] = candidate
    apart[row, k] = distance


@kernel
def nearest_in_cells(
    points: Floats,
    cell_of: Ints,
    start: Ints,
    members: Ints,
    columns: int,
    size: float,
    near: Ints,
    apart: Floats,
) -> None:
    """Fill `near` from a grid of cells, ring by ring until no nearer point can follow."""
    rows = (len(start) - 1) // columns
    for i in range(len(near)):
        row, column = cell_of[i] // columns, cell_of[i] % columns
        for ring in range(max(rows, columns)):
            if ring > 0 and apart[i, near.shape[1] - 1] <= ((ring - 1) * size) ** 2:
                break
            for r in range(max(0, row - ring), min(rows, row + ring + 1)):
                edge = abs(r - row) == ring
                step = 1 if edge else max(1, 2 * ring)
                for c in range(column - ring, column + ring + 1, step):
                    if c < 0 or c >= columns:
                        continue
                    for k in range(start[r * columns + c], start[r * columns + c + 1]):
                        j = members[k]
                        if j == i:
                            continue
                        dx = points[i, 0] - points[j, 0]
                        dy = points[i, 1] - points[j, 1]
                        dz = points[i, 2] - points[j, 2]
                        insert_sorted(near, apart, i, j, dx * dx + dy * dy + dz * dz)


def near_points(points: Floats, count: int) -> Ints:
    """Return the `count` nearest other points of each of (n, 3) points, nearest first.

    Ties go to the lower number, so that the answer is the same on every machine. Cells hold about
    two points each; `count` must be below n.
    """
    n = len(points)
    low = points[:, :2].min(axis=0)
    extent = points[:, :2].max(axis=0) - low
    size = float(max(np.sqrt(max(extent.prod(), 1e-12) * 2 / n), extent.max() / n, 1e-9))
    columns = int(extent[0] // size) + 1
    rows = int(extent[1] // size) + 1
    at = ((points[:, :2] - low) // size).astype(np.int32)
    cell_of = at[:, 1] * np.int32(columns) + at[:, 0]
    members = np.argsort(cell_of, kind='stable').astype(np.int32)
    start = np.searchsorted(cell_of[members], np.arange(rows * columns + 1)).astype(np.int32)
    near = np.full((n, count), n, np.int32)
    apart = np.full((n, count), np.inf)
    nearest_in_cells(points, cell_of, start, members, columns, size, near, apart)
    return near


def near_rows(costs: Floats, count: int) -> Ints:
    """Return the `count` cheapest other customers of each row of a square table of costs."""
    table = costs.copy()
    np.fill_diagonal(table, np.inf)
    if count >= len(table) - 1:
        order = np.argsort(table, axis=1, kind='stable')[:, :count]
        return np.ascontiguousarray(order.astype(np.int32))
    # Those cheaper than the last one, and the first of those that cost as much as it.
    last = np.partition(table, count - 1, axis=1)[:, count - 1 : count]
    chosen = table < last
    alike = table == last
    chosen |= alike & (np.cumsum(alike, axis=1) <= count - chosen.sum(axis=1, keepdims=True))
    near = np.nonzero(chosen)[1].reshape(-1, count)
    order = np.argsort(np.take_along_axis(table, near, axis=1), axis=1, kind='stable')
    return np.ascontiguousarray(np.take_along_axis(near, order, axis=1).astype(np.int32))


@kernel
def cheapest_all_round(
    points: Floats, costs: Floats, near: Ints, near_costs: Floats, side: Ints, side_costs: Floats
) -> None:
    """Fill the rows of `near`, and four rows of `side` for the quadrants of each point.

    With no `costs`, those nearest in space are the cheapest.
    """
    for i in range(len(points)):
        for j in range(len(points)):
            if j == i:
                continue
            dx = points[j, 0] - points[i, 0]
            dy = points[j, 1] - points[i, 1]
            dz = points[j, 2] - points[i, 2]
            cost = costs[i, j] if len(costs) > 0 else dx * dx + dy * dy + dz * dz
            quadrant = (2 if dx >= 0.0 else 0) + (1 if dy >= 0.0 else 0)
            insert_sorted(near, near_costs, i, j, cost)
            insert_sorted(side, side_costs, 4 * i + quadrant, j, cost)


def near_all_round(points: Floats, nearest: int, each: int, costs: Floats | None = None) -> Ints:
    """Return the cheapest other customers of each, and more of them in each quadrant.

    In clusters, all nearest customers belong to the same cluster: only quadrant neighbours
    (Johnson and McGeoch) lead out of it. Where a quadrant has too few, the cheapest of the
    rest take their places. Ties go to the lower number.

    Parameters
    ----------
    points
        (n, 3) customers, metres; quadrants are those of the first two columns.
    nearest
        Number of nearest customers in any direction.
    each
        Number of further customers from each of the four quadrants; n > nearest + 4 * each.
    costs
        (n, n) table of legs; None where the nearest are the cheapest.
    """
    n = len(points)
    near = np.full((n, nearest + 4 * each), n, np.int32)
    # As many of the cheapest in a quadrant may be among the nearest.
    side = np.full((4 * n, nearest + each), n, np.int32)
    near_costs, side_costs = np.full(near.shape, np.inf), np.full(side.shape, np.inf)
    table = np.zeros((0, 0)) if costs is None else costs
    cheapest_all_round(points, table, near, near_costs, side, side_costs)
    sides = side.reshape(n, 4, -1)
    fresh = (sides[..., None] != near[:, None, None, :nearest]).all(axis=3)
    kept = fresh & (np.cumsum(fresh, axis=2) <= each) & (sides < n)
    rest = near[:, nearest:]
    chosen = np.where(kept, sides, n).reshape(n, -1)
    twice = (rest[:, :, None] == chosen[:, None, :]).any(axis=2)
    candidates = np.concatenate([chosen, rest], axis=1)
    rank = np.concatenate([np.where(chosen < n, 0, 2), np.where(twice, 2, 1)], axis=1)
    values = np.concatenate([side_costs.reshape(n, -1), near_costs[:, nearest:]], axis=1)
    order = np.lexsort((candidates, values, rank), axis=1)[:, : 4 * each]
    further = np.take_along_axis(candidates, order, axis=1)
    return np.ascontiguousarray(np.concatenate([near[:, :nearest], further], axis=1))
