# SPDX-License-Identifier: Apache-2.0
"""Heights of the ground at the points of square grids, one grid inside the other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class GridFrame:
    """Where the points of a grid lie: `columns` to the east and `rows` to the north of a corner.

    Attributes
    ----------
    west_m, south_m
        East and north of the south-western point, metres.
    cell_m
        Distance of neighbouring points, metres.
    columns, rows
        Number of points to the east and to the north, at least 2.
    """

    west_m: float
    south_m: float
    cell_m: float
    columns: int
    rows: int

    def places(self) -> FloatArray:
        """Return (east, north) of all points, (rows * columns, 2), row by row."""
        east = self.west_m + self.cell_m * np.arange(self.columns)
        north = self.south_m + self.cell_m * np.arange(self.rows)
        grid = np.meshgrid(east, north)
        return np.column_stack([grid[0].ravel(), grid[1].ravel()])


@dataclass(frozen=True, slots=True, eq=False)
class HeightGrid:
    """Heights at the points of a frame, on triangles between them.

    Each cell is cut into two triangles from its south-western to its north-eastern corner.

    Attributes
    ----------
    frame
        Where the points lie.
    heights : (rows, columns)
        Up, metres; row 0 in the south.
    """

    frame: GridFrame
    heights: FloatArray

    def covers(self, places: FloatArray) -> FloatArray:
        """Return whether each of `places` (n, 2) lies on the grid."""
        f = self.frame
        column = (places[:, 0] - f.west_m) / f.cell_m
        row = (places[:, 1] - f.south_m) / f.cell_m
        inside = (column >= 0.0) & (column <= f.columns - 1) & (row >= 0.0) & (row <= f.rows - 1)
        return np.asarray(inside)

    def height_at(self, places: FloatArray) -> FloatArray:
        """Return the height of the triangles at `places` (n, 2), clamped to the grid."""
        f = self.frame
        x = np.clip((places[:, 0] - f.west_m) / f.cell_m, 0.0, f.columns - 1.0)
        y = np.clip((places[:, 1] - f.south_m) / f.cell_m, 0.0, f.rows - 1.0)
        column = np.minimum(x.astype(int), f.columns - 2)
        row = np.minimum(y.astype(int), f.rows - 2)
        u, v = x - column, y - row
        h = self.heights
        sw, se = h[row, column], h[row, column + 1]
        nw, ne = h[row + 1, column], h[row + 1, column + 1]
        below = sw + u * (se - sw) + v * (ne - se)
        above = sw + v * (nw - sw) + u * (ne - nw)
        return np.asarray(np.where(u >= v, below, above))

    def normals(self) -> FloatArray:
        """Return the smooth unit normal of each point, (rows, columns, 3)."""
        slope_n, slope_e = np.gradient(self.heights, self.frame.cell_m)
        normal = np.stack([-slope_e, -slope_n, np.ones_like(slope_e)], axis=-1)
        return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))


def height_at(grids: Sequence[HeightGrid], places: FloatArray) -> FloatArray:
    """Return the height of the ground at `places` (n, 2), by the finest grid that covers each.

    Parameters
    ----------
    grids
        From the finest to the coarsest; beyond the coarsest its rim goes on.
    places : (n, 2)
        East and north, metres.
    """
    *finer, coarsest = grids
    found = coarsest.height_at(places)
    for grid in reversed(finer):
        is_on = grid.covers(places)
        if is_on.any():
            found[is_on] = grid.height_at(places[is_on])
    return found
