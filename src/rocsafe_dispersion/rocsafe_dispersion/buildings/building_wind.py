# SPDX-License-Identifier: Apache-2.0
"""The wind around the buildings and over the ground of a site."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rocsafe_dispersion.buildings.air_grid import AirGrid
from rocsafe_dispersion.buildings.mass_consistent import (
    CorrectionOptions,
    FaceVelocities,
    corrected,
)
from rocsafe_dispersion.buildings.voxels import ground_heights_m, middles_below, solid_cells
from rocsafe_dispersion.buildings.wakes import wake_factors
from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.limits import require_positive
from rocsafe_geo.solids.scene_solids import SceneSolids
from rocsafe_geo.wind.wind_field import ProfileWind


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BuildingWind:
    """A steady wind in a box of cells; beyond the box, the wind without buildings.

    Attributes
    ----------
    grid
        Cells of the box.
    solid : (columns, rows, layers)
        Cells without air.
    ground_m : (columns, rows)
        Height of the ground, metres above the origin.
    faces
        Velocities at the faces of the cells.
    undisturbed
        The wind without buildings.
    """

    grid: AirGrid
    solid: BoolArray
    ground_m: FloatArray
    faces: FaceVelocities
    undisturbed: ProfileWind

    def velocities_mps(self, time_s: float, places_m: FloatArray) -> FloatArray:
        """Return the velocity of the air, see `WindField`.

        Along each axis it is linear between the two faces of a cell, so that it is 0 on walls.
        """
        found = self.undisturbed.velocities_mps(time_s, places_m)
        cells, shares, inside = self._cells(places_m)
        column, row, layer = cells[inside].T
        parts = (self.faces.east, self.faces.north, self.faces.up)
        for axis, part in enumerate(parts):
            step = [int(axis == i) for i in range(3)]
            low = part[column, row, layer]
            high = part[column + step[0], row + step[1], layer + step[2]]
            found[inside, axis] = low + shares[inside, axis] * (high - low)
        return found

    def is_solid(self, places_m: FloatArray) -> BoolArray:
        """Return which places (n, 3), heights above the ground, lie within a solid cell."""
        cells, _, inside = self._cells(places_m)
        found = np.zeros(len(places_m), bool)
        found[inside] = self.solid[tuple(cells[inside].T)]
        return found

    def _cells(self, places_m: FloatArray) -> tuple[NDArray[Any], FloatArray, BoolArray]:
        """Return the cell of each place, where in it, and whether it is in the box."""
        at = (places_m - self.grid.corner_m) / self.grid.sizes_m
        flat = np.clip(np.floor(at[:, :2]), 0, (self.grid.columns - 1, self.grid.rows - 1))
        ground = self.ground_m[tuple(flat.astype(int).T)]
        at[:, 2] += ground / self.grid.layer_m
        cells = np.floor(at)
        inside = np.asarray(((cells >= 0) & (cells < self.grid.shape)).all(axis=1))
        return cells.astype(int), at - cells, inside


def building_wind(
    grid: AirGrid,
    solids: SceneSolids,
    undisturbed: ProfileWind,
    options: CorrectionOptions | None = None,
) -> BuildingWind:
    """Return the wind around what stands on a site.

    Parameters
    ----------
    grid
        Cells in the frame of `solids`; the box should reach three heights above the buildings
        and five beyond them.
    solids
        Ground and things, as `rocsafe_geo.solids.solids_file.read_solids` returns them.
    undisturbed
        Wind without buildings.
    options
        How exactly air is conserved.

    Raises
    ------
    ValueError
        If there is no wind, or the box does not reach above the ground.
    """
    ground = ground_heights_m(grid, solids)
    return wind_around(grid, solid_cells(grid, solids), ground, undisturbed, options)


def wind_around(
    grid: AirGrid,
    solid: BoolArray,
    ground_m: FloatArray,
    undisturbed: ProfileWind,
    options: CorrectionOptions | None = None,
) -> BuildingWind:
    """Return the wind around solid cells, see `building_wind`."""
    require_positive('speed of the wind', undisturbed.wind.speed_mps, 'm/s')
    if solid[:, :, -1].all():
        raise ValueError('the box of cells ends below the ground: raise its top')
    above = grid.middles_m()[2] - ground_m[:, :, None]
    # Only what rises above the ground is a building; the highest solid cell tells its height.
    tops = np.where(solid & ~middles_below(grid, ground_m), above + grid.layer_m / 2.0, 0.0)
    factors = wake_factors(grid, above, tops.max(axis=2), undisturbed.wind)
    speed = undisturbed.layer.speed_mps(np.maximum(above, 0.0))
    speed = speed / float(undisturbed.layer.speed_mps(undisturbed.reference_height_m))
    faces = corrected(_faces(grid, factors * speed, undisturbed), solid, grid, options)
    return BuildingWind(
        grid=grid, solid=solid, ground_m=ground_m, faces=faces, undisturbed=undisturbed
    )


def _faces(grid: AirGrid, shares: FloatArray, wind: ProfileWind) -> FaceVelocities:
    """Return the velocities at the faces of cells whose middles have `shares` of the wind."""
    columns, rows, layers = grid.shape
    east = _between(shares, 0) * wind.wind.towards_east_mps
    north = _between(shares, 1) * wind.wind.towards_north_mps
    return FaceVelocities(
        east=east.astype(np.float32),
        north=north.astype(np.float32),
        up=np.zeros((columns, rows, layers + 1), np.float32),
    )


def _between(values: FloatArray, axis: int) -> FloatArray:
    """Return the means of neighbours along an axis, the outer ones as they are."""
    size = values.shape[axis]
    first = np.take(values, [0, *range(size)], axis)
    second = np.take(values, [*range(size), size - 1], axis)
    return np.asarray((first + second) / 2.0)
