# SPDX-License-Identifier: Apache-2.0
"""The ground below a survey in its local plane, and the way over it.

Heights are kept on a square grid, each cell with the highest ground in it and around it. For long
legs coarser grids are used, each cell of which holds the highest of its neighbourhood: a leg that
clears the samples clears all that lies between them.
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Samples along a leg, at most.
_MOST_SAMPLES = 48
# Pairs whose samples are in memory at once.
_BLOCK = 20_000


class Relief:
    """Highest ground near each place, and the bends that keep legs above it.

    Parameters
    ----------
    corner
        (east, north) of the grid's first cell's centre, metres.
    cell_m
        Distance of its cells.
    tops
        Highest ground in each cell, up in metres, shape (rows to the north, columns to the east).
    clearance_m
        That legs keep above the ground.
    """

    def __init__(
        self, corner: FloatArray, cell_m: float, tops: FloatArray, clearance_m: float
    ) -> None:
        self._corner, self._cell = corner, cell_m
        self._levels = [_spread(tops + clearance_m, 2)]
        while 2.0 ** len(self._levels) < max(tops.shape):
            self._levels.append(_spread(self._levels[-1], 2 ** len(self._levels)))

    def bends(self, origins: FloatArray, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return two places (..., 3) at which each leg bends so that it clears the ground.

        Both are the target where the straight line does; they are one where one is enough. Up to
        the first it climbs as steeply as the ground asks for, from the second it sinks as steeply,
        and in between it is level.
        """
        origins, targets = np.broadcast_arrays(origins, targets)
        shape = origins.shape
        a, b = origins.reshape(-1, 3), targets.reshape(-1, 3)
        first, second = b.copy(), b.copy()
        depth = self._depths(np.hypot(*(b - a)[:, :2].T))
        for level in np.unique(depth):
            chosen = np.flatnonzero(depth == level)
            for start in range(0, len(chosen), _BLOCK):
                block = chosen[start : start + _BLOCK]
                first[block], second[block] = self._bends(a[block], b[block], int(level))
        return first.reshape(shape), second.reshape(shape)

    def _depths(self, distance: FloatArray) -> NDArray[np.intp]:
        """Return the grid whose samples are enough for each leg."""
        steps = np.maximum(distance / (2.0 * self._cell * _MOST_SAMPLES), 1.0)
        depths: NDArray[np.intp] = np.ceil(np.log2(steps)).astype(np.intp)
        return np.clip(depths, 0, len(self._levels) - 1)

    def _bends(self, a: FloatArray, b: FloatArray, level: int) -> tuple[FloatArray, FloatArray]:
        longest = float(np.hypot(*(b - a)[:, :2].T).max())
        count = 2 + int(longest / (2.0 * self._cell * 2.0**level))
        share = (np.arange(count) + 0.5) / count
        tops = self._tops(a[:, None, :2] + share[None, :, None] * (b - a)[:, None, :2], level)
        rise = ((tops - a[:, 2:]) / share).max(axis=1)
        sink = ((tops - b[:, 2:]) / (1.0 - share)).max(axis=1)
        drop = b[:, 2] - a[:, 2]
        is_blocked = rise > drop + 1e-9
        cap = np.maximum(np.maximum(a[:, 2], b[:, 2]), tops.max(axis=1))
        with np.errstate(divide='ignore', invalid='ignore'):
            apex = (drop + sink) / (rise + sink)
            is_tent = a[:, 2] + rise * apex <= cap
            begin = np.where(is_tent, apex, (cap - a[:, 2]) / rise)
            end = np.where(is_tent, apex, 1.0 - (cap - b[:, 2]) / sink)
        up = np.where(is_tent, a[:, 2] + rise * apex, cap)
        return tuple(  # type: ignore[return-value]
            np.where(is_blocked[:, None], _between(a, b, part, up), b) for part in (begin, end)
        )

    def _tops(self, places: FloatArray, level: int) -> FloatArray:
        """Return the least height to fly at above places (..., 2)."""
        grid = self._levels[level]
        cells = np.rint((places - self._corner) / self._cell)
        column = np.clip(np.nan_to_num(cells[..., 0]), 0, grid.shape[1] - 1).astype(np.intp)
        row = np.clip(np.nan_to_num(cells[..., 1]), 0, grid.shape[0] - 1).astype(np.intp)
        tops: FloatArray = grid[row, column]
        return tops


def _between(a: FloatArray, b: FloatArray, share: FloatArray, up: FloatArray) -> FloatArray:
    """Return places over the line from a to b, at heights of their own."""
    part = np.clip(np.nan_to_num(share), 0.0, 1.0)[:, None]
    return np.column_stack([a[:, :2] + part * (b - a)[:, :2], up])


def _spread(grid: FloatArray, cells: int) -> FloatArray:
    """Return the highest within so many cells of each, in both directions."""
    for axis in (0, 1):
        reach = 0
        while reach < cells:
            step = min(max(reach, 1), cells - reach)
            grid = _highest_beside(grid, step, axis)
            reach += step
    return grid


def _highest_beside(grid: FloatArray, step: int, axis: int) -> FloatArray:
    """Return the highest of each cell and those `step` before and after it."""
    length = grid.shape[axis]
    spots = np.arange(length)
    before = np.take(grid, np.maximum(spots - step, 0), axis=axis)
    after = np.take(grid, np.minimum(spots + step, length - 1), axis=axis)
    highest: FloatArray = np.maximum(grid, np.maximum(before, after))
    return highest
