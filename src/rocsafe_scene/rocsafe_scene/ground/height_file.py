# SPDX-License-Identifier: Apache-2.0
"""Writing of the ground heights of a scene as a GeoTIFF, for planners."""

import contextlib
from pathlib import Path

import numpy as np

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.durable import (
    discard_part,
    finish_part,
    part_of,
    sync_directory,
    sync_file,
)
from rocsafe_geo.terrain.height_grid import GridFrame
from rocsafe_scene.errors import SceneError
from rocsafe_scene.ground.terrain import Terrain

_CELL_M = 2.56
# Half the width, metres: vehicles may start at some distance.
HALF_M = 1536.0
_EARTH_RADIUS_M = 6_371_000.0


def write_heights(
    path: Path, terrain: Terrain, origin: GeoPosition, half_m: float = HALF_M
) -> None:
    """Write the heights of the ground `half_m` about `origin`, metres above the ellipsoid.

    The file is replaced atomically.

    The raster is azimuthal equidistant about `origin`, which over 2 km differs from east
    and north of the tangent plane by less than a centimetre; the Earth falls away below that.

    Raises
    ------
    SceneError
        One line, if the file cannot be written.
    """
    # Imported when needed: the import is slow.
    import rasterio
    from rasterio.errors import RasterioError
    from rasterio.transform import from_origin

    side = round(2.0 * half_m / _CELL_M)
    south_west = 0.5 * _CELL_M - half_m
    frame = GridFrame(
        west_m=south_west, south_m=south_west, cell_m=_CELL_M, columns=side, rows=side
    )
    places = frame.places()
    fall = np.sum(places**2, axis=1) / (2.0 * _EARTH_RADIUS_M)
    heights = (terrain.height_at(places) + fall).reshape(side, side)[::-1] + origin.altitude_m
    crs = f'+proj=aeqd +lat_0={origin.latitude_deg!r} +lon_0={origin.longitude_deg!r} +datum=WGS84'
    profile = {'driver': 'GTiff', 'count': 1, 'dtype': 'float32', 'compress': 'deflate'}
    where = from_origin(-half_m, half_m, _CELL_M, _CELL_M)
    try:
        with rasterio.open(
            part_of(path), 'w', width=side, height=side, crs=crs, transform=where, **profile
        ) as file:
            file.write(heights.astype(np.float32), 1)
        sync_file(part_of(path))
        finish_part(path)
        sync_directory(path.parent)
    except (RasterioError, OSError) as error:
        with contextlib.suppress(OSError):
            discard_part(path)
        raise SceneError(f'--out = {path}: cannot be written: {error}') from error
