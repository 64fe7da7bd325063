# SPDX-License-Identifier: Apache-2.0
"""Least spanning trees of priced customers: what every tour must contain more than."""

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, inner, kernel
from rocsafe_planner.solver.model.tables import Floats, Ints


@kernel
def grow_tree(
    costs: Floats,
    points: Floats,
    pace: Floats,
    members: Ints,
    price: Floats,
    open_nodes: Ints,
    nearest: Ints,
    reach: Floats,
    parent: Ints,
    weight: Floats,
) -> None:
    """Span some customers with the least tree (Prim, quadratic; no memory of its own).

    An edge costs its leg plus the prices of both ends. Legs come from `costs` or, if that is
    empty, from coordinates under every row of `pace`, the cheapest counting. Writes each member's
    parent and the weight of the edge to it; the first member has parent -1.
    """
    size = len(members)
    dense = costs.shape[0] > 0
    for k in range(size):
        open_nodes[k] = members[k]
        reach[k] = np.inf
        nearest[k] = -1
    current = Long(members[0])
    parent[0], weight[0] = -1, 0.0
    open_nodes[0] = open_nodes[size - 1]
    left = size - 1
    for step in range(1, size):
        best, best_k = np.inf, 0
        toll = price[current]
        for k in range(left):
            j = Long(open_nodes[k])
            cost = costs[current, j] if dense else cheapest_leg(points, pace, current, j)
            cost += toll + price[j]
            if cost < reach[k]:
                reach[k] = cost
                nearest[k] = current
            if reach[k] < best:
                best, best_k = reach[k], k
        current = Long(open_nodes[best_k])
        members[step], parent[step], weight[step] = current, nearest[best_k], best
        left -= 1
        open_nodes[best_k] = open_nodes[left]
        reach[best_k] = reach[left]
        nearest[best_k] = nearest[left]


@inner
def cheapest_leg(points: Floats, pace: Floats, i: int, j: int) -> float:
    """Return the cheapest cost of a leg under any pace; column 4 holds the stay of each."""
    dx = points[i, 0] - points[j, 0]
    dy = points[i, 1] - points[j, 1]
    dz = points[i, 2] - points[j, 2]
    distance = np.sqrt(dx * dx + dy * dy + dz * dz)
    least = np.inf
    for c in range(len(pace)):
        cost = pace[c, 4]
        if distance >= pace[c, 2]:
            cost += distance * pace[c, 0] + pace[c, 1]
        else:
            cost += pace[c, 3] * np.sqrt(distance)
        least = min(least, cost)
    return least


@inner
def find(root: Ints, i: int) -> int:
    """Return the representative of a component, shortening the way to it."""
    while root[i] != i:
        root[i] = root[root[i]]
        i = Long(root[i])
    return i


@kernel
def join_edges(ends: Ints, order: Ints, root: Ints, chosen: Ints) -> int:
    """Choose the edges of the least tree among sorted ones (Kruskal); return how many."""
    for i in range(len(root)):
        root[i] = i
    count = 0
    for k in order:
        a, b = find(root, Long(ends[k, 0])), find(root, Long(ends[k, 1]))
        if a != b:
            root[a] = b
            chosen[count] = k
            count += 1
            if count == len(root) - 1:
                break
    return count
