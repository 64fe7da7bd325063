# SPDX-License-Identifier: Apache-2.0
"""Compiled loop of the exact order of points (Held & Karp 1962)."""

import math

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_planner.solver.model.compiled import kernel


@kernel
def best_orders(costs: FloatArray, best: FloatArray, before: IndexArray) -> None:
    """Fill the cheapest way through each set of points, by the last one.

    Parameters
    ----------
    costs : (points + 1, points + 1)
        From row to column; 0 is the start, where the way begins.
    best, before : (2 ** points, points)
        Cost, infinite everywhere, and point before, -1 everywhere; filled. Bit k of a set is
        point k + 1.
    """
    sets, points = best.shape
    for k in range(points):
        best[1 << k, k] = costs[0, k + 1]
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
                    before[more, k] = last
