# SPDX-License-Identifier: Apache-2.0
"""Solid cells of a scene: its ground and what stands on it."""

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.solids.scene_solids import SceneSolids, Thing
from rocsafe_geo.terrain.height_grid import height_at
from rocsafe_geo.wind.air_grid import AirGrid

# Distance of the points that sample a triangle, in cells.
SAMPLE_CELLS = 0.5
MOST_SAMPLES = 400
LEAST_FILLED = 0.25


def solid_cells(grid: AirGrid, solids: SceneSolids) -> BoolArray:
    """Return which cells are solid, of the shape of `grid`.

    A cell is solid if its middle is below the ground, or between the lowest and the highest
    surface that a thing has within its column: things are taken to be closed between them, which
    holds for houses and tanks and closes the space within an arch. Things that fill less than
    `LEAST_FILLED` of these cells, such as fences and people, do not hold the air up.

    Parameters
    ----------
    grid
        Cells in the frame of `solids`.
    solids
        Ground and things.
    """
    solid = middles_below(grid, ground_heights_m(grid, solids))
    for thing in solids.things:
        cells = _thing_cells(grid, thing)
        if volume_m3(thing) >= LEAST_FILLED * cells.sum() * grid.sizes_m.prod():
            solid |= cells
    return solid


def volume_m3(thing: Thing) -> float:
    """Return the volume that the closed surface of a thing encloses, m^3."""
    first, second, third = np.moveaxis(thing.corners_enu_m.astype(float), 1, 0)
    return float(np.einsum('ti,ti->', first, np.cross(second, third)) / 6.0)


def ground_heights_m(grid: AirGrid, solids: SceneSolids) -> FloatArray:
    """Return the height of the ground at each (column, row), metres above the origin."""
    east, north, _ = grid.middles_m()
    places = np.stack(np.meshgrid(east, north, indexing='ij'), axis=-1).reshape(-1, 2)
    return np.asarray(height_at(solids.ground, places).reshape(grid.columns, grid.rows))


def middles_below(grid: AirGrid, heights_m: FloatArray) -> BoolArray:
    """Return the cells whose middle is below `heights_m` (columns, rows)."""
    return np.asarray(grid.middles_m()[2] < heights_m[:, :, None])


def _thing_cells(grid: AirGrid, thing: Thing) -> BoolArray:
    low = np.full((grid.columns, grid.rows), np.inf)
    high = np.full((grid.columns, grid.rows), -np.inf)
    points = _surface_points(thing.corners_enu_m.astype(float), SAMPLE_CELLS * grid.cell_m)
    cells = np.floor((points[:, :2] - grid.corner_m[:2]) / grid.cell_m).astype(int)
    inside = ((cells >= 0) & (cells < (grid.columns, grid.rows))).all(axis=1)
    column, row = cells[inside].T
    np.minimum.at(low, (column, row), points[inside, 2])
    np.maximum.at(high, (column, row), points[inside, 2])
    up = grid.middles_m()[2]
    return np.asarray((up > low[:, :, None]) & (up < high[:, :, None]))


def _surface_points(corners: FloatArray, step_m: float) -> FloatArray:
    """Return points on triangles (m, 3, 3), about `step_m` apart, (n, 3)."""
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    counts = np.clip(np.ceil(edges / step_m).astype(int), 1, MOST_SAMPLES)
    points = [corners.reshape(-1, 3)]
    for count in np.unique(counts).tolist():
        shares = _shares(count)
        points.append(np.einsum('sk,tkc->tsc', shares, corners[counts == count]).reshape(-1, 3))
    return np.concatenate(points)


def _shares(count: int) -> FloatArray:
    """Return barycentric coordinates of the middles of the parts of a triangle, (n, 3)."""
    first, second = np.meshgrid(np.arange(count), np.arange(count), indexing='ij')
    u, v = (first.ravel() + 1.0 / 3.0) / count, (second.ravel() + 1.0 / 3.0) / count
    inside = u + v < 1.0
    return np.column_stack([u[inside], v[inside], 1.0 - u[inside] - v[inside]])
