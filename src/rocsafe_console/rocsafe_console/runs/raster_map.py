# SPDX-License-Identifier: Apache-2.0
"""A GeoTIFF as a base map: its tiles are made when they are asked for."""

import logging
import math
import warnings
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from PIL import Image

from rocsafe_console.errors import ConsoleError

TILE_PIXELS = 256
# Half of the equator of Web Mercator (EPSG:3857), metres.
HALF_WORLD_M = 20_037_508.342789244
DEEPEST = 24
# From one tile that shows the whole raster: more zooms out are not worth a reading of it all.
ZOOMS_OUT = 1
TILES_KEPT = 512
BANDS = {1: 'grey', 3: 'red, green and blue', 4: 'these and opacity or infrared'}


class RasterMap:
    """The picture in a GeoTIFF in any coordinate system that PROJ knows.

    Raises
    ------
    ConsoleError
        If it has no coordinate system, or is no picture of 8 bits.
    """

    content_type = 'image/png'

    def __init__(self, path: Path) -> None:
        # Imported on use: the import takes long, and few consoles need it.
        import rasterio
        from rasterio.errors import RasterioError
        from rasterio.warp import transform_bounds

        # GDAL prints what the exception states, too.
        logging.getLogger('rasterio').setLevel(logging.CRITICAL)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter('ignore')
                self._file: Any = rasterio.open(path, driver='GTiff')
                self._require_picture(path)
                west, south, east, north = transform_bounds(
                    self._file.crs, 'EPSG:4326', *self._file.bounds
                )
                left, bottom, right, top = transform_bounds(
                    self._file.crs, 'EPSG:3857', *self._file.bounds
                )
        except (RasterioError, OSError) as error:
            raise ConsoleError(f'{path}: cannot be read: {str(error).splitlines()[0]}') from error
        span_m = max(right - left, top - bottom)
        if not (math.isfinite(span_m) and span_m > 0.0):
            raise ConsoleError(f'{path}: does not lie where Web Mercator is defined')
        pixel_m = span_m / max(self._file.width, self._file.height)
        whole = math.floor(math.log2(2.0 * HALF_WORLD_M / span_m))
        finest = math.ceil(math.log2(2.0 * HALF_WORLD_M / (TILE_PIXELS * pixel_m)))
        self.zooms = (min(max(whole - ZOOMS_OUT, 0), DEEPEST), min(max(finest, 0), DEEPEST))
        self.bounds: tuple[float, float, float, float] | None = (south, west, north, east)
        self.attribution = ''
        self._lock = Lock()
        self._kept = lru_cache(maxsize=TILES_KEPT)(self._made)

    def tile(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile as PNG, None if the raster has nothing there; rows from the north."""
        if not self.zooms[0] <= zoom <= self.zooms[1] or max(column, row) >= 2**zoom:
            return None
        return self._kept(zoom, column, row)

    def _require_picture(self, path: Path) -> None:
        file = self._file
        if file.crs is None:
            raise ConsoleError(f'{path}: has no coordinate system: must be georeferenced')
        if file.count not in BANDS or set(file.dtypes) != {'uint8'}:
            known = '; '.join(BANDS.values())
            raise ConsoleError(
                f'{path}: has {file.count} bands of {file.dtypes[0]}: must be {known}, of uint8'
            )

    def _made(self, zoom: int, column: int, row: int) -> bytes | None:
        from rasterio.enums import ColorInterp, Resampling
        from rasterio.errors import RasterioError
        from rasterio.transform import Affine
        from rasterio.vrt import WarpedVRT

        side_m = 2.0 * HALF_WORLD_M / 2**zoom
        pixel_m = side_m / TILE_PIXELS
        corner = Affine(
            pixel_m, 0.0, column * side_m - HALF_WORLD_M,
            0.0, -pixel_m, HALF_WORLD_M - row * side_m,
        )  # fmt: skip
        wanted = {
            'crs': 'EPSG:3857', 'transform': corner, 'width': TILE_PIXELS, 'height': TILE_PIXELS,
            'resampling': Resampling.bilinear,
            # Opaque where the raster has pixels: a fourth band of its own tells it, else GDAL.
            'add_alpha': ColorInterp.alpha not in self._file.colorinterp,
        }  # fmt: skip
        try:
            # GDAL reads a file in one thread at a time.
            with self._lock, WarpedVRT(self._file, **wanted) as tile:
                bands = tile.read()
        except RasterioError:
            return None
        return _png(bands[:-1], bands[-1]) if bands[-1].any() else None


def _png(bands: 'np.ndarray[Any, Any]', opacity: 'np.ndarray[Any, Any]') -> bytes:
    """Return grey, or red, green and blue as the first bands, with their opacity, as PNG."""
    colours = bands[[0, 0, 0]] if len(bands) == 1 else bands[:3]
    buffer = BytesIO()
    picture = np.dstack([*colours, opacity]).astype(np.uint8)
    Image.fromarray(picture, 'RGBA').save(buffer, 'PNG', compress_level=3)
    return buffer.getvalue()
