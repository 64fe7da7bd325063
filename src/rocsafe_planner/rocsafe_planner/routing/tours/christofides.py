# SPDX-License-Identifier: Apache-2.0
"""A tour after Christofides (1976), cut among the vehicles: the seed system's method.

The shortest tree, a matching of its odd points, and a walk along both that skips what it has seen.
The seed took a minimum-weight matching; here the matching is greedy, then improved by exchanging
partners of two pairs until that no longer helps. Tours differ little, but the proof that one is
at most half longer than the best does not hold.
"""

from collections.abc import Callable

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.tours.sensor_repair import with_sensors
from rocsafe_planner.routing.tours.tour_splitting import min_max_parts

_SWEEPS = 50
_LEAST_GAIN_M = 1e-6


def christofides(problem: FleetProblem) -> list[Order]:
    """Cut Christofides' tour of all points where the longest route is shortest."""
    n = len(problem.points)
    tree = spanning_tree(lambda i: problem.distances_m(i)[:n], n)
    odd = np.flatnonzero(np.bincount(tree.ravel(), minlength=n) % 2)
    pairs = _matching(np.vstack([problem.distances_m(i)[odd] for i in odd])) if n > 1 else []
    edges = [(int(a), int(b)) for a, b in tree] + [(int(odd[a]), int(odd[b])) for a, b in pairs]
    return with_sensors(problem, min_max_parts(problem, _walk(n, edges)))


def spanning_tree(row: Callable[[int], FloatArray], n: int) -> IndexArray:
    """Return the edges (n - 1, 2) of the shortest tree (Prim, 1957), computed row by row."""
    edges = np.empty((n - 1, 2), dtype=np.intp)
    is_outside = np.ones(n, dtype=bool)
    is_outside[0] = False
    nearest = np.where(is_outside, row(0), np.inf)
    parents = np.zeros(n, dtype=np.intp)
    for k in range(n - 1):
        new = int(nearest.argmin())
        edges[k] = (parents[new], new)
        is_outside[new] = False
        nearest[new] = np.inf
        lengths = row(new)
        is_nearer = is_outside & (lengths < nearest)
        nearest[is_nearer] = lengths[is_nearer]
        parents[is_nearer] = new
    return edges


def _matching(lengths: FloatArray) -> list[tuple[int, int]]:
    """Return a matching of all rows of a symmetric table, of small total length."""
    count = len(lengths)
    rows, columns = np.triu_indices(count, k=1)
    free = np.ones(count, dtype=bool)
    pairs = []
    for k in np.argsort(np.round(lengths[rows, columns], 6), kind='stable'):
        a, b = int(rows[k]), int(columns[k])
        if free[a] and free[b]:
            free[[a, b]] = False
            pairs.append((a, b))
    return _exchanged(lengths, pairs)


def _exchanged(lengths: FloatArray, pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Exchange partners between two pairs as long as that shortens the matching."""
    ends = np.array(pairs, dtype=np.intp)
    for _ in range(_SWEEPS):
        improved = False
        for k in range(len(ends)):
            a, b = ends[k]
            c, d = ends[:, 0], ends[:, 1]
            now = lengths[a, b] + lengths[c, d]
            gains = np.stack(
                [now - lengths[a, c] - lengths[b, d], now - lengths[a, d] - lengths[b, c]]
            )
            gains[:, k] = 0.0
            way, other = np.unravel_index(int(gains.argmax()), gains.shape)
            if gains[way, other] > _LEAST_GAIN_M:
                first, second = ends[other] if way == 0 else ends[other][::-1]
                ends[k], ends[other] = (a, first), (b, second)
                improved = True
        if not improved:
            break
    return [(int(a), int(b)) for a, b in ends]


def _walk(n: int, edges: list[tuple[int, int]]) -> Order:
    """Return the points in the order of a closed walk over all edges (Hierholzer, 1873)."""
    joined: list[list[int]] = [[] for _ in range(n)]
    for number, (a, b) in enumerate(edges):
        joined[a].append(number)
        joined[b].append(number)
    used = [False] * len(edges)
    stack, walk = [0], []
    while stack:
        here = stack[-1]
        while joined[here] and used[joined[here][-1]]:
            joined[here].pop()
        if not joined[here]:
            walk.append(stack.pop())
            continue
        number = joined[here].pop()
        used[number] = True
        a, b = edges[number]
        stack.append(b if here == a else a)
    return list(dict.fromkeys(walk))
