# SPDX-License-Identifier: Apache-2.0
"""The map as a GeoTIFF file."""

from pathlib import Path

import numpy as np
import rasterio
from rasterio.enums import ColorInterp, Resampling
from rasterio.errors import RasterioError
from rasterio.transform import Affine
from rasterio.windows import Window as RasterWindow

from rocsafe_mapping.canvas import Window
from rocsafe_mapping.durable import discard_part, finish_part, part_of, sync_directory, sync_file
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.mosaic import MapExtent, Mosaic

BLOCK_PX = 256
RGBA = (ColorInterp.red, ColorInterp.green, ColorInterp.blue, ColorInterp.alpha)
DEFLATE_LEVEL = 4
DIFFERENCES = 2
CREATION = {
    'driver': 'GTiff',
    'count': len(RGBA),
    'dtype': 'uint8',
    'tiled': True,
    'blockxsize': BLOCK_PX,
    'blockysize': BLOCK_PX,
    'compress': 'deflate',
    'predictor': DIFFERENCES,
    'zlevel': DEFLATE_LEVEL,
    'photometric': 'rgb',
    'alpha': 'unassociated',
    'bigtiff': 'if_safer',
    'sparse_ok': True,
}


def write_geotiff(mosaic: Mosaic, path: Path) -> None:
    """Write the map to `path`: tiled, with overviews, transparent where no photograph lies.

    `path` at any moment holds either its old content or the whole new map.

    Raises
    ------
    PlacementError: if no photograph is placed yet.
    MappingError: if the file cannot be written.
    """
    extent = mosaic.extent
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _write(mosaic, extent, part_of(path))
        _add_overviews(part_of(path), extent)
        sync_file(part_of(path))
        finish_part(path)
        sync_directory(path.parent)
    except (OSError, RasterioError) as error:
        discard_part(path)
        raise MappingError(f'cannot write map {path}: {error}') from error


def _write(mosaic: Mosaic, extent: MapExtent, path: Path) -> None:
    window = extent.window
    transform = Affine.translation(extent.west_m, extent.north_m) @ Affine.scale(
        extent.resolution_m, -extent.resolution_m
    )
    size = {'width': window.width, 'height': window.height}
    crs = rasterio.CRS.from_epsg(extent.epsg)
    with rasterio.open(path, 'w', crs=crs, transform=transform, **size, **CREATION) as file:
        file.colorinterp = RGBA
        for row in range(0, window.height, BLOCK_PX):
            height = min(BLOCK_PX, window.height - row)
            strip = mosaic.read(Window(window.row + row, window.column, height, window.width))
            file.write(np.moveaxis(strip, 2, 0), window=RasterWindow(0, row, window.width, height))


def _add_overviews(path: Path, extent: MapExtent) -> None:
    side = max(extent.window.width, extent.window.height)
    # The last overview is the whole map in one block.
    factors = [2**power for power in range(1, 16) if side / 2 ** (power - 1) > BLOCK_PX]
    with rasterio.open(path, 'r+') as file:
        file.build_overviews(factors, Resampling.average)
