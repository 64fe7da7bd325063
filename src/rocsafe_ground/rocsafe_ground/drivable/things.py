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

# Squares that a cell is divided into along each side.
PARTS = 3
# Side of the square of which a share is taken.
THING_M = 0.5


def thing_parts(looks: Bands, grid: RouteGrid, most_blocked: float) -> BoolArray:
    """Return which parts of the cells are covered by things, (rows, columns) times `PARTS`.

    `looks` has two bands: 1 where a pixel looks like something else than ground, 1 where it was
    seen; 0 elsewhere.
    """
    part_m = grid.cell_m / PARTS
    # Pixels finer than parts are averaged; the nearest of coarser ones counts.
    how = Resampling.average if looks.pixel_m < part_m else Resampling.nearest
    blocked, seen = np.nan_to_num(looks.on(grid, how, PARTS))
    side = max(1, round(THING_M / part_m))
    share, whole = (uniform_filter(one, side, mode='constant') for one in (blocked, seen))
    is_dense = share > most_blocked * np.maximum(whole, 1e-6)
    around = maximum_filter(is_dense, side, origin=-(1 - side % 2))
    return np.asarray(around & (blocked > 0.5 * seen) & (seen > 0.0))


def in_cells(parts: BoolArray) -> BoolArray:
    """Return which cells have such a part, (rows, columns)."""
    rows, columns = (size // PARTS for size in parts.shape)
    return np.asarray(parts.reshape(rows, PARTS, columns, PARTS).any(axis=(1, 3)))


def distances_m(parts: BoolArray, cell_m: float) -> FloatArray:
    """Return the distance from the middle of each cell to the nearest such part, (rows, columns).

    Infinite where there is none.
    """
    if not parts.any():
        rows, columns = (size // PARTS for size in parts.shape)
        return np.full((rows, columns), math.inf)
    part_m = cell_m / PARTS
    middle = PARTS // 2
    distance = distance_transform_edt(~parts)[middle::PARTS, middle::PARTS]
    # From middle to middle; the thing begins half a part before.
    return np.asarray(np.maximum(distance - 0.5, 0.0) * part_m)
