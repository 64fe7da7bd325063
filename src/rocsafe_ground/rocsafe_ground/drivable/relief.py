# SPDX-License-Identifier: Apache-2.0
"""Slopes, steps and roughness of the ground, from an elevation model."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import correlate

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.drivable.vehicle import GroundVehicle

# Side of the square whose plane roughness is about: the length of a tracked robot, three cells at
# least.
PLANE_M, LEAST_CELLS = 1.5, 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Relief:
    """The shape of the ground in each cell, all (rows, columns).

    Attributes
    ----------
    slope_rad
        NaN where no height is known.
    is_step
        Whether the edge to a neighbour is higher than the vehicle climbs.
    roughness_m
        Standard deviation of the heights about the plane through them.
    """

    slope_rad: FloatArray
    is_step: BoolArray
    roughness_m: FloatArray


def relief_of(terrain: Terrain | None, grid: RouteGrid, vehicle: GroundVehicle) -> Relief:
    """Return the relief of a grid; without an elevation model it is level."""
    if terrain is None:
        flat = np.zeros(grid.shape)
        return Relief(slope_rad=flat, is_step=np.zeros(grid.shape, np.bool_), roughness_m=flat)
    east, north = grid.places()
    places = grid.positions_of(np.column_stack([east.ravel(), north.ravel()]))
    heights = terrain.altitudes_m(places[:, 0], places[:, 1]).reshape(grid.shape)
    north_slope, east_slope = np.gradient(heights, grid.cell_m)
    climb = math.tan(math.radians(vehicle.largest_slope_deg)) * grid.cell_m
    return Relief(
        slope_rad=np.arctan(np.hypot(north_slope, east_slope)),
        is_step=_is_step(heights, max(vehicle.largest_step_m, climb)),
        roughness_m=_roughness(heights, grid.cell_m),
    )


def _is_step(heights: FloatArray, limit_m: float) -> BoolArray:
    """Return which cells differ from a neighbour by more than a limit."""
    found = np.zeros(heights.shape, np.bool_)
    for axis in (0, 1):
        edge = np.abs(np.diff(heights, axis=axis)) > limit_m
        first, second = [(0, 0), (0, 0)], [(0, 0), (0, 0)]
        first[axis], second[axis] = (0, 1), (1, 0)
        found |= np.pad(edge, first) | np.pad(edge, second)
    return found


def _roughness(heights: FloatArray, cell_m: float) -> FloatArray:
    """Return the standard deviation about the plane of least squares around each cell."""
    reach = max(LEAST_CELLS, round(PLANE_M / cell_m)) // 2
    along = np.arange(-reach, reach + 1, dtype=np.float64)
    ones = np.ones((len(along), len(along))) / len(along) ** 2
    across = np.broadcast_to(along, ones.shape) * ones
    spread = float((along**2).mean())
    # About their mean, so that squares of altitudes lose no digits.
    level = heights - np.nanmean(heights)
    mean, squares = correlate(level, ones), correlate(level**2, ones)
    tilted = (correlate(level, across) ** 2 + correlate(level, across.T) ** 2) / spread
    return np.sqrt(np.maximum(squares - mean**2 - tilted, 0.0))
