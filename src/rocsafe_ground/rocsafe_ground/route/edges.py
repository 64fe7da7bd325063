# SPDX-License-Identifier: Apache-2.0
"""The grid as a graph: time, dose and toxic load from a cell to each of its neighbours."""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace

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
# The same for toxic loads, of the largest load that is tolerated, a second.
LOAD_TIE_PER_S = 1e-9

Weights = tuple[float, float, float]
"""Of a second, a microsievert and a toxic load in the cost of a path."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GridPath:
    """A path of cells with what it costs; `load` is a toxic load, times that of a level."""

    cells: IndexArray
    time_s: float
    dose_usv: float
    load: float = 0.0

    @property
    def reverse(self) -> 'GridPath':
        """The same path in the other direction."""
        return replace(self, cells=self.cells[::-1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Edges:
    """What the step from each cell to each of its eight neighbours costs.

    Attributes
    ----------
    shape
        Rows and columns of the grid; cell ``row * columns + column``.
    cell_m
        Side of a cell.
    times_s, doses_usv : (cells, 8)
        Infinite where the step cannot be driven. A step and its reverse cost the same.
    loads : (cells, 8)
        Toxic loads of a gas, likewise; None: there is no gas.
    """

    shape: tuple[int, int]
    cell_m: float
    times_s: FloatArray
    doses_usv: FloatArray
    loads: FloatArray | None = None

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @property
    def offsets(self) -> IndexArray:
        """Number of each neighbour minus that of its cell, (8,)."""
        return STEP_ROWS * self.shape[1] + STEP_COLUMNS

    def step_costs(self, path: IndexArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return time, dose and toxic load of each step of a path of n cells, (n - 1,) each."""
        which = (path[1:] - path[:-1])[:, None] == self.offsets
        step = (path[:-1], which.argmax(axis=1))
        times = self.times_s[step]
        loads = np.zeros(len(times)) if self.loads is None else self.loads[step]
        return times, self.doses_usv[step], loads

    def path_of(self, cells: IndexArray) -> GridPath:
        """Return a path of cells with what it costs."""
        time, dose, load = (float(steps.sum()) for steps in self.step_costs(cells))
        return GridPath(cells=cells, time_s=time, dose_usv=dose, load=load)


def edges_of(
    is_free: BoolArray,
    slowness_spm: FloatArray,
    rates_usvh: FloatArray,
    cell_m: float,
    loads_per_s: FloatArray | None = None,
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
    loads_per_s : (rows, columns)
        Toxic load that a second adds, not negative in free cells; None: there is no gas.

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
    shape = np.ascontiguousarray(is_free)
    slowness = np.ascontiguousarray(slowness_spm, np.float64)
    times, doses = _filled(
        shape, slowness, (rates_usvh + DOSE_TIE_USVH) / SECONDS_PER_HOUR, cell_m
    )
    loads = None
    if loads_per_s is not None:
        _, loads = _filled(shape, slowness, loads_per_s + LOAD_TIE_PER_S, cell_m)
    rows, columns = is_free.shape
    return Edges(shape=(rows, columns), cell_m=cell_m, times_s=times, doses_usv=doses, loads=loads)


def _filled(
    is_free: BoolArray, slowness: FloatArray, rates: FloatArray, cell_m: float
) -> tuple[FloatArray, FloatArray]:
    """Return times, and times rates, of all edges."""
    times, sums = np.empty((is_free.size, 8)), np.empty((is_free.size, 8))
    rates = np.ascontiguousarray(rates, np.float64)
    fill_edges(is_free, slowness, rates, float(cell_m), (STEP_ROWS, STEP_COLUMNS), (times, sums))
    return times, sums


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """The cheapest paths from one cell to each cell.

    Attributes
    ----------
    costs, times_s, doses_usv : (cells,)
        Of the paths, infinite where unreached; doses are not those where toxic loads count.
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

    def tree(self, origin: int, weights: Weights, targets: Collection[int] = ()) -> Tree:
        """Return the least costs from a cell.

        With `targets` the search ends when they are all reached.
        """
        return self._tree(origin, weights, targets, (self._nothing, math.inf))

    def tree_within(
        self, origin: int, weights: Weights, to_come: FloatArray, limit: float
    ) -> Tree:
        """Return the least costs from a cell, but to cells that are not worth it.

        Those are left out whose cost and what is at least still `to_come`, (cells,), are above
        `limit`.
        """
        return self._tree(origin, weights, (), (to_come, limit))

    def _tree(
        self,
        origin: int,
        weights: Weights,
        targets: Collection[int],
        guide: tuple[FloatArray, float],
    ) -> Tree:
        arrays, pair = self._weighed(weights)
        is_target = np.zeros(self.edges.cells, np.bool_)
        is_target[list(targets)] = True
        found = self._empty_tree()
        shortest_tree(
            arrays, pair, self._offsets, origin,
            (is_target, int(is_target.sum())), guide,
            (found.costs, found.parents, found.times_s, found.doses_usv), self._heap,
        )  # fmt: skip
        return found

    def _weighed(
        self, weights: Weights
    ) -> tuple[tuple[FloatArray, FloatArray], tuple[float, float]]:
        """Return two arrays of edges and two weights that make the same costs."""
        time, dose, load = weights
        loads = self.edges.loads
        if loads is None or not load:
            return self._arrays, (time, dose)
        if not dose:
            return (self.edges.times_s, loads), (time, load)
        return (self.edges.times_s, dose * self.edges.doses_usv + load * loads), (time, 1.0)

    def path(
        self, start: int, goal: int, weights: tuple[float, float], least: tuple[Tree, Tree]
    ) -> IndexArray | None:
        """Return the cheapest path by weights of time and dose, None if there is none.

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
