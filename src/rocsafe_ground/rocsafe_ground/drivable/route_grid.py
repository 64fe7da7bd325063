# SPDX-License-Identifier: Apache-2.0
"""The grid that routes are searched on: square cells, axes east and north."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.limits import require_between, require_count
from rocsafe_geo.position import GeoPosition

MOST_CELLS = 4_000_000
"""2000 by 2000: the edges of a larger grid take more than 500 MB."""


@dataclass(frozen=True, kw_only=True)
class RouteGrid:
    """Cells about an origin; cell ``row * columns + column``, row 0 in the south.

    Attributes
    ----------
    origin
        Of the local frame; its altitude does not count.
    west_m, south_m
        East and north of the outer corner of the first cell.
    cell_m
        Side of a cell.
    rows, columns
        Number of cells.
    """

    origin: GeoPosition
    west_m: float
    south_m: float
    cell_m: float
    rows: int
    columns: int

    def __post_init__(self) -> None:
        require_between('cell_m', self.cell_m, 0.05, 100.0, 'm')
        require_count('rows', self.rows, 2, MOST_CELLS)
        require_count('columns', self.columns, 2, MOST_CELLS)
        if self.rows * self.columns > MOST_CELLS:
            raise ValueError(
                f'the grid has {self.rows} x {self.columns} cells of {self.cell_m:g} m: must have '
                f'at most {MOST_CELLS}; larger cells make fewer'
            )

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.rows, self.columns

    @property
    def projection(self) -> str:
        """Transverse Mercator about the origin: east and north of the frame, as PROJ text."""
        return (
            f'+proj=tmerc +lat_0={self.origin.latitude_deg!r} '
            f'+lon_0={self.origin.longitude_deg!r} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m'
        )

    @cached_property
    def frame(self) -> LocalFrame:
        """The local frame, on the ellipsoid."""
        return LocalFrame(GeoPosition(self.origin.latitude_deg, self.origin.longitude_deg, 0.0))

    def places(self) -> tuple[FloatArray, FloatArray]:
        """Return east and north of the middle of each cell, both (rows, columns)."""
        east = self.west_m + (np.arange(self.columns) + 0.5) * self.cell_m
        north = self.south_m + (np.arange(self.rows) + 0.5) * self.cell_m
        grid = np.meshgrid(east, north)
        return grid[0], grid[1]

    def place_of(self, cells: ArrayLike) -> FloatArray:
        """Return east and north of the middle of cells, (n, 2)."""
        rows, columns = np.divmod(np.atleast_1d(np.asarray(cells)), self.columns)
        east = self.west_m + (columns + 0.5) * self.cell_m
        return np.stack([east, self.south_m + (rows + 0.5) * self.cell_m], axis=-1)

    def cell_of(self, east_m: float, north_m: float) -> int | None:
        """Return the cell that a place is in, None outside of the grid."""
        column = math.floor((east_m - self.west_m) / self.cell_m)
        row = math.floor((north_m - self.south_m) / self.cell_m)
        if not (0 <= row < self.rows and 0 <= column < self.columns):
            return None
        return row * self.columns + column

    def cells_within(
        self, east_m: float, north_m: float, reach_m: float
    ) -> tuple[IndexArray, FloatArray]:
        """Return the cells whose middle is within reach of a place, and its distances."""
        ranges = [
            np.arange(
                math.floor(min(max((at - reach_m - edge) / self.cell_m, 0.0), count)),
                math.ceil(min(max((at + reach_m - edge) / self.cell_m, 0.0), count)),
            )
            for at, edge, count in (
                (east_m, self.west_m, self.columns),
                (north_m, self.south_m, self.rows),
            )
        ]
        cells = (ranges[1][:, None] * self.columns + ranges[0]).ravel()
        distances = np.hypot(*(self.place_of(cells) - (east_m, north_m)).T)
        is_within = distances <= reach_m
        return cells[is_within], distances[is_within]

    def enu_of(self, position: GeoPosition) -> tuple[float, float]:
        """Return east and north of a position."""
        place = GeoPosition(position.latitude_deg, position.longitude_deg, 0.0)
        east, north, _ = self.frame.enu_of(place).tolist()
        return east, north

    def position_at(self, east_m: float, north_m: float) -> GeoPosition:
        """Return the position of a place; its altitude is unknown."""
        return self.frame.position_of([east_m, north_m, math.nan])

    def positions_of(self, places: FloatArray) -> FloatArray:
        """Return latitude and longitude of places (n, 2) east and north, degrees, (n, 2)."""
        flat = np.column_stack([places, np.zeros(len(places))])
        return self.frame.to_geodetic(flat)[:, :2]
