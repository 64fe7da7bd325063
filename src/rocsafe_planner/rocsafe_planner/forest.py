# SPDX-License-Identifier: Apache-2.0
"""The cheapest forest that looks like a fleet's routes: Held and Karp's idea for many vehicles.

Take the homes away from r closed routes that visit n points once: r paths are left, a forest of
n - r edges. Every vehicle that flies has two more edges, from its home to points. So the cheapest
forest of n - r edges, plus the r cheapest pairs of home edges, costs no more than the routes. In
routes every point has degree 2: a multiplier may be added to both ends of every edge and twice
their sum taken off again, which changes no routes but the forest. Held and Karp (1970, 1971)
raise the bound of one tour by subgradient ascent over the multipliers; here it is done for the
number r of flying vehicles that binds.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.intp]

# Steps without a better bound before the step size shrinks, by what, and when it is not worth it.
_PATIENCE = 5
_SHRINK = 0.6
_SMALLEST_PULL = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FleetCosts:
    """Symmetric costs that no vehicle can undercut.

    Attributes
    ----------
    fixed
        Of each vehicle that flies at all, shape (m,).
    home
        From the home of each vehicle to each point, shape (m, n).
    row
        From one point to all points, shape (n,), for n >= 1 points.
    """

    fixed: FloatArray
    home: FloatArray
    row: Callable[[int], FloatArray]


def makespan_bound(
    costs: FleetCosts, target: float, steps: int, keep_going: Callable[[float], bool]
) -> float:
    """Return a lower bound on the cost of the dearest route.

    Parameters
    ----------
    costs
        Of legs and flights.
    target
        A makespan that is known to be possible: the scale of the ascent's steps.
    steps
        Of the ascent; any number from 1 gives a valid bound.
    keep_going
        Told the best bound after each step; the ascent ends when it returns False.
    """
    vehicles, n = costs.home.shape
    flying = np.arange(1, min(vehicles, n) + 1)
    totals = np.full(len(flying), -np.inf)
    multipliers: FloatArray = np.zeros(n)
    previous = multipliers
    best, pull, stalled = -np.inf, 1.0, 0
    for _ in range(steps):
        forest = _Forest(costs, multipliers)
        totals = np.maximum(totals, forest.totals)
        binding = int(np.argmin(totals / flying))
        bound = float(totals[binding] / flying[binding])
        stalled = 0 if bound > best else stalled + 1
        best = max(best, bound)
        excess = forest.degrees(binding + 1) - 2.0
        if not keep_going(best) or not excess.any() or pull < _SMALLEST_PULL:
            break
        if stalled >= _PATIENCE:
            pull, stalled = _SHRINK * pull, 0
        # Polyak's step towards the target, smoothed as by Volgenant and Jonker (1982).
        missing = target * flying[binding] - forest.totals[binding]
        size = pull * max(missing, 1e-3 * target) / float(excess @ excess)
        multipliers = multipliers + size * (0.7 * excess + 0.3 * previous)
        previous = excess
    return best


class _Forest:
    """The cheapest forests under given multipliers, for every number of flying vehicles."""

    def __init__(self, costs: FleetCosts, multipliers: FloatArray) -> None:
        weights, edges = spanning_tree(costs.row, multipliers)
        order = np.argsort(weights, kind='stable')
        self._edges = edges[order]
        ways = costs.home + multipliers
        ends = ways.argmin(axis=1)
        flights = costs.fixed + 2.0 * ways[np.arange(len(ends)), ends]
        cheapest = np.argsort(flights, kind='stable')
        self._ends = ends[cheapest]
        n = len(multipliers)
        flying = np.arange(1, min(len(ends), n) + 1)
        trees = np.concatenate([[0.0], np.cumsum(weights[order])])[n - flying]
        homes = np.cumsum(flights[cheapest])[: len(flying)]
        self.totals: FloatArray = trees + homes - 2.0 * multipliers.sum()

    def degrees(self, flying: int) -> FloatArray:
        """Return the degrees of the points, shape (n,), if `flying` vehicles fly."""
        n = len(self._edges) + 1
        degrees = np.bincount(self._edges[: n - flying].ravel(), minlength=n).astype(float)
        np.add.at(degrees, self._ends[:flying], 2.0)
        return degrees


def spanning_tree(
    row: Callable[[int], FloatArray], multipliers: FloatArray
) -> tuple[FloatArray, IndexArray]:
    """Return weights (n - 1,) and ends (n - 1, 2) of the cheapest tree's edges (Prim, dense)."""
    n = len(multipliers)
    weights: FloatArray = np.empty(n - 1)
    edges = np.empty((n - 1, 2), dtype=np.intp)
    # Infinite where the tree has been: no edge leads back there.
    outside: FloatArray = multipliers.copy()
    outside[0] = np.inf
    nearest: FloatArray = row(0) + outside + multipliers[0]
    parents = np.zeros(n, dtype=np.intp)
    ways: FloatArray = np.empty(n)
    is_nearer = np.empty(n, dtype=bool)
    for k in range(n - 1):
        new = int(nearest.argmin())
        weights[k], edges[k] = nearest[new], (parents[new], new)
        outside[new] = nearest[new] = np.inf
        np.add(row(new), outside, out=ways)
        np.add(ways, multipliers[new], out=ways)
        np.less(ways, nearest, out=is_nearer)
        np.copyto(nearest, ways, where=is_nearer)
        np.copyto(parents, new, where=is_nearer)
    return weights, edges
