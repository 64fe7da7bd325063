# SPDX-License-Identifier: Apache-2.0
"""The box of cells about what stands on a site."""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between
from rocsafe_geo.solids.scene_solids import SceneSolids
from rocsafe_geo.terrain.height_grid import height_at
from rocsafe_geo.wind.air_grid import AirGrid

SMALLEST_CELL_M = 2.0
# Columns of cells; larger sites have larger cells.
MOST_COLUMNS, MOST_LAYERS = 40_000, 40
# Free air above what is highest, and beyond things, in heights of the tallest thing.
ABOVE, BEYOND = 3.0, 5.0
# Height of the tallest thing where there is none, metres.
LEAST_HEIGHT_M = 8.0


def site_box(solids: SceneSolids, cell_m: float = SMALLEST_CELL_M) -> AirGrid:
    """Return the box about the things of a site, or its finest grid of heights without things.

    Parameters
    ----------
    solids
        Ground and things.
    cell_m
        Size of the cells, 0.5 to 50 m; they are larger where the site has too many of them.

    Raises
    ------
    ValueError
        If `cell_m` is out of range.
    """
    require_between('cell', cell_m, 0.5, 50.0, 'm')
    low, high = _extent(solids)
    tallest = max(LEAST_HEIGHT_M, float(high[2] - low[2]))
    west, south = (low[:2] - BEYOND * tallest).tolist()
    width, depth = (high[:2] - low[:2] + 2.0 * BEYOND * tallest).tolist()
    cell = max(cell_m, math.sqrt(width * depth / MOST_COLUMNS))
    columns, rows = (max(4, math.ceil(size / cell)) for size in (width, depth))
    middles = [corner + cell * (np.arange(count) + 0.5) for corner, count in
               ((west, columns), (south, rows))]  # fmt: skip
    places = np.stack(np.meshgrid(*middles), axis=-1).reshape(-1, 2)
    ground = height_at(solids.ground, places)
    bottom = float(ground.min())
    top = max(float(ground.max()), float(high[2])) + ABOVE * tallest
    layer = max(min(cell, SMALLEST_CELL_M), (top - bottom) / MOST_LAYERS)
    return AirGrid(
        west_m=west, south_m=south, bottom_m=bottom, cell_m=cell, layer_m=layer,
        columns=columns, rows=rows, layers=max(4, math.ceil((top - bottom) / layer)),
    )  # fmt: skip


def _extent(solids: SceneSolids) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest corner of all things, (3,) each."""
    if solids.things:
        corners = [thing.corners_enu_m.reshape(-1, 3) for thing in solids.things]
        return (
            np.min([each.min(axis=0) for each in corners], axis=0).astype(float),
            np.max([each.max(axis=0) for each in corners], axis=0).astype(float),
        )
    grid = solids.ground[0]
    frame = grid.frame
    size = frame.cell_m * np.array([frame.columns - 1, frame.rows - 1])
    corner = np.array([frame.west_m, frame.south_m])
    return np.append(corner, grid.heights.min()), np.append(corner + size, grid.heights.max())
