# SPDX-License-Identifier: Apache-2.0
"""A scene's ground as a GeoTIFF of heights, for planners."""

from pathlib import Path

import numpy as np

from rocsafe_geo.position import GeoPosition
from rocsafe_sim.errors import SceneError
from rocsafe_sim.scene.terrain import OUTER_HALF_M, GridFrame, Terrain

_CELL_M = 2.56


def write_heights(path: Path, terrain: Terrain, origin: GeoPosition) -> None:
    """Write the heights of the detailed ground, metres above the ellipsoid.

    The raster is azimuthal equidistant about `origin`, which over half a kilometre differs from
    east and north of the tangent plane by less than a millimetre, and in height by 2 cm.

    Raises
    ------
    SceneError: one line, if the file cannot be written.
    """
    # Loaded when asked for: it takes a moment.
    import rasterio
    from rasterio.errors import RasterioError
    from rasterio.transform import from_origin

    columns, rows = (round(2.0 * half / _CELL_M) for half in OUTER_HALF_M)
    west, south = (0.5 * _CELL_M - half for half in OUTER_HALF_M)
    frame = GridFrame(west_m=west, south_m=south, cell_m=_CELL_M, columns=columns, rows=rows)
    heights = terrain.height_at(frame.places()).reshape(rows, columns)[::-1] + origin.altitude_m
    crs = f'+proj=aeqd +lat_0={origin.latitude_deg!r} +lon_0={origin.longitude_deg!r} +datum=WGS84'
    profile = {'driver': 'GTiff', 'count': 1, 'dtype': 'float32', 'compress': 'deflate'}
    where = from_origin(-OUTER_HALF_M[0], OUTER_HALF_M[1], _CELL_M, _CELL_M)
    try:
        with rasterio.open(
            path, 'w', width=columns, height=rows, crs=crs, transform=where, **profile
        ) as file:
            file.write(heights.astype(np.float32), 1)
    except (RasterioError, OSError) as error:
        raise SceneError(f'--out = {path}: cannot be written: {error}') from error
