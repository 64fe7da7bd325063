# SPDX-License-Identifier: Apache-2.0
"""The wind around what stands on a site, from a box of cells and the open wind about it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.limits import require_between
from rocsafe_geo.wind.air_grid import AirGrid, FaceVelocities
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.wind_field import WindField


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SitePattern:
    """How a site changes a wind: the flow in its cells for a wind of 1 m/s to the east and north.

    The flow for any other wind is the sum of the two, each times its component: it loses no air
    and enters no wall either.

    Attributes
    ----------
    grid
        Cells of the box; east, north and up of the origin of the mission.
    ground_m : (columns, rows)
        Height of the ground, metres above the origin.
    floor_m : (columns, rows)
        Height of the lowest cells above the ground that have air on all sides unless a thing
        stands there, metres above the origin.
    east, north
        Velocities at the faces of the cells where the open wind goes east or north with 1 m/s at
        `height_m`.
    layer
        Profile of the open wind with the height above the ground.
    height_m
        Height above the ground of the open wind, metres.
    """

    grid: AirGrid
    ground_m: FloatArray
    floor_m: FloatArray
    east: FaceVelocities
    north: FaceVelocities
    layer: SurfaceLayer
    height_m: float

    def __post_init__(self) -> None:
        flat = self.grid.shape[:2]
        for name in ('ground_m', 'floor_m'):
            values = getattr(self, name)
            if np.shape(values) != flat or not np.isfinite(values).all():
                raise ValueError(f'{name} must be finite and have the shape {flat}')
        for name in ('east', 'north'):
            getattr(self, name).require_fits(self.grid, name)
        require_between('height_m', self.height_m, 1.0, 200.0, 'm')

    def columns_of(self, places_m: FloatArray) -> tuple[NDArray[Any], BoolArray]:
        """Return the column and row nearest to each place, (2, n), and whether it is there."""
        at = np.floor((places_m[:, :2] - self.grid.corner_m[:2]) / self.grid.cell_m)
        most = np.array(self.grid.shape[:2]) - 1
        is_there = ((at >= 0) & (at <= most)).all(axis=1)
        return np.clip(at, 0, most).astype(int).T, np.asarray(is_there)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SiteWind:
    """The open wind as a site changes it; beyond the box of the site, the open wind.

    Attributes
    ----------
    pattern
        The site.
    open_wind
        The wind without what stands there.
    """

    pattern: SitePattern
    open_wind: WindField

    def velocities_mps(self, time_s: float, places_m: FloatArray) -> FloatArray:
        """Return the velocity of the air, see `WindField`.

        Along each axis it is linear between the two faces of a cell, so that it is 0 on walls;
        within a cell it grows with the height as the open wind does.
        """
        found = self.open_wind.velocities_mps(time_s, places_m)
        cells, shares, inside = self._cells(places_m)
        if not inside.any():
            return found
        reference = np.array([[0.0, 0.0, self.pattern.height_m]])
        towards = self.open_wind.velocities_mps(time_s, reference)[0]
        cells, shares = cells[inside], shares[inside]
        flow = towards[0] * _within(self.pattern.east, cells, shares)
        flow += towards[1] * _within(self.pattern.north, cells, shares)
        found[inside] = flow * self._growth(places_m[inside, 2])[:, None]
        return found

    def ground_up_m(self, places_m: FloatArray) -> FloatArray:
        """Return the height of the ground above the origin at places (n, 2), (n,), metres."""
        columns, is_there = self.pattern.columns_of(places_m)
        return np.where(is_there, self.pattern.ground_m[tuple(columns)], 0.0)

    def _cells(self, places_m: FloatArray) -> tuple[NDArray[Any], FloatArray, BoolArray]:
        """Return the cell of each place, where in it, and whether it is in the box.

        The lowest cells above the ground begin at height 0, although the ground has no steps.
        """
        grid = self.pattern.grid
        columns, is_there = self.pattern.columns_of(places_m)
        at = np.zeros((len(places_m), 3))
        at[is_there] = (places_m[is_there] - grid.corner_m) / grid.sizes_m
        at[:, 2] += self.pattern.floor_m[tuple(columns)] / grid.layer_m
        cells = np.floor(at).astype(int)
        inside = is_there & (cells[:, 2] >= 0) & (cells[:, 2] < grid.layers)
        return cells, at - cells, np.asarray(inside)

    def _growth(self, heights_m: FloatArray) -> FloatArray:
        """Return the open wind at heights over that at the middles of their cells."""
        size = self.pattern.grid.layer_m
        middles = (np.floor(heights_m / size) + 0.5) * size
        speed = self.pattern.layer.speed_mps
        return np.asarray(speed(heights_m) / speed(middles))


def _within(faces: FaceVelocities, cells: NDArray[Any], shares: FloatArray) -> FloatArray:
    """Return the velocities within cells (n, 3) at shares of their sizes, (n, 3)."""
    found = np.empty((len(cells), 3))
    for axis, part in enumerate(faces.parts):
        low = part[tuple(cells.T)]
        high = part[tuple((cells + np.eye(3, dtype=int)[axis]).T)]
        found[:, axis] = low + shares[:, axis] * (high - low)
    return found
