# SPDX-License-Identifier: Apache-2.0
"""Heights of the ground: a raster in any coordinate system, interpolated between pixels."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from pyproj import CRS, Transformer

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.projection import columns as as_columns
from rocsafe_geo.terrain.relief import Relief

# Every so many cells of a relief are transformed to the coordinate system of the raster.
_KNOT = 16
# Largest number of cells along the longer side of a relief, and their least size, metres.
_MOST_CELLS = 1000
_LEAST_CELL_M = 0.5
# Least size of a cell in pixels: between pixels the ground is linear.
_LEAST_CELL_PIXELS = 0.1


class TerrainError(ValueError):
    """The elevation model lacks ground that is needed."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Terrain:
    """A digital elevation model; two are equal if their `digest` is.

    Attributes
    ----------
    heights_m
        Heights of pixel centres, shape (rows, columns), NaN where unknown. They may count from
        any level surface: `LocalGround` shifts them to agree with known altitudes.
    to_column, to_row
        Coefficients (x, y, 1) of column and row; the centre of the first pixel is 0.5.
    crs
        Coordinate system of x and y, as WKT or a name that PROJ knows.
    digest
        Hash of the content.
    name
        Name of the file, for messages.
    """

    heights_m: FloatArray
    to_column: tuple[float, float, float]
    to_row: tuple[float, float, float]
    crs: str
    digest: str
    name: str = 'terrain'
    _to_crs: Transformer = field(init=False, repr=False)

    def __post_init__(self) -> None:
        to_crs = Transformer.from_crs('EPSG:4326', CRS.from_user_input(self.crs), always_xy=True)
        object.__setattr__(self, '_to_crs', to_crs)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Terrain) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def altitudes_m(self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike) -> FloatArray:
        """Return the heights at places, linear between pixels; NaN where they are not known.

        Within half a pixel of the edge of the raster the height is that of the nearest pixel.
        """
        return self.heights_at(self.pixels_of(latitudes_deg, longitudes_deg))

    def pixels_of(self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike) -> FloatArray:
        """Return (row, column) of places, (n, 2), 0.5 in the first pixel's middle, NaN nowhere."""
        latitudes, longitudes = as_columns(latitudes_deg, longitudes_deg)
        # At least two: pyproj makes a scalar of one, and warns.
        pair = (np.append(values, values[-1:]) for values in (longitudes, latitudes))
        x, y = (np.asarray(values)[:-1] for values in self._to_crs.transform(*pair))
        place = np.stack([x, y, np.ones_like(x)], -1)
        pixels = np.stack([place @ np.array(self.to_row), place @ np.array(self.to_column)], -1)
        return np.where(np.isfinite(pixels), pixels, np.nan)

    def heights_at(self, pixels: FloatArray) -> FloatArray:
        """Return the heights at (row, column), shape (..., 2), as `altitudes_m` does."""
        row, column = np.moveaxis(np.nan_to_num(pixels, nan=-1.0), -1, 0)
        rows, columns = self.heights_m.shape
        is_inside = (column >= 0) & (column <= columns) & (row >= 0) & (row <= rows)
        heights = _bilinear(self.heights_m, row - 0.5, column - 0.5)
        return np.where(is_inside, heights, np.nan)

    def pixels_within(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return (latitude, longitude, height) of pixels in a box of (latitude, longitude)."""
        edge = np.linspace(low, high, 9)
        rim = np.vstack(
            [np.column_stack([edge[:, 0], np.full(9, lon)]) for lon in (low[1], high[1])]
            + [np.column_stack([np.full(9, lat), edge[:, 1]]) for lat in (low[0], high[0])]
        )
        x, y = self._to_crs.transform(rim[:, 1], rim[:, 0])
        place = np.column_stack([x, y, np.ones_like(x)])
        columns = _range(place @ np.array(self.to_column), self.heights_m.shape[1])
        rows = _range(place @ np.array(self.to_row), self.heights_m.shape[0])
        column, row = np.meshgrid(columns, rows)
        back = np.linalg.inv(np.array([self.to_column, self.to_row, (0.0, 0.0, 1.0)]))
        spots = np.stack([column + 0.5, row + 0.5, np.ones_like(row, float)], -1) @ back.T
        longitude, latitude = self._to_crs.transform(
            spots[..., 0], spots[..., 1], direction='INVERSE'
        )
        found = np.stack([latitude, longitude, self.heights_m[row, column]], -1).reshape(-1, 3)
        known: FloatArray = found[np.isfinite(found).all(axis=1)]
        return known


class LocalGround:
    """A terrain in the plane of a local frame, shifted to agree with the homes.

    Parameters
    ----------
    terrain, frame
        The terrain, and the frame of the result.
    homes
        Places on the ground. The terrain is shifted by the mean difference to their altitudes,
        where known, so that the reference surface of the raster does not matter.

    Attributes
    ----------
    shift_m
        Shift of the heights, metres.
    """

    def __init__(self, terrain: Terrain, frame: LocalFrame, homes: list[GeoPosition]) -> None:
        self._terrain, self._frame = terrain, frame
        known = [home for home in homes if home.altitude_m == home.altitude_m]
        self.shift_m = 0.0
        if known:
            heights = self._known(
                [h.latitude_deg for h in known], [h.longitude_deg for h in known]
            )
            self.shift_m = float(np.mean([h.altitude_m for h in known] - heights))

    def altitudes_m(self, places: FloatArray) -> FloatArray:
        """Return the altitudes of the ground at places (n, 2) of the plane."""
        geodetic = self._frame.to_geodetic(np.column_stack([places, np.zeros(len(places))]))
        return self._known(geodetic[:, 0], geodetic[:, 1]) + self.shift_m

    def ups_m(self, places: FloatArray) -> FloatArray:
        """Return the ground's height above the frame's origin at places (n, 2)."""
        return self.altitudes_m(places) - self._frame.origin.altitude_m

    def relief(self, places: FloatArray, clearance_m: float) -> Relief:
        """Return the relief of the ground between places (n, 2)."""
        low, high = places.min(axis=0) - 1.0, places.max(axis=0) + 1.0
        extent = float((high - low).max())
        least = max(_LEAST_CELL_M, _LEAST_CELL_PIXELS * self._pixel_m(low, high))
        cell = max(least, extent / _MOST_CELLS)
        counts = np.ceil((high - low) / cell).astype(int) + 1
        spots = [np.arange(0, count + _KNOT, _KNOT) for count in counts]
        east, north = (low[i] + cell * spots[i] for i in (0, 1))
        nodes = np.stack(np.meshgrid(east, north), -1).reshape(-1, 2)
        geodetic = self._frame.to_geodetic(np.column_stack([nodes, np.zeros(len(nodes))]))
        # Between nodes pixels are linear to a millionth of a pixel.
        coarse = self._terrain.pixels_of(geodetic[:, 0], geodetic[:, 1])
        pixels = _refined(coarse.reshape(len(north), len(east), 2), counts[::-1])
        tops = self._terrain.heights_at(pixels)
        self._raise(tops, low, cell, geodetic)
        if np.isnan(tops).all():
            raise self._unknown(geodetic[0])
        # Unknown ground may be as high as the highest known.
        known: FloatArray = np.where(np.isnan(tops), np.nanmax(tops), tops)
        ups = known + self.shift_m - self._frame.origin.altitude_m
        return Relief(low, cell, ups, clearance_m)

    def _pixel_m(self, low: FloatArray, high: FloatArray) -> float:
        """Return the size of a pixel between two places of the plane, metres; 0: not known."""
        places = np.column_stack([np.stack([low, high]), np.zeros(2)])
        geodetic = self._frame.to_geodetic(places)
        spots = self._terrain.pixels_of(geodetic[:, 0], geodetic[:, 1])
        pixels = float(np.hypot(*(spots[1] - spots[0])))
        return float(np.hypot(*(high - low))) / pixels if pixels > 0.0 else 0.0

    def _raise(self, tops: FloatArray, low: FloatArray, cell: float, geodetic: FloatArray) -> None:
        """Lift each cell to the highest pixel in it: a fine raster has peaks between nodes."""
        box = geodetic[:, :2]
        pixels = self._terrain.pixels_within(box.min(axis=0), box.max(axis=0))
        if not len(pixels):
            return
        plane = self._frame.to_enu(pixels[:, 0], pixels[:, 1], np.nan)[:, :2]
        spots = np.rint((plane - low) / cell).astype(int)
        inside = ((spots >= 0) & (spots < tops.shape[::-1])).all(axis=1)
        rows, columns = spots[inside, 1], spots[inside, 0]
        np.fmax.at(tops, (rows, columns), pixels[inside, 2])

    def _known(self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike) -> FloatArray:
        heights = self._terrain.altitudes_m(latitudes_deg, longitudes_deg)
        lost = np.flatnonzero(np.isnan(heights))
        if len(lost):
            place = (np.asarray(latitudes_deg)[lost[0]], np.asarray(longitudes_deg)[lost[0]])
            raise self._unknown(place)
        return heights

    def _unknown(self, place: ArrayLike) -> TerrainError:
        latitude, longitude = np.asarray(place)[:2]
        return TerrainError(
            f'{self._terrain.name} has no height at {latitude:.6f}, {longitude:.6f}: must cover '
            'the regions and the homes'
        )


def _bilinear(grid: FloatArray, row: FloatArray, column: FloatArray) -> FloatArray:
    rows, columns = grid.shape
    row, column = np.clip(row, 0.0, rows - 1.0), np.clip(column, 0.0, columns - 1.0)
    top = np.minimum(row.astype(np.intp), max(rows - 2, 0))
    left = np.minimum(column.astype(np.intp), max(columns - 2, 0))
    bottom, right = np.minimum(top + 1, rows - 1), np.minimum(left + 1, columns - 1)
    down, over = row - top, column - left
    upper = grid[top, left] * (1.0 - over) + grid[top, right] * over
    lower = grid[bottom, left] * (1.0 - over) + grid[bottom, right] * over
    between: FloatArray = upper * (1.0 - down) + lower * down
    return between


def _range(values: FloatArray, count: int) -> IndexArray:
    """Return the pixels that values span, and one more on either side."""
    first = int(np.clip(np.floor(values.min()) - 1, 0, count))
    last = int(np.clip(np.ceil(values.max()) + 1, 0, count))
    return np.arange(first, last)


def _refined(values: FloatArray, counts: IndexArray) -> FloatArray:
    """Return (rows, columns, 2) of values at every `_KNOT`-th row and column, linear between."""
    for axis in (0, 1):
        spots = np.arange(counts[axis])
        part = np.expand_dims((spots % _KNOT) / _KNOT, (1 - axis, 2))
        before = np.take(values, spots // _KNOT, axis)
        values = before + part * (np.take(values, spots // _KNOT + 1, axis) - before)
    return values
