# SPDX-License-Identifier: Apache-2.0
"""The grid as a graph: what it takes to drive from a cell to each of its neighbours."""

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray
from rocsafe_geo.limits import require_positive
from rocsafe_ground.route.route_kernels import (
    STEP_COLUMNS,
    STEP_ROWS,
    fill_edges,
    guided_path,
    shortest_tree,
)

SECONDS_PER_HOUR = 3600.0
# Added to the dose of an edge for each second: of paths with the same dose the fastest is found,
# and no edge is free, with which a search would not end.
DOSE_TIE_USVH = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Edges:
    """Time and dose of the step from each cell to each of its eight neighbours.

    Attributes
    ----------
    shape
        Rows and columns of the grid; cell ``row * columns + column``.
    cell_m
        Side of a cell.
    times_s, doses_usv : (cells, 8)
        Infinite where the step cannot be driven. A step and its reverse cost the same.
    """

    shape: tuple[int, int]
    cell_m: float
    times_s: FloatArray
    doses_usv: FloatArray

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @property
    def offsets(self) -> IndexArray:
        """Number of each neighbour minus that of its cell, (8,)."""
        return STEP_ROWS * self.shape[1] + STEP_COLUMNS

    def step_costs(self, path: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Return time and dose of each step of a path of n cells, (n - 1,) each."""
        which = (path[1:] - path[:-1])[:, None] == self.offsets
        step = (path[:-1], which.argmax(axis=1))
        return self.times_s[step], self.doses_usv[step]

    def path_costs(self, path: IndexArray) -> tuple[float, float]:
        """Return time and dose of a path of cells."""
        times, doses = self.step_costs(path)
        return float(times.sum()), float(doses.sum())


def edges_of(
    is_free: BoolArray, slowness_spm: FloatArray, rates_usvh: FloatArray, cell_m: float
) -> Edges:
    """Return the edges between the free cells of a grid.

    Parameters
    ----------
    is_free : (rows, columns)
        Whether a cell may be entered.
    slowness_spm : (rows, columns)
        Seconds that a metre takes, above 0 in free cells.
    rates_usvh : (rows, columns)
        Dose rate, not negative in free cells.
    cell_m
        Side of a cell.

    Raises
    ------
    ValueError
        If a free cell has no speed or no dose rate, or the arrays differ in shape.
    """
    require_positive('cell_m', cell_m, 'm')
    if not is_free.shape == slowness_spm.shape == rates_usvh.shape:
        raise ValueError('is_free, slowness_spm, rates_usvh: must have one shape')
    slow, rates = slowness_spm[is_free], rates_usvh[is_free]
    if not (np.isfinite(slow).all() and (slow > 0.0).all()):
        raise ValueError('slowness_spm: must be finite and above 0 in free cells')
    if not (np.isfinite(rates).all() and (rates >= 0.0).all()):
        raise ValueError('rates_usvh: must be finite and not negative in free cells')
    times = np.empty((is_free.size, 8))
    doses = np.empty((is_free.size, 8))
    fill_edges(
        np.ascontiguousarray(is_free),
        np.ascontiguousarray(slowness_spm, np.float64),
        np.ascontiguousarray((rates_usvh + DOSE_TIE_USVH) / SECONDS_PER_HOUR, np.float64),
        float(cell_m),
        (STEP_ROWS, STEP_COLUMNS),
        (times, doses),
    )
    rows, columns = is_free.shape
    return Edges(shape=(rows, columns), cell_m=cell_m, times_s=times, doses_usv=doses)


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """The cheapest paths from one cell to each cell.

    Attributes
    ----------
    costs, times_s, doses_usv : (cells,)
        Of the paths, infinite where unreached.
    parents : (cells,)
        The cell before, -1 at the origin.
    """

    costs: FloatArray
    parents: IndexArray
    times_s: FloatArray
    doses_usv: FloatArray

    def path_to(self, cell: int) -> IndexArray:
        """Return the cells from the origin to `cell`."""
        path = [cell]
        while (before := int(self.parents[path[-1]])) >= 0:
            path.append(before)
        return np.array(path[::-1], np.int64)


class Searcher:
    """Shortest paths on a grid; keeps the memory that the searches use.

    Not for use by two threads at once.
    """

    def __init__(self, edges: Edges) -> None:
        self.edges = edges
        self._arrays = (edges.times_s, edges.doses_usv)
        self._offsets = edges.offsets
        room = 8 * edges.cells + 8
        self._heap = (np.empty(room), np.empty(room, np.int64))
        self._nothing = np.zeros(edges.cells)

    def tree(
        self, origin: int, weights: tuple[float, float], targets: Collection[int] = ()
    ) -> Tree:
        """Return the least costs from a cell, weights of second and microsievert given.

        With `targets` the search ends when they are all reached.
        """
        return self._tree(origin, weights, targets, (self._nothing, math.inf))

    def tree_within(
        self, origin: int, weights: tuple[float, float], to_come: FloatArray, limit: float
    ) -> Tree:
        """Return the least costs from a cell, but to cells that are not worth it.

        Those are left out whose cost and what is at least still `to_come`, (cells,), are above
        `limit`.
        """
        return self._tree(origin, weights, (), (to_come, limit))

    def _tree(
        self,
        origin: int,
        weights: tuple[float, float],
        targets: Collection[int],
        guide: tuple[FloatArray, float],
    ) -> Tree:
        is_target = np.zeros(self.edges.cells, np.bool_)
        is_target[list(targets)] = True
        found = self._empty_tree()
        shortest_tree(
            self._arrays, weights, self._offsets, origin,
            (is_target, int(is_target.sum())), guide,
            (found.costs, found.parents, found.times_s, found.doses_usv), self._heap,
        )  # fmt: skip
        return found

    def path(
        self, start: int, goal: int, weights: tuple[float, float], least: tuple[Tree, Tree]
    ) -> IndexArray | None:
        """Return the cheapest path, None if there is none.

        `least` are the trees of time and of dose from the goal.
        """
        found = self._empty_tree()
        cost = guided_path(
            self._arrays, weights, self._offsets, (start, goal),
            (least[0].costs, least[1].costs), (found.costs, found.parents), self._heap,
        )  # fmt: skip
        return None if math.isinf(cost) else found.path_to(goal)

    def _empty_tree(self) -> Tree:
        cells = self.edges.cells
        costs, times, doses = (np.full(cells, math.inf) for _ in range(3))
        return Tree(costs, np.full(cells, -1, np.int64), times, doses)
