# SPDX-License-Identifier: Apache-2.0
"""GeoTIFFs of a survey, read onto the grid of the route."""

import logging
import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import rasterio
from rasterio.errors import NotGeoreferencedWarning, RasterioError
from rasterio.transform import from_origin
from rasterio.warp import Resampling, reproject, transform, transform_bounds

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.errors import NoMapError

Bounds = tuple[float, float, float, float]
Values = np.ndarray[tuple[int, ...], np.dtype[np.floating[Any]]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bands:
    """Bands of a raster with where they lie; NaN where the file has no value.

    Attributes
    ----------
    values : (bands, rows, columns)
        Row 0 in the north.
    crs, transform
        Coordinate system, and affine transformation from pixel to place, of rasterio.
    pixel_m
        Side of a pixel in the unit of the coordinate system.
    """

    values: Values
    crs: object
    transform: object
    pixel_m: float

    def bounds_in(self, projection: str) -> Bounds:
        """Return west, south, east, north in another coordinate system."""
        _, rows, columns = self.values.shape
        west, south, east, north = rasterio.transform.array_bounds(rows, columns, self.transform)
        found: Bounds = transform_bounds(self.crs, projection, west, south, east, north)
        return found

    def place_in(self, projection: str, row: float, column: float) -> tuple[float, float]:
        """Return the place of a pixel in another coordinate system; 0, 0 is its first middle."""
        x, y = rasterio.transform.xy(self.transform, row, column)
        xs, ys = transform(self.crs, projection, [float(x)], [float(y)])
        return float(xs[0]), float(ys[0])

    def on(
        self, grid: RouteGrid, resampling: Resampling = Resampling.average, parts: int = 1
    ) -> FloatArray:
        """Return the bands on the cells of a grid, (bands, rows, columns), row 0 in the south.

        With `parts` each side of a cell is divided into so many.
        """
        shape = (len(self.values), grid.rows * parts, grid.columns * parts)
        found = np.full(shape, np.nan, self.values.dtype)
        top, side = grid.south_m + grid.rows * grid.cell_m, grid.cell_m / parts
        for band, target in zip(self.values, found, strict=True):
            reproject(
                band, target, src_crs=self.crs, src_transform=self.transform, src_nodata=np.nan,
                dst_crs=grid.projection, dst_nodata=np.nan, resampling=resampling,
                dst_transform=from_origin(grid.west_m, top, side, side),
            )  # fmt: skip
        return found[:, ::-1].astype(np.float64)


def read_bands(path: Path) -> Bands:
    """Return all bands of a raster.

    Raises
    ------
    NoMapError
        If the file is missing, is not a raster, or says not where it lies.
    """
    if not path.is_file():
        raise NoMapError(f'{path}: no such file')
    logging.getLogger('rasterio').setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter('ignore', NotGeoreferencedWarning)
            with rasterio.open(os.fspath(path)) as file:
                if file.crs is None:
                    raise NoMapError(f'{path}: has no coordinate system: must be georeferenced')
                values = file.read(masked=True).astype(np.float64).filled(np.nan)
                return Bands(
                    values=values, crs=file.crs, transform=file.transform, pixel_m=file.res[0]
                )
    except (RasterioError, OSError) as error:
        reason = str(error).splitlines()[0]
        raise NoMapError(f'{path}: cannot be read as a GeoTIFF: {reason}') from error
