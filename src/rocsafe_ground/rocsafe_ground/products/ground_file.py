# SPDX-License-Identifier: Apache-2.0
"""The ground of a route as a GeoTIFF: free cells, speeds, dose rates."""

from pathlib import Path

import numpy as np
import rasterio
from rasterio.errors import RasterioError
from rasterio.transform import from_origin

from rocsafe_ground.drivable.drivable_ground import Reason
from rocsafe_ground.drive.ground_map import GroundMap
from rocsafe_ground.errors import GroundError

NAMES = ', '.join(f'{int(reason)} {reason.name.lower()}' for reason in Reason)


def write_ground(path: Path, ground: GroundMap) -> None:
    """Write the cells of a map.

    Raises
    ------
    GroundError
        If the file cannot be written.
    """
    grid = ground.grid
    with np.errstate(divide='ignore'):
        speed = np.where(ground.is_free, 1.0 / ground.ground.slowness_spm, 0.0)
    ages = ground.ground.ages_s
    bands = (
        (f'reason: {NAMES}', ground.reasons.astype(np.float64)),
        ('speed, m/s, 0 where not free', speed),
        ('mean: dose rate 1 m above ground, uSv/h', ground.field.mean_usvh),
        ('upper_95: upper 95 % of the dose rate, uSv/h', ground.field.upper_usvh),
        (
            'time before the newest photograph, s',
            np.full(grid.shape, np.nan) if ages is None else ages,
        ),
    )
    top = grid.south_m + grid.rows * grid.cell_m
    try:
        with rasterio.open(
            path, 'w', driver='GTiff', width=grid.columns, height=grid.rows, count=len(bands),
            dtype='float32', crs=grid.projection, compress='deflate', nodata=np.nan,
            transform=from_origin(grid.west_m, top, grid.cell_m, grid.cell_m),
        ) as raster:  # fmt: skip
            for number, (meaning, values) in enumerate(bands, 1):
                raster.write(np.flipud(values).astype(np.float32), number)
                raster.set_band_description(number, meaning)
    except (RasterioError, OSError) as error:
        raise GroundError(f'{path}: cannot be written: {error}') from error
