# SPDX-License-Identifier: Apache-2.0
"""The shape of the ground: three height grids with square cells, one around the other.

Heights are those of the drawn triangles: each cell is cut from its south-west to its north-east
corner. On its border a finer grid has the heights of the coarser grid, so that no gap shows.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.terrain.height_grid import GridFrame, HeightGrid, height_at
from rocsafe_scene.mesh.mesh import Floats

# Cell widths, metres: powers of two in centimetres, as the lattices of the noise have.
INNER_CELL_M, OUTER_CELL_M, FAR_CELL_M = 1.28, 10.24, 81.92
# Half extents, metres: whole numbers of the next coarser cell.
INNER_HALF_M = (143.36, 122.88)
OUTER_HALF_M = (491.52, 491.52)
FAR_HALF_M = (4096.0, 4096.0)

HeightFunction = Callable[[GridFrame], Floats]


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
        return height_at(self.grids, places)

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
