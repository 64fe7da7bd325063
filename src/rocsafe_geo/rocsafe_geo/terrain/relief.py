# SPDX-License-Identifier: Apache-2.0
"""Highest ground below a survey in its local plane, and legs that clear it.

A square grid holds in each cell the highest ground in it and around it. Long legs use coarser
grids, each cell of which holds the highest ground of its neighbourhood, so that a leg that clears
the samples clears all ground between them.
"""

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray

# Largest number of samples along a leg.
_MOST_SAMPLES = 48
# Number of legs whose samples fit into the cache of the processor.
_BLOCK = 2000
# Pieces into which a leg is divided to check its height, coarse grids first.
_PIECES = (1, 4)


class Relief:
    """Highest ground near each place, and the bends that keep legs above it.

    Parameters
    ----------
    corner
        Centre (east, north) of the first cell, metres.
    cell_m
        Distance between cells, metres.
    tops
        Highest ground in each cell, up in metres, shape (rows to the north, columns to the east).
    clearance_m
        Height that legs keep above the ground, metres.
    """

    def __init__(
        self, corner: FloatArray, cell_m: float, tops: FloatArray, clearance_m: float
    ) -> None:
        self._corner, self._cell = corner, cell_m
        self._levels = [_spread(_spread(tops + clearance_m, 1), 1)]
        while 2.0 ** len(self._levels) < max(tops.shape):
            self._levels.append(_spread(self._levels[-1], 2 ** len(self._levels)))

    def bends(self, origins: FloatArray, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return two places (..., 3) at which each leg bends so that it clears the ground.

        To the first bend the leg climbs as steeply as the ground requires, then it is level, and
        from the second bend it descends as steeply as required. The bends are equal where one is
        enough, and both are the target where the straight line clears the ground. The bends of a
        leg depend on that leg only.
        """
        origins, targets = np.broadcast_arrays(origins, targets)
        shape = origins.shape
        a, b = _ends(origins), _ends(targets)
        first, second = b.copy(), b.copy()
        low = self._low_legs(a, b)
        distance = np.hypot(*(b[low] - a[low])[:, :2].T)
        depth = self._depths(distance)
        count = 2 + (distance / (2.0 * self._cell * 2.0**depth)).astype(np.intp)
        kind = depth * (count.max(initial=0) + 1) + count
        order = np.argsort(kind, kind='stable')
        for group in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
            if not len(group):
                break
            level, samples = int(depth[group[0]]), int(count[group[0]])
            chosen = low[group]
            for start in range(0, len(chosen), _BLOCK):
                block = chosen[start : start + _BLOCK]
                first[block], second[block] = self._bends(a[block], b[block], level, samples)
        return first.reshape(shape), second.reshape(shape)

    def _depths(self, distance: FloatArray) -> IndexArray:
        """Return the number of the grid to use for each leg."""
        steps = np.maximum(distance / (2.0 * self._cell * _MOST_SAMPLES), 1.0)
        depths: IndexArray = np.ceil(np.log2(steps)).astype(np.intp)
        return np.clip(depths, 0, len(self._levels) - 1)

    def _low_legs(self, a: FloatArray, b: FloatArray) -> IndexArray:
        """Return the numbers of the legs that the coarse grids do not prove high enough."""
        low = np.arange(len(a))
        for pieces in _PIECES:
            found = [
                low[block][~self._is_high(a[low[block]], b[low[block]], pieces)]
                for block in (slice(k, k + _BLOCK) for k in range(0, len(low), _BLOCK))
            ]
            low = np.concatenate([low[:0], *found])
        return low

    def _is_high(self, a: FloatArray, b: FloatArray, pieces: int) -> BoolArray:
        """Return which legs are above the highest ground near each of their pieces.

        A cell of grid k holds the highest ground within 2^(k + 1) cells. One cell is enough of the
        grid whose cells cover the piece and the surroundings of its samples.
        """
        distance = np.hypot(*(b - a)[:, :2].T)
        seen = 2.0 ** (self._depths(distance) + 1)
        reach = 0.5 * distance / (pieces * self._cell) + seen + 1.0
        level = np.clip(np.ceil(np.log2(reach)).astype(np.intp) - 1, 0, len(self._levels) - 1)
        middle = (np.arange(pieces) + 0.5) / pieces
        tops = np.empty((len(a), pieces))
        for each in np.flatnonzero(np.bincount(level)):
            chosen = level == each
            tops[chosen] = self._tops(a[chosen], b[chosen], middle, int(each))
        drop = (b[:, 2] - a[:, 2])[:, None]
        lowest = a[:, 2, None] + drop * middle - np.abs(drop) * 0.5 / pieces
        return np.asarray((tops <= lowest).all(axis=1))

    def _bends(
        self, a: FloatArray, b: FloatArray, level: int, samples: int
    ) -> tuple[FloatArray, FloatArray]:
        share = (np.arange(samples) + 0.5) / samples
        tops = self._tops(a, b, share, level)
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

    def _tops(self, a: FloatArray, b: FloatArray, share: FloatArray, level: int) -> FloatArray:
        """Return the least height to fly at shares of the way from each a to b."""
        grid = self._levels[level]
        cells: list[IndexArray] = []
        for axis in (0, 1):
            begin = (a[:, axis] - self._corner[axis]) / self._cell
            step = (b[:, axis] - a[:, axis]) / self._cell
            spots = begin[:, None] + share * step[:, None]
            np.rint(spots, out=spots)
            np.clip(spots, 0, grid.shape[1 - axis] - 1, out=spots)
            cells.append(spots.astype(np.intp))
        cells[1] *= grid.shape[1]
        cells[1] += cells[0]
        tops: FloatArray = grid.ravel().take(cells[1])
        return tops


def _ends(places: FloatArray) -> FloatArray:
    """Return places as rows; those that are not finite count as the origin."""
    rows = places.reshape(-1, 3)
    return np.column_stack([np.nan_to_num(rows[:, :2]), rows[:, 2]])


def _between(a: FloatArray, b: FloatArray, share: FloatArray, up: FloatArray) -> FloatArray:
    """Return places over the line from a to b, at heights of their own."""
    part = np.clip(np.nan_to_num(share), 0.0, 1.0)[:, None]
    return np.column_stack([a[:, :2] + part * (b - a)[:, :2], up])


def _spread(grid: FloatArray, cells: int) -> FloatArray:
    """Return the highest of each cell and the eight cells `cells` away from it.

    If each cell holds the highest within `cells` of it, the result is the highest within twice as
    many.
    """
    taller = grid.copy()
    np.maximum(taller[cells:], grid[:-cells], out=taller[cells:])
    np.maximum(taller[:-cells], grid[cells:], out=taller[:-cells])
    highest = taller.copy()
    np.maximum(highest[:, cells:], taller[:, :-cells], out=highest[:, cells:])
    np.maximum(highest[:, :-cells], taller[:, cells:], out=highest[:, :-cells])
    return highest
