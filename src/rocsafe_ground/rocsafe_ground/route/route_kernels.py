# SPDX-License-Identifier: Apache-2.0
"""Compiled loops of the route search: edges of a grid, shortest paths, labels.

Cells of a grid of `columns` columns have numbers, row by row. Each has eight neighbours, in the
order of `STEP_ROWS` and `STEP_COLUMNS`; cell k and neighbour m share the entries ``[k, m]`` of the
arrays of edges. An edge that cannot be driven takes an infinite time.

Kernels share these parameters:

edges
    Time and dose, each (cells, 8).
weights
    Of time and dose in a cost.
offsets : (8,)
    Number of each neighbour minus that of its cell.
tree
    Costs, infinite everywhere; predecessors, -1 everywhere; of whole trees also time and dose of
    the cheapest path, infinite everywhere; filled.
heap
    Keys and cells or labels; overwritten. Of cells with 8 * cells + 8 entries.

All kernels are in this file: numba notices a change of the file that it keeps machine code of,
but not of other files.
"""

import math

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray
from rocsafe_planner.solver.model.compiled import inlined, kernel

STEP_ROWS = np.array([0, 0, 1, -1, 1, 1, -1, -1], np.int64)
STEP_COLUMNS = np.array([1, -1, 0, 0, 1, -1, 1, -1], np.int64)

FOUND, NONE_FOUND, OUT_OF_LABELS = 0, 1, 2


@inlined
def _push(keys: FloatArray, items: IndexArray, size: int, key: float, item: int) -> None:
    """Add to a binary heap of `size` entries."""
    place = size
    while place > 0:
        above = (place - 1) >> 1
        if keys[above] <= key:
            break
        keys[place] = keys[above]
        items[place] = items[above]
        place = above
    keys[place] = key
    items[place] = item


@inlined
def _pop(keys: FloatArray, items: IndexArray, size: int) -> None:
    """Take the entry of the smallest key off a heap of `size` entries: it is at 0 before."""
    last = size - 1
    key, item = keys[last], items[last]
    place = 0
    while True:
        below = 2 * place + 1
        if below >= last:
            break
        if below + 1 < last and keys[below + 1] < keys[below]:
            below += 1
        if keys[below] >= key:
            break
        keys[place] = keys[below]
        items[place] = items[below]
        place = below
    keys[place] = key
    items[place] = item


@kernel
def fill_edges(
    is_free: BoolArray,
    slowness: FloatArray,
    rates: FloatArray,
    cell_m: float,
    steps: tuple[IndexArray, IndexArray],
    edges: tuple[FloatArray, FloatArray],
) -> None:
    """Fill time and dose of all edges, `edges` of shape (rows * columns, 8).

    Time and dose are by the trapezoidal rule. A diagonal edge needs both cells beside it.
    """
    rows, columns = is_free.shape
    times, doses = edges
    for row in range(rows):
        for column in range(columns):
            for m in range(8):
                k = row * columns + column
                times[k, m] = math.inf
                doses[k, m] = math.inf
                r, c = row + steps[0][m], column + steps[1][m]
                if not (is_free[row, column] and 0 <= r < rows and 0 <= c < columns):
                    continue
                if not (is_free[r, c] and is_free[row, c] and is_free[r, column]):
                    continue
                length = cell_m * (math.sqrt(2.0) if m >= 4 else 1.0)
                time = 0.5 * length * (slowness[row, column] + slowness[r, c])
                times[k, m] = time
                doses[k, m] = 0.5 * time * (rates[row, column] + rates[r, c])


@kernel
def shortest_tree(
    edges: tuple[FloatArray, FloatArray],
    weights: tuple[float, float],
    offsets: IndexArray,
    origin: int,
    targets: tuple[BoolArray, int],
    guide: tuple[FloatArray, float],
    tree: tuple[FloatArray, IndexArray, FloatArray, FloatArray],
    heap: tuple[FloatArray, IndexArray],
) -> None:
    """Fill the least cost from `origin` to each cell, and the cell before it (Dijkstra 1959).

    The search ends when all `targets`, cells marked True and their number, are settled; number 0:
    it goes on to the end. A cell is left out whose cost and `guide`, the least that is still to
    come, (cells,), are above a limit.
    """
    times, doses = edges
    costs, parents, sum_times, sum_doses = tree
    keys, items = heap
    is_target, left = targets
    to_come, limit = guide
    costs[origin], sum_times[origin], sum_doses[origin] = 0.0, 0.0, 0.0
    _push(keys, items, 0, 0.0, origin)
    size = 1
    while size > 0:
        key, k = keys[0], items[0]
        _pop(keys, items, size)
        size -= 1
        if key > costs[k]:
            continue
        if is_target[k]:
            left -= 1
            if left == 0:
                break
        for m in range(8):
            time = times[k, m]
            cost = key + weights[0] * time + weights[1] * doses[k, m]
            n = k + offsets[m]
            if time == math.inf or cost >= costs[n] or cost + to_come[n] > limit:
                continue
            costs[n], parents[n] = cost, k
            sum_times[n], sum_doses[n] = sum_times[k] + time, sum_doses[k] + doses[k, m]
            _push(keys, items, size, cost, n)
            size += 1


