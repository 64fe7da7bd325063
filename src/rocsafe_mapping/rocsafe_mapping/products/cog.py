# SPDX-License-Identifier: Apache-2.0
"""The map as a cloud optimised GeoTIFF: tiled, with overviews, transparent where nothing lies."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import rasterio
import rasterio.shutil
from numpy.typing import NDArray
from rasterio._err import CPLE_BaseError
from rasterio.enums import ColorInterp, Resampling
from rasterio.errors import RasterioError
from rasterio.transform import Affine
from rasterio.windows import Window as RasterWindow

from rocsafe_geo.storage.durable import (
    discard_part,
    finish_part,
    part_of,
    sync_directory,
    sync_file,
)
from rocsafe_mapping.drawing.grid import LOCAL_EPSG, MapGrid, Window
from rocsafe_mapping.errors import MappingError

COG_BLOCK_PX, RAW_BLOCK_PX = 512, 256
RGBA = (ColorInterp.red, ColorInterp.green, ColorInterp.blue, ColorInterp.alpha)
Colour = tuple[int, int, int]
RAW_SUFFIX = '.raw'
GDAL_ERRORS = (OSError, RasterioError, CPLE_BaseError)
"""What rasterio raises where a file cannot be read or written; copies raise GDAL's own."""
# Number for no value in float rasters: programs treat NaN differently.
NO_VALUE = -9999.0
# A local map says in every raster that its numbers are no metres and its top is not north.
LOCAL_WKT = (
    'LOCAL_CS["local map without scale or north",'
    'UNIT["hundredth of the flying height",1],AXIS["X",OTHER],AXIS["Y",OTHER]]'
)
# GDAL would else take a twentieth of the machine's memory for its cache of blocks.
CACHE_BYTES = 64 * 2**20
RAW = {
    'driver': 'GTiff', 'tiled': True, 'blockxsize': RAW_BLOCK_PX, 'blockysize': RAW_BLOCK_PX,
    'interleave': 'pixel', 'bigtiff': 'if_safer', 'sparse_ok': True,
}  # fmt: skip
COG = {
    'driver': 'COG', 'compress': 'DEFLATE', 'level': 1, 'predictor': 'YES',
    'blocksize': COG_BLOCK_PX, 'overviews': 'AUTO',
    'bigtiff': 'IF_SAFER',
}  # fmt: skip


def write_cog(
    path: Path,
    grid: MapGrid,
    window: Window,
    tiles: Iterable[tuple[Window, NDArray[np.uint8]]],
    *,
    palette: Mapping[int, Colour] | None = None,
) -> None:
    """Write `tiles` of `window` to `path`, which at any moment holds its old or its new content.

    Parameters
    ----------
    path
        Of the file.
    grid
        That the windows count in.
    window
        What the file shall hold.
    tiles
        Each with red, green, blue and coverage, shape (height, width, 4); or labels (height,
        width), 0 where nothing is known, with a `palette`.
    palette
        Colours of labels (red, green, blue), or none of them known; None for a picture.

    Raises
    ------
    MappingError
        If the file cannot be written.
    """
    resampling = Resampling.average if palette is None else Resampling.mode
    _made(path, lambda raw: _write_raw(raw, grid, window, tiles, palette), resampling)


def write_values(
    path: Path, grid: MapGrid, window: Window, bands: Mapping[str, NDArray[np.float32]]
) -> None:
    """Write `bands` of `window`, NaN for no value, to `path` as `write_cog` does, by their names.

    Raises
    ------
    MappingError
        If the file cannot be written.
    """
    _made(path, lambda raw: _write_bands(raw, grid, window, bands), Resampling.average)


def _made(path: Path, write: Callable[[Path], None], resampling: Resampling) -> None:
    """Have `write` make a plain file, and make of it the cloud optimised one."""
    raw = path.with_name(path.name + RAW_SUFFIX)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with rasterio.Env(GDAL_CACHEMAX=CACHE_BYTES):
            write(raw)
            _add_overviews(raw, resampling)
            rasterio.shutil.copy(raw, part_of(path), **COG)
        sync_file(part_of(path))
        finish_part(path)
        sync_directory(path.parent)
    except GDAL_ERRORS as error:
        discard_part(path)
        raise MappingError(f'cannot write map {path}: {error}') from error
    finally:
        raw.unlink(missing_ok=True)
        # Temporary files that GDAL makes beside the file, also those of a process that was killed.
        for leftover in path.parent.glob(f'{part_of(path).name}.*'):
            leftover.unlink(missing_ok=True)


def _write_raw(
    path: Path,
    grid: MapGrid,
    window: Window,
    tiles: Iterable[tuple[Window, NDArray[np.uint8]]],
    palette: Mapping[int, Colour] | None,
) -> None:
    size: dict[str, Any] = {'dtype': 'uint8'}
    size |= {'count': 4} if palette is None else {'count': 1, 'nodata': 0}
    with rasterio.open(path, 'w', **_place(grid, window), **size, **RAW) as file:
        if palette is None:
            file.colorinterp = RGBA
        elif palette:
            file.write_colormap(1, {0: (0, 0, 0, 0), **{n: (*c, 255) for n, c in palette.items()}})
        for place, rgba in tiles:
            shared = place.cut(window)
            if shared.is_empty:
                continue
            part = rgba[shared.within(place)]
            part = np.moveaxis(part, 2, 0) if palette is None else part[np.newaxis]
            rows, columns = shared.within(window)
            file.write(
                part,
                window=RasterWindow(columns.start, rows.start, shared.width, shared.height),
            )


def _write_bands(
    path: Path, grid: MapGrid, window: Window, bands: Mapping[str, NDArray[np.float32]]
) -> None:
    size = {'dtype': 'float32', 'count': len(bands), 'nodata': NO_VALUE}
    with rasterio.open(path, 'w', **_place(grid, window), **size, **RAW) as file:
        for number, (name, values) in enumerate(bands.items(), 1):
            file.write(np.nan_to_num(values, nan=NO_VALUE), number)
            file.set_band_description(number, name)


def _place(grid: MapGrid, window: Window) -> dict[str, Any]:
    """Return what rasterio wants to know of where `window` lies."""
    west_m, north_m = window.column * grid.resolution_m, -window.row * grid.resolution_m
    scale = Affine.scale(grid.resolution_m, -grid.resolution_m)
    return {
        'width': window.width, 'height': window.height, 'crs': _crs(grid.epsg),
        'transform': Affine.translation(west_m, north_m) @ scale,
    }  # fmt: skip


def _crs(epsg: int) -> rasterio.CRS:
    return rasterio.CRS.from_wkt(LOCAL_WKT) if epsg == LOCAL_EPSG else rasterio.CRS.from_epsg(epsg)


def _add_overviews(path: Path, resampling: Resampling) -> None:
    """Add the smaller pictures: here they cost half of what the COG driver takes for its own."""
    with rasterio.open(path, 'r+') as file:
        longest = max(file.width, file.height)
        factors = [2**power for power in range(1, 20) if longest > COG_BLOCK_PX * 2 ** (power - 1)]
        if factors:
            file.build_overviews(factors, resampling)
