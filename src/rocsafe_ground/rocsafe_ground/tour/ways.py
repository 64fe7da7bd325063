# SPDX-License-Identifier: Apache-2.0
"""Ways between all pairs of points, for several prices of dose and of toxic load."""

import itertools
import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.route.edges import GridPath, Searcher, Weights

QUICKEST: Weights = (1.0, 0.0, 0.0)
CLEANEST: Weights = (0.0, 1.0, 0.0)
PUREST: Weights = (0.0, 0.0, 1.0)
# Threads that search: one more takes 100 bytes a cell.
THREADS = 2

Pair = tuple[int, int]


@dataclass(slots=True, eq=False)
class Ways:
    """The ways between points that have been searched so far; the start is point 0.

    Attributes
    ----------
    searcher
        Of the grid.
    cells
        Cell of each point.
    """

    searcher: Searcher
    cells: Sequence[int]
    _searchers: tuple[Searcher, ...] = field(init=False)
    _found: dict[Weights, dict[Pair, GridPath]] = field(default_factory=dict)
    _distinct: dict[Pair, list[GridPath]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        edges = self.searcher.edges
        self._searchers = (self.searcher, *(Searcher(edges) for _ in range(THREADS - 1)))

    def costs(self, weights: Weights) -> FloatArray:
        """Return the cost of the cheapest way between all points, (points, points).

        Infinite where there is none.
        """
        found = self._ways(weights)
        count = len(self.cells)
        costs = np.full((count, count), math.inf)
        np.fill_diagonal(costs, 0.0)
        for (a, b), way in found.items():
            costs[a, b] = costs[b, a] = (
                weights[0] * way.time_s + weights[1] * way.dose_usv + weights[2] * way.load
            )
        return costs

    def way(self, weights: Weights, a: int, b: int) -> GridPath:
        """Return the cheapest way from a to b."""
        found = self._ways(weights)
        return found[a, b] if a < b else found[b, a].reverse

    def options(self, a: int, b: int) -> list[GridPath]:
        """Return the ways from a to b that were found, no two alike."""
        if a < b:
            return self._distinct[a, b]
        return [way.reverse for way in self._distinct[b, a]]

    def _ways(self, weights: Weights) -> dict[Pair, GridPath]:
        if weights not in self._found:
            self._found[weights] = self._search(weights)
        return self._found[weights]

    def _search(self, weights: Weights) -> dict[Pair, GridPath]:
        count = len(self.cells)
        with ThreadPoolExecutor(len(self._searchers)) as threads:
            # Each thread has a searcher of its own; the loops release the interpreter's lock.
            rows = threads.map(
                lambda share: [self._row(a, weights, share) for a in _every(count - 1, share)],
                range(len(self._searchers)),
            )
            found = dict(sorted(itertools.chain.from_iterable(itertools.chain(*rows))))
        for pair, way in found.items():
            self._keep(pair, way)
        return found

    def _row(self, a: int, weights: Weights, share: int) -> list[tuple[Pair, GridPath]]:
        """Return the ways from one point to all later ones that can be reached."""
        searcher, cells = self._searchers[share], self.cells
        tree = searcher.tree(cells[a], weights, set(cells[a + 1 :]))
        return [
            ((a, b), searcher.edges.path_of(tree.path_to(cells[b])))
            for b in range(a + 1, len(cells))
            if math.isfinite(tree.costs[cells[b]])
        ]

    def _keep(self, pair: Pair, way: GridPath) -> None:
        kept = self._distinct.setdefault(pair, [])
        costs = (way.time_s, way.dose_usv, way.load)
        if all(costs != (one.time_s, one.dose_usv, one.load) for one in kept):
            kept.append(way)


def _every(count: int, share: int) -> range:
    """Return the numbers below `count` that fall to one of `THREADS` shares."""
    return range(share, count, THREADS)
