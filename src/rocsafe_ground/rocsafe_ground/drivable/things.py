# SPDX-License-Identifier: Apache-2.0
"""Things that stand on the ground, as a map shows them: finer than the cells of a route.

A thing is not cut by cells: what counts is the share of any square as large as a small thing that
looks like something else than ground. All of its pixels then are in the way.
"""

import math

import numpy as np
from rasterio.enums import Resampling
from scipy.ndimage import distance_transform_edt, maximum_filter, uniform_filter

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_ground.drivable.raster import Bands
from rocsafe_ground.drivable.route_grid import RouteGrid

# Side of the parts that a cell is divided into, about, and how many parts a map has at most.
PART_M, MOST_PARTS = 0.17, 36_000_000
# Side of the square of which a share is taken.
THING_M = 0.5


def thing_parts(looks: Bands, grid: RouteGrid, most_blocked: float) -> BoolArray:
    """Return which parts of the cells are covered by things, (rows, columns) times `parts_of`.

    `looks` has two bands: 1 where a pixel looks like something else than ground, 1 where it was
    seen; 0 elsewhere.
    """
    parts = parts_of(grid)
    part_m = grid.cell_m / parts
    # Pixels finer than parts are averaged; the nearest of coarser ones counts.
    how = Resampling.average if looks.pixel_m < part_m else Resampling.nearest
    blocked, seen = np.nan_to_num(looks.on(grid, how, parts))
    side = max(1, round(THING_M / part_m))
    share, whole = (uniform_filter(one, side, mode='constant') for one in (blocked, seen))
    is_dense = share > most_blocked * np.maximum(whole, 1e-6)
    around = maximum_filter(is_dense, side, origin=-(1 - side % 2))
    return np.asarray(around & (blocked > 0.5 * seen) & (seen > 0.0))


def parts_of(grid: RouteGrid) -> int:
    """Return the number of parts along the side of a cell, which is odd."""
    parts = 2 * round(0.5 * (grid.cell_m / PART_M - 1.0)) + 1
    while parts > 1 and grid.rows * grid.columns * parts**2 > MOST_PARTS:
        parts -= 2
    return max(1, parts)


def in_cells(is_thing: BoolArray, grid: RouteGrid) -> BoolArray:
    """Return which cells have such a part, (rows, columns)."""
    rows, columns = grid.shape
    return np.asarray(is_thing.reshape(rows, -1, columns, parts_of(grid)).any(axis=(1, 3)))


def distances_m(is_thing: BoolArray, grid: RouteGrid) -> FloatArray:
    """Return the distance from the middle of each cell to the nearest such part, (rows, columns).

    Infinite where there is none.
    """
    if not is_thing.any():
        return np.full(grid.shape, math.inf)
    parts = parts_of(grid)
    middle = parts // 2
    distance = distance_transform_edt(~is_thing)[middle::parts, middle::parts]
    # Distances are between middles of parts; an obstacle begins half a part nearer.
    return np.asarray(np.maximum(distance - 0.5, 0.0) * grid.cell_m / parts)
