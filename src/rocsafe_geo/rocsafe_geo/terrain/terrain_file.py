# SPDX-License-Identifier: Apache-2.0
"""Reading a digital elevation model from a GeoTIFF."""

import hashlib
import logging
import os
import warnings
from pathlib import Path

import numpy as np

from rocsafe_geo.terrain.terrain import Terrain

MOST_PIXELS = 25_000_000
"""5000 by 5000: a larger raster takes more than 200 MB."""


def read_terrain(path: str | Path) -> Terrain:
    """Return the terrain of the first band of a GeoTIFF, or of another raster that GDAL reads.

    Raises
    ------
    ValueError
        If the file is missing, is not a raster of heights, or is too large; one line.
    """
    # Imported on use: the import takes long, and few plans need it.
    import rasterio
    from pyproj.exceptions import ProjError
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    if not Path(path).is_file():
        raise ValueError(f'terrain {path}: no such file')
    # GDAL prints what the exception states, too.
    logging.getLogger('rasterio').setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter('ignore', NotGeoreferencedWarning)
            with rasterio.open(os.fspath(path)) as file:
                return _terrain(file, path)
    except (RasterioError, ProjError, OSError) as error:
        reason = str(error).splitlines()[0]
        raise ValueError(f'terrain {path}: cannot be read as a GeoTIFF: {reason}') from error


def _terrain(file, path: str | Path) -> Terrain:  # type: ignore[no-untyped-def]
    if file.crs is None:
        raise ValueError(f'terrain {path}: has no coordinate system: must be georeferenced')
    if file.width * file.height > MOST_PIXELS:
        raise ValueError(
            f'terrain {path}: has {file.width} x {file.height} pixels: must be at most '
            f'{MOST_PIXELS} in all'
        )
    if file.count != 1 or file.dtypes[0] == 'uint8':
        raise ValueError(
            f'terrain {path}: has {file.count} bands of {file.dtypes[0]}: must be one of heights '
            'in metres, as of a digital elevation model'
        )
    heights = file.read(1, masked=True).astype(np.float64).filled(np.nan)
    if not np.isfinite(heights).any():
        raise ValueError(f'terrain {path}: has no height in any pixel')
    inverse = ~file.transform
    crs = file.crs.to_wkt()
    digest = hashlib.sha256(heights.tobytes())
    digest.update(f'{tuple(inverse)}{heights.shape}{crs}'.encode())
    return Terrain(
        heights_m=heights,
        to_column=(inverse.a, inverse.b, inverse.c),
        to_row=(inverse.d, inverse.e, inverse.f),
        crs=crs,
        digest=digest.hexdigest(),
        name=f'terrain {Path(path).name}',
    )
