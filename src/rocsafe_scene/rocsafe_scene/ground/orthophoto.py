# SPDX-License-Identifier: Apache-2.0
"""Flat ground that shows a GeoTIFF orthophoto in any coordinate system."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from pyproj import CRS, Transformer
from pyproj.exceptions import ProjError

from rocsafe_geo.arrays import FloatArray, ImageArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_scene.errors import GroundError
from rocsafe_scene.ground.ground_patch import GroundBounds, Patch, require_patch_size

_BLUE_GREEN_RED = (3, 2, 1)


class OrthophotoGround:
    """Reads windows of a GeoTIFF, through its overviews where the camera is high.

    Parameters
    ----------
    path : (red, green, blue)
        Path of the file: 8 bits, one band (grey) or at least three (red, green, blue).
    frame
        Local frame of the mission.

    Raises
    ------
    GroundError
        If the file cannot be used; the text says why.
    """

    def __init__(self, path: Path, frame: LocalFrame) -> None:
        self._path = path
        self._frame = frame
        self._file = _opened(path)
        try:
            crs = CRS.from_user_input(self._file.crs.to_wkt())
            self._to_crs = Transformer.from_crs('EPSG:4326', crs, always_xy=True)
        except ProjError as error:
            raise GroundError(f'{path}: its coordinate system is not usable: {error}') from error
        self._bands = _BLUE_GREEN_RED if self._file.count >= 3 else (1, 1, 1)
        column, row = self._file_pixels(np.zeros((2, 2)))[0]
        if not (0.0 <= column < self._file.width and 0.0 <= row < self._file.height):
            origin = frame.origin
            raise GroundError(
                f'ground {path}: does not show the mission origin, '
                f'{origin.latitude_deg:.6f}, {origin.longitude_deg:.6f}'
            )

    def patch(self, bounds: GroundBounds, resolution_m: float) -> Patch:
        """Return an image of all of `bounds`, black where the file has no data.

        Raises
        ------
        GroundError
            If the file cannot be read.
        """
        corners = np.array(
            [
                (bounds.west_m, bounds.south_m),
                (bounds.east_m, bounds.south_m),
                (bounds.east_m, bounds.north_m),
                (bounds.west_m, bounds.north_m),
            ]
        )
        full = self._file_pixels(corners)
        left, top = np.floor(full.min(axis=0)).astype(int) - 1
        right, bottom = np.ceil(full.max(axis=0)).astype(int) + 1
        pixel_m = (bounds.east_m - bounds.west_m) / math.dist(full[0], full[1])
        shrink = max(1, int(resolution_m / pixel_m))
        columns, rows = -(-(right - left) // shrink), -(-(bottom - top) // shrink)
        require_patch_size(columns, rows)
        image = self._read(
            (left, top, left + columns * shrink, top + rows * shrink), (rows, columns)
        )
        return Patch(image, _homography(corners, (full - (left, top)) / shrink - 0.5))

    def _file_pixels(self, ground: FloatArray) -> FloatArray:
        """Return (column, row) in the file, from its outer corner, of ground points (n, 2)."""
        enu = np.column_stack([ground, np.zeros(len(ground))])
        latitudes, longitudes, _ = self._frame.to_geodetic(enu).T
        x, y = self._to_crs.transform(longitudes, latitudes)
        a, b, c, d, e, f = tuple(~self._file.transform)[:6]
        return np.column_stack([a * x + b * y + c, d * x + e * y + f])

    def _read(self, edges: tuple[int, int, int, int], shape: tuple[int, int]) -> ImageArray:
        from rasterio.enums import Resampling
        from rasterio.errors import RasterioError
        from rasterio.windows import Window

        left, top, right, bottom = (int(edge) for edge in edges)
        window = Window(left, top, right - left, bottom - top)
        try:
            bands = self._file.read(
                self._bands,
                window=window,
                boundless=True,
                fill_value=0,
                out_shape=(3, *shape),
                resampling=Resampling.average,
            )
        except (RasterioError, OSError) as error:
            raise GroundError(f'{self._path}: {error}') from error
        return np.ascontiguousarray(np.moveaxis(bands, 0, -1))


def _opened(path: Path) -> Any:
    """Return the open file; rasterio takes a quarter of a second to import, so only now."""
    import rasterio
    from rasterio.errors import RasterioError

    try:
        file = rasterio.open(path)
    except (RasterioError, OSError) as error:
        raise GroundError(f'ground {path}: {error}') from error
    if file.crs is None:
        raise GroundError(f'ground {path}: has no coordinate system: must be georeferenced')
    if file.dtypes[0] != 'uint8':
        raise GroundError(f'ground {path}: has {file.dtypes[0]} pixels: must have uint8')
    return file


def _homography(ground: FloatArray, pixels: FloatArray) -> FloatArray:
    """Return the homography through four pairs of points, which is exact enough for one image.

    A transverse Mercator map deviates from it by less than 1 mm over 100 m.
    """
    import cv2

    centre = ground.mean(axis=0)
    inner: FloatArray = cv2.getPerspectiveTransform(
        (ground - centre).astype(np.float32), pixels.astype(np.float32)
    )
    shift = np.array([[1.0, 0.0, -centre[0]], [0.0, 1.0, -centre[1]], [0.0, 0.0, 1.0]])
    return inner @ shift
