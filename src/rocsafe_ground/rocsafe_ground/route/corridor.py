# SPDX-License-Identifier: Apache-2.0
"""The cells that a better path may use, with bounds on what is still to come from each."""

import math
from collections.abc import Iterator

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_ground.route.edges import Tree

# A corridor that loses less than this part of its cells in a round is not narrowed further.
WORTH_A_ROUND = 0.1


class Corridor:
    """Cells of a grid that are not ruled out.

    Parameters
    ----------
    quick_s, clean_usv : (cells,)
        Least time and least dose to the goal.

    Attributes
    ----------
    is_open : (cells,)
        Whether a better path may use a cell.
    """

    def __init__(self, quick_s: FloatArray, clean_usv: FloatArray) -> None:
        self._quick, self._clean = quick_s, clean_usv
        self.is_open: BoolArray = np.isfinite(quick_s)
        self._trees: dict[float, tuple[Tree, Tree]] = {}
        self._newest = 0.0
        self._count = int(self.is_open.sum())

    @property
    def wall(self) -> FloatArray:
        """Negative infinity in open cells, infinity in all others, (cells,)."""
        return np.where(self.is_open, -math.inf, math.inf)

    def to_come(self, price: float) -> FloatArray:
        """Return the least that a path still costs from each cell, infinite where it is closed."""
        if price in self._trees:
            costs = self._trees[price][1].costs
        else:
            costs = self._quick + price * self._clean
        return np.where(self.is_open, costs, math.inf)

    def keep(self, is_open: BoolArray, price: float, there: Tree, back: Tree) -> None:
        """Close all other cells; keep the trees from the start and from the goal for a price."""
        self.is_open &= is_open
        self._trees[price] = there, back
        self._newest = price

    def pairs(self) -> Iterator[tuple[Tree, Tree]]:
        """Yield a tree from the start and one from the goal, one of them of the newest price."""
        there, back = self._trees[self._newest]
        for price, (other_there, other_back) in self._trees.items():
            yield there, other_back
            if price != self._newest:
                yield other_there, back

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the prices, (n,), and the least cost to the goal for each, (n, cells)."""
        costs = [back.costs for _, back in self._trees.values()]
        return np.array(list(self._trees)), np.stack(costs)

    def has_narrowed(self) -> bool:
        """Return whether many cells were closed since the last call."""
        before, self._count = self._count, int(self.is_open.sum())
        return self._count < (1.0 - WORTH_A_ROUND) * before
