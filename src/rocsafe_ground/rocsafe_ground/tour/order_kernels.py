# SPDX-License-Identifier: Apache-2.0
"""Compiled loop of the exact order of points (Held & Karp 1962)."""

import math

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_planner.solver.model.compiled import kernel


@kernel
def best_orders(
    costs: FloatArray,
    shares: tuple[FloatArray, FloatArray],
    table: tuple[FloatArray, FloatArray, FloatArray, IndexArray],
) -> None:
    """Fill the cheapest way through each set of points, by the last one.

    Parameters
    ----------
    costs : (points + 1, points + 1)
        From row to column; 0 is the start, where the way begins.
    shares
        Two parts of the costs, such as time and dose, each of the same shape.
    table
        Cost, first share, second share and point before, each (2 ** points, points), the costs
        infinite and the points -1 everywhere; filled. Bit k of a set is point k + 1.
    """
    best, first, second, before = table
    sets, points = best.shape
    for k in range(points):
        best[1 << k, k] = costs[0, k + 1]
        first[1 << k, k] = shares[0][0, k + 1]
        second[1 << k, k] = shares[1][0, k + 1]
    for chosen in range(1, sets):
        for last in range(points):
            here = best[chosen, last]
            if here == math.inf:
                continue
            for k in range(points):
                if chosen >> k & 1:
                    continue
                cost = here + costs[last + 1, k + 1]
                more = chosen | 1 << k
                if cost < best[more, k]:
                    best[more, k] = cost
                    first[more, k] = first[chosen, last] + shares[0][last + 1, k + 1]
                    second[more, k] = second[chosen, last] + shares[1][last + 1, k + 1]
                    before[more, k] = last
