# SPDX-License-Identifier: Apache-2.0
"""All files of a drive."""

import json
from pathlib import Path

import numpy as np
import rasterio
from rasterio.errors import RasterioError
from rasterio.transform import from_origin

from rocsafe_ground.drivable.drivable_ground import Reason
from rocsafe_ground.drive.drive_plan import DrivePlan
from rocsafe_ground.drive.ground_map import GroundMap
from rocsafe_ground.errors import GroundError
from rocsafe_ground.products.document import drive_document, drive_geojson
from rocsafe_ground.products.exports import drive_gpx, drive_kml, drive_qgroundcontrol

ROUTE_FILE = 'route.json'


def write_drive(folder: Path, plan: DrivePlan, ground: GroundMap) -> None:
    """Write the files of a drive to `folder`, which is created if it does not exist.

    Raises
    ------
    OSError, GroundError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    documents = {
        ROUTE_FILE: drive_document(plan),
        'route.geojson': drive_geojson(plan),
        'route.plan': drive_qgroundcontrol(plan),
    }
    for name, document in documents.items():
        (folder / name).write_text(json.dumps(document, indent=1) + '\n', encoding='utf-8')
    (folder / 'route.kml').write_text(drive_kml(plan), encoding='utf-8')
    (folder / 'route.gpx').write_text(drive_gpx(plan), encoding='utf-8')
    write_ground(folder / 'ground.tif', ground)


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