@kernel
def guided_path(
    edges: tuple[FloatArray, FloatArray],
    weights: tuple[float, float],
    offsets: IndexArray,
    ends: tuple[int, int],
    least: tuple[FloatArray, FloatArray],
    tree: tuple[FloatArray, IndexArray],
    heap: tuple[FloatArray, IndexArray],
) -> float:
    """Return the least cost between two cells (A*, Hart, Nilsson & Raphael 1968).

    The cost still to come is at least the weighted sum of the least time and the least dose to
    the goal, `least`: a consistent estimate. For the other parameters see `shortest_tree`.
    """
    times, doses = edges
    costs, parents = tree
    keys, items = heap
    start, goal = ends
    costs[start] = 0.0
    _push(keys, items, 0, 0.0, start)
    size = 1
    while size > 0:
        key, k = keys[0], items[0]
        _pop(keys, items, size)
        size -= 1
        if k == goal:
            return costs[goal]
        here = costs[k]
        # An entry that was improved later has a larger key than the cell has now.
        if key > here + weights[0] * least[0][k] + weights[1] * least[1][k] + 1e-12 * key:
            continue
        for m in range(8):
            time = times[k, m]
            if time == math.inf:
                continue
            cost = here + weights[0] * time + weights[1] * doses[k, m]
            n = k + offsets[m]
            if cost < costs[n]:
                costs[n] = cost
                parents[n] = k
                key = cost + weights[0] * least[0][n] + weights[1] * least[1][n]
                _push(keys, items, size, key, n)
                size += 1
    return math.inf


@inlined
def _least_time(
    time: float, excess: float, prices: tuple[FloatArray, FloatArray], cell: int
) -> float:
    """Return the largest of the bounds on the time at the goal, by the prices of dose."""
    multipliers, lagrangian = prices
    bound = 0.0
    for p in range(len(multipliers)):
        bound = max(bound, time + lagrangian[p, cell] + multipliers[p] * excess)
    return bound


@inlined
def _is_worth(
    label: tuple[float, float],
    cell: int,
    limits: tuple[float, float],
    least: tuple[FloatArray, FloatArray],
    prices: tuple[FloatArray, FloatArray],
) -> bool:
    """Return whether a label, (time, dose), may lead to the goal within the limits."""
    time, dose = label
    budget, best = limits
    if dose + least[1][cell] > budget or time + least[0][cell] > best:
        return False
    return _least_time(time, dose - budget, prices, cell) <= best


@kernel
def label_search(
    edges: tuple[FloatArray, FloatArray],
    offsets: IndexArray,
    ends: tuple[int, int],
    limits: tuple[float, float],
    least: tuple[FloatArray, FloatArray],
    prices: tuple[FloatArray, FloatArray],
    lowest: FloatArray,
    labels: tuple[IndexArray, IndexArray, FloatArray, FloatArray],
    heap: tuple[FloatArray, IndexArray],
) -> tuple[int, int, int, float]:
    """Search the fastest path from start to goal, `ends`, within a budget of dose, exactly.

    Labels (time, dose) leave the heap by time plus the least time to the goal. A label at a cell
    is dominated if one left before it with no more dose: one number a cell, `lowest`, tells (BOA*,
    Hernandez Ulloa et al. 2020); it is infinite everywhere at first, or 0 in cells to be left out.
    Labels that cannot reach the goal within `limits`, the largest dose and the time of the best
    path known, are dropped: by the `least` time and dose to the goal, and by `prices`, multipliers
    (n,) and the least Lagrangian cost of each to the goal (n, cells).

    `labels` are overwritten with cell, label before, time and dose of each, as many as there is
    room. Returns `FOUND`, `NONE_FOUND` or `OUT_OF_LABELS`; the label at the goal; the number of
    labels; a lower bound on the time of each path that was not looked at, infinite if there is
    none.
    """
    times, doses = edges
    cells, befores, label_times, label_doses = labels
    keys, items = heap
    cells[0], befores[0], label_times[0], label_doses[0] = ends[0], -1, 0.0, 0.0
    _push(keys, items, 0, least[0][ends[0]], 0)
    size, count = 1, 1
    while size > 0:
        key, label = keys[0], items[0]
        _pop(keys, items, size)
        size -= 1
        k, dose = cells[label], label_doses[label]
        if dose >= lowest[k]:
            continue
        lowest[k] = dose
        if k == ends[1]:
            return FOUND, label, count, key
        if count > len(cells) - 8:
            return OUT_OF_LABELS, -1, count, key
        for m in range(8):
            n = k + offsets[m]
            time, total = label_times[label] + times[k, m], dose + doses[k, m]
            if times[k, m] == math.inf or total >= lowest[n]:
                continue
            if _is_worth((time, total), n, limits, least, prices):
                cells[count], befores[count] = n, label
                label_times[count], label_doses[count] = time, total
                _push(keys, items, size, time + least[0][n], count)
                size += 1
                count += 1
    return NONE_FOUND, -1, count, math.inf
