# SPDX-License-Identifier: Apache-2.0
"""Ways between all pairs of points, for several prices of dose."""

import itertools
import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.route.constrained import GridPath
from rocsafe_ground.route.edges import Searcher

DOSE_ONLY = math.inf
# Threads that search: one more takes 100 bytes a cell.
THREADS = 2


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
    _found: dict[float, tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    _paths: dict[tuple[int, int], list[GridPath]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        edges = self.searcher.edges
        self._searchers = (self.searcher, *(Searcher(edges) for _ in range(THREADS - 1)))

    def tables(self, price: float) -> tuple[FloatArray, FloatArray]:
        """Return time and dose of the cheapest way between all points, (points, points) each.

        `price` is in seconds a microsievert; `DOSE_ONLY`: the ways with the least dose.
        """
        if price not in self._found:
            self._found[price] = self._search(price)
        return self._found[price]

    def options(self, a: int, b: int) -> list[GridPath]:
        """Return the ways from a to b that were found, no two alike."""
        if a < b:
            return self._paths[a, b]
        return [
            GridPath(cells=way.cells[::-1], time_s=way.time_s, dose_usv=way.dose_usv)
            for way in self._paths[b, a]
        ]

    def _search(self, price: float) -> tuple[FloatArray, FloatArray]:
        weights = (0.0, 1.0) if math.isinf(price) else (1.0, price)
        count = len(self.cells)
        times, doses = np.zeros((count, count)), np.zeros((count, count))
        with ThreadPoolExecutor(len(self._searchers)) as threads:
            # Each thread has a searcher of its own; the loops release the interpreter's lock.
            rows = threads.map(
                lambda share: [
                    (a, self._row(a, weights, share)) for a in _every(count - 1, share)
                ],
                range(len(self._searchers)),
            )
            found = dict(itertools.chain.from_iterable(rows))
        for a in range(count - 1):
            for b, way in found[a].items():
                time, dose = math.inf, math.inf
                if way is not None:
                    time, dose = way.time_s, way.dose_usv
                    self._keep(a, b, way)
                times[a, b] = times[b, a] = time
                doses[a, b] = doses[b, a] = dose
        return times, doses

    def _row(self, a: int, weights: tuple[float, float], share: int) -> dict[int, GridPath | None]:
        """Return the ways from one point to all later ones."""
        searcher, cells = self._searchers[share], self.cells
        tree = searcher.tree(cells[a], weights, set(cells[a + 1 :]))
        found: dict[int, GridPath | None] = {}
        for b in range(a + 1, len(cells)):
            found[b] = None
            if math.isfinite(tree.costs[cells[b]]):
                path = tree.path_to(cells[b])
                time, dose = searcher.edges.path_costs(path)
                found[b] = GridPath(cells=path, time_s=time, dose_usv=dose)
        return found

    def _keep(self, a: int, b: int, way: GridPath) -> None:
        kept = self._paths.setdefault((a, b), [])
        if all((way.time_s, way.dose_usv) != (one.time_s, one.dose_usv) for one in kept):
            kept.append(way)


def _every(count: int, share: int) -> range:
    """Return the numbers below `count` that fall to one of `THREADS` shares."""
    return range(share, count, THREADS)
