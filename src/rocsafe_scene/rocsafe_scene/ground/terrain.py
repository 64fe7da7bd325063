# SPDX-License-Identifier: Apache-2.0
"""The shape of the ground: three height grids with square cells, one around the other.

Heights are those of the drawn triangles: each cell is cut from its south-west to its north-east
corner. On its border a finer grid has the heights of the coarser grid, so that no gap shows.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rocsafe_scene.mesh.mesh import Floats

# Cell widths, metres: powers of two in centimetres, as the lattices of the noise have.
INNER_CELL_M, OUTER_CELL_M, FAR_CELL_M = 1.28, 10.24, 81.92
# Half extents, metres: whole numbers of the next coarser cell.
INNER_HALF_M = (143.36, 122.88)
OUTER_HALF_M = (491.52, 491.52)
FAR_HALF_M = (4096.0, 4096.0)

HeightFunction = Callable[['GridFrame'], Floats]


@dataclass(frozen=True, slots=True, kw_only=True)
class GridFrame:
    """Where the points of a grid lie: `columns` east and `rows` north from a corner."""

    west_m: float
    south_m: float
    cell_m: float
    columns: int
    rows: int

    def places(self) -> Floats:
        """Return (east, north) of all points, (rows * columns, 2), row by row."""
        east = self.west_m + self.cell_m * np.arange(self.columns)
        north = self.south_m + self.cell_m * np.arange(self.rows)
        grid = np.meshgrid(east, north)
        return np.column_stack([grid[0].ravel(), grid[1].ravel()])


@dataclass(frozen=True, slots=True, eq=False)
class HeightGrid:
    """Heights (rows, columns) over a frame; row 0 in the south."""

    frame: GridFrame
    heights: Floats

    def covers(self, places: Floats) -> Floats:
        """Return whether each of `places` (n, 2) lies on the grid."""
        f = self.frame
        column = (places[:, 0] - f.west_m) / f.cell_m
        row = (places[:, 1] - f.south_m) / f.cell_m
        inside = (column >= 0.0) & (column <= f.columns - 1) & (row >= 0.0) & (row <= f.rows - 1)
        return np.asarray(inside)

    def height_at(self, places: Floats) -> Floats:
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

    def normals(self) -> Floats:
        """Return the smooth unit normal of each point, (rows, columns, 3)."""
        slope_n, slope_e = np.gradient(self.heights, self.frame.cell_m)
        normal = np.stack([-slope_e, -slope_n, np.ones_like(slope_e)], axis=-1)
        return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))


@dataclass(frozen=True, slots=True, eq=False)
class Terrain:
    """The ground up to the horizon; heights are metres above that of the mission origin."""

    inner: HeightGrid
    outer: HeightGrid
    far: HeightGrid

    @property
    def grids(self) -> tuple[HeightGrid, HeightGrid, HeightGrid]:
        """The grids, from the finest to the coarsest."""
        return self.inner, self.outer, self.far

    def height_at(self, places: Floats) -> Floats:
        """Return the ground's height at `places` (n, 2), by the finest grid there."""
        found = self.far.height_at(places)
        for grid in (self.outer, self.inner):
            is_on = grid.covers(places)
            if is_on.any():
                found[is_on] = grid.height_at(places[is_on])
        return found

    def covers(self, places: Floats) -> Floats:
        """Return whether each of `places` (n, 2) lies on the detailed ground."""
        return self.outer.covers(places)


def frame_of(half_m: tuple[float, float], cell_m: float) -> GridFrame:
    """Return the frame of a grid about the origin."""
    columns, rows = (round(2.0 * half / cell_m) + 1 for half in half_m)
    return GridFrame(
        west_m=-half_m[0], south_m=-half_m[1], cell_m=cell_m, columns=columns, rows=rows
    )


def make_terrain(heights: HeightFunction) -> Terrain:
    """Return the terrain of a function that gives the heights of a frame's points."""
    far = _grid(heights, frame_of(FAR_HALF_M, FAR_CELL_M))
    outer = _fitted(_grid(heights, frame_of(OUTER_HALF_M, OUTER_CELL_M)), far)
    inner = _fitted(_grid(heights, frame_of(INNER_HALF_M, INNER_CELL_M)), outer)
    return Terrain(inner, outer, far)


def _grid(heights: HeightFunction, frame: GridFrame) -> HeightGrid:
    return HeightGrid(frame, heights(frame).reshape(frame.rows, frame.columns))


def _fitted(fine: HeightGrid, coarse: HeightGrid) -> HeightGrid:
    """Return `fine` with the heights of `coarse` along its border, blended in over 8 cells."""
    places = fine.frame.places()
    around = coarse.height_at(places).reshape(fine.heights.shape)
    rows, columns = fine.heights.shape
    row, column = np.arange(rows)[:, None], np.arange(columns)[None]
    rim = np.minimum(np.minimum(row, rows - 1 - row), np.minimum(column, columns - 1 - column))
    share = np.clip(rim / 8.0, 0.0, 1.0)
    return HeightGrid(fine.frame, around + share * (fine.heights - around))


def flat_terrain() -> Terrain:
    """Return level ground at height 0."""
    return make_terrain(lambda frame: np.zeros(frame.rows * frame.columns))
