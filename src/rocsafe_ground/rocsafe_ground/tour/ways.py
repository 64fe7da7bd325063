# SPDX-License-Identifier: Apache-2.0
"""Ways between all pairs of points, for several prices of dose."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.route.constrained import GridPath
from rocsafe_ground.route.edges import Searcher

DOSE_ONLY = math.inf


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
    _found: dict[float, tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    _paths: dict[tuple[int, int], list[GridPath]] = field(default_factory=dict)

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
        for a in range(count - 1):
            tree = self.searcher.tree(self.cells[a], weights, set(self.cells[a + 1 :]))
            for b in range(a + 1, count):
                time, dose = math.inf, math.inf
                if math.isfinite(tree.costs[self.cells[b]]):
                    path = tree.path_to(self.cells[b])
                    time, dose = self.searcher.edges.path_costs(path)
                    self._keep(a, b, GridPath(cells=path, time_s=time, dose_usv=dose))
                times[a, b] = times[b, a] = time
                doses[a, b] = doses[b, a] = dose
        return times, doses

    def _keep(self, a: int, b: int, way: GridPath) -> None:
        kept = self._paths.setdefault((a, b), [])
        if all((way.time_s, way.dose_usv) != (one.time_s, one.dose_usv) for one in kept):
            kept.append(way)
