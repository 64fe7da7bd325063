# SPDX-License-Identifier: Apache-2.0
"""Grounds that tests make: planes, ridges and hills as GeoTIFF files in memory and on disk."""

import math

import numpy as np
import rasterio
from rasterio.transform import from_origin

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_geo.terrain.terrain_file import read_terrain

CENTRE = GeoPosition(53.2800, -9.0633)
M_PER_DEG = 111_320.0
_WIDE = M_PER_DEG * math.cos(math.radians(CENTRE.latitude_deg))


def terrain(height, half_m=1200.0, step_m=10.0):
    """Return the terrain whose height is a function of metres east and north of the centre."""
    count = 2 * int(half_m / step_m)
    offsets = step_m * (np.arange(count) + 0.5) - half_m
    east, north = np.meshgrid(offsets, offsets[::-1])
    west = CENTRE.longitude_deg - half_m / _WIDE
    top = CENTRE.latitude_deg + half_m / M_PER_DEG
    return Terrain(
        heights_m=np.asarray(height(east, north) + 0.0 * east, float),
        to_column=(_WIDE / step_m, 0.0, -west * _WIDE / step_m),
        to_row=(0.0, -M_PER_DEG / step_m, top * M_PER_DEG / step_m),
        crs='EPSG:4326',
        digest=repr(np.round(height(np.arange(5.0) * 97.0, np.arange(5.0) * 89.0) + 0.0, 6)),
    )


def write_terrain(path, heights, crs='EPSG:4326', **profile):
    """Write heights as a GeoTIFF with pixels of about 10 m about the centre."""
    heights = np.asarray(heights)
    bands = heights if heights.ndim == 3 else heights[None]
    step = 10.0 / M_PER_DEG
    west = CENTRE.longitude_deg - 0.5 * bands.shape[2] * step
    north = CENTRE.latitude_deg + 0.5 * bands.shape[1] * step
    options = {
        'driver': 'GTiff', 'width': bands.shape[2], 'height': bands.shape[1],
        'count': len(bands), 'dtype': bands.dtype, 'crs': crs,
        'transform': from_origin(west, north, step, step), **profile,
    }  # fmt: skip
    with rasterio.open(path, 'w', **options) as file:
        file.write(bands)
    return path


__all__ = ['CENTRE', 'read_terrain', 'terrain', 'write_terrain']
