# SPDX-License-Identifier: Apache-2.0
"""The map's grid of pixels in the local frame.

Pixel (row, column) of a UTM zone spans eastings from column to column + 1 and northings from
-row - 1 to -row, in units of the resolution: one grid for the whole zone, so that maps fit
together.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from pyproj import Transformer

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.alignment.model.photo import GroundFrame
from rocsafe_mapping.errors import PlacementError

# Of a local map, which has neither scale nor north.
LOCAL_EPSG = 0
WGS84_EPSG, WEB_MERCATOR_EPSG = 4326, 3857
# Half the side of the square of Web Mercator, metres; side of its tiles.
WORLD_M = math.pi * 6_378_137.0
TILE_PX = 256
# That GDAL writes: its pixels are 3.7 cm wide at the equator, less elsewhere.
FINEST_ZOOM = 22
UTM_NORTH_EPSG, UTM_SOUTH_EPSG = 32600, 32700
UTM_ZONE_DEG, UTM_ZONES = 6.0, 60
# UTM ends at these latitudes (NGA.SIG.0012).
UTM_SOUTH_LIMIT_DEG, UTM_NORTH_LIMIT_DEG = -80.0, 84.0


@dataclass(frozen=True, slots=True)
class Window:
    """Rows and columns of a grid; rows count southwards, columns eastwards."""

    row: int
    column: int
    height: int
    width: int

    def cut(self, other: 'Window') -> 'Window':
        """Return what this window and `other` have in common; empty ones have no height."""
        row, column = max(self.row, other.row), max(self.column, other.column)
        height = min(self.row + self.height, other.row + other.height) - row
        width = min(self.column + self.width, other.column + other.width) - column
        return Window(row, column, max(height, 0), max(width, 0))

    def within(self, other: 'Window') -> tuple[slice, slice]:
        """Return the slices of an array over `other` that hold this window."""
        row, column = self.row - other.row, self.column - other.column
        return slice(row, row + self.height), slice(column, column + self.width)

    def part(self, rows: slice, columns: slice) -> 'Window':
        """Return the window of some rows and columns, counted from its own first."""
        return Window(
            self.row + rows.start, self.column + columns.start,
            rows.stop - rows.start, columns.stop - columns.start,
        )  # fmt: skip

    def grown(self, margin: int) -> 'Window':
        """Return the window with `margin` more pixels on each side."""
        return Window(
            self.row - margin, self.column - margin,
            self.height + 2 * margin, self.width + 2 * margin,
        )  # fmt: skip

    def widened(self, grain: int) -> 'Window':
        """Return the smallest window about this one whose edges are multiples of `grain`."""
        row, column = self.row // grain * grain, self.column // grain * grain
        return Window(
            row, column,
            -(-(self.row + self.height - row) // grain) * grain,
            -(-(self.column + self.width - column) // grain) * grain,
        )  # fmt: skip

    @property
    def is_empty(self) -> bool:
        """Whether it holds no pixel."""
        return self.height <= 0 or self.width <= 0

    def tiles(self, side: int) -> Iterator['Window']:
        """Return the tiles of the grid that this window meets, in rows."""
        for row in range(self.row // side, -(-(self.row + self.height) // side)):
            for column in range(self.column // side, -(-(self.column + self.width) // side)):
                yield Window(row * side, column * side, side, side)


@dataclass(frozen=True, slots=True, kw_only=True)
class MapGrid:
    """A grid of pixels over the ground of a survey.

    Attributes
    ----------
    epsg
        UTM zone, 3857 for the tiles of web maps, or 0 for a local map: the local frame itself.
    resolution_m
        Side of a pixel in the map's units.
    frame
        Of the local metres.
    """

    epsg: int
    resolution_m: float
    frame: GroundFrame

    def ground_of(self, columns: FloatArray, rows: FloatArray) -> FloatArray:
        """Return the local (east, north) of grid places, (n, 2); integers are pixel edges."""
        if self.epsg == LOCAL_EPSG:
            return np.column_stack([columns, -rows]) * self.resolution_m
        longitudes, latitudes = _from_wgs84(self.epsg).transform(
            columns * self.resolution_m, -rows * self.resolution_m, direction='INVERSE'
        )
        ground_m = self.frame.frame.origin.altitude_m
        heights = np.full(len(longitudes), ground_m)
        return self.frame.frame.to_enu(latitudes, longitudes, heights)[:, :2]

    def window_of(self, ground_m: FloatArray) -> Window:
        """Return the pixels that hold all local points (n, 2)."""
        places = self.places_of(ground_m)
        west, north = np.floor(places.min(axis=0)).astype(int).tolist()
        east, south = np.ceil(places.max(axis=0)).astype(int).tolist()
        return Window(north, west, south - north, east - west)

    def places_of(self, ground_m: FloatArray) -> FloatArray:
        """Return grid (column, row), (n, 2), of local points (n, 2); integers are pixel edges."""
        if self.epsg == LOCAL_EPSG:
            return ground_m * (1.0, -1.0) / self.resolution_m
        geodetic = self.frame.geodetic(ground_m)
        easts, norths = _from_wgs84(self.epsg).transform(geodetic[:, 1], geodetic[:, 0])
        return np.column_stack([easts, -np.asarray(norths)]) / self.resolution_m

    def position_of(self, column: float, row: float) -> GeoPosition:
        """Return the WGS84 position, of unknown altitude, of a grid place."""
        longitude, latitude = _from_wgs84(self.epsg).transform(
            column * self.resolution_m, -row * self.resolution_m, direction='INVERSE'
        )
        return GeoPosition(latitude, longitude)

    def ground_lattice(self, window: Window, step: int) -> FloatArray:
        """Return the local ground of every `step`-th pixel edge of `window`, (rows, columns, 2).

        Only the corners are projected; between them the grid is straight to far below a pixel.
        """
        rows, columns = window.height // step + 1, window.width // step + 1
        west, north = float(window.column), float(window.row)
        east, south = west + (columns - 1) * step, north + (rows - 1) * step
        corners = _corners(self, (west, east), (north, south))
        x = np.linspace(0.0, 1.0, columns)[np.newaxis, :, np.newaxis]
        y = np.linspace(0.0, 1.0, rows)[:, np.newaxis, np.newaxis]
        top = corners[0, 0] * (1.0 - x) + corners[0, 1] * x
        bottom = corners[1, 0] * (1.0 - x) + corners[1, 1] * x
        lattice: FloatArray = top * (1.0 - y) + bottom * y
        return lattice


def utm_epsg(latitude_deg: float, longitude_deg: float) -> int:
    """Return the EPSG code of the UTM zone of a position, by its longitude alone.

    Raises
    ------
    PlacementError
        If it is outside the latitudes of UTM.
    """
    if not UTM_SOUTH_LIMIT_DEG <= latitude_deg <= UTM_NORTH_LIMIT_DEG:
        raise PlacementError(
            f'latitude {latitude_deg} is outside UTM, {UTM_SOUTH_LIMIT_DEG:g} to '
            f'{UTM_NORTH_LIMIT_DEG:g}'
        )
    zone = min(int((longitude_deg + 180.0) // UTM_ZONE_DEG) + 1, UTM_ZONES)
    return zone + (UTM_SOUTH_EPSG if latitude_deg < 0.0 else UTM_NORTH_EPSG)


@lru_cache(maxsize=64)
def _corners(grid: MapGrid, columns: tuple[float, float], rows: tuple[float, float]) -> FloatArray:
    """Return the local ground (2, 2, 2) of four grid places; kept, as photographs share it."""
    (west, east), (north, south) = columns, rows
    return grid.ground_of(
        np.array([west, east, west, east]), np.array([north, north, south, south])
    ).reshape(2, 2, 2)


@lru_cache(maxsize=4)
def _from_wgs84(epsg: int) -> Transformer:
    return Transformer.from_crs(WGS84_EPSG, epsg, always_xy=True)
