# SPDX-License-Identifier: Apache-2.0
"""A dose map as a GeoTIFF of 32-bit floats."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rasterio
from rasterio.crs import CRS
from rasterio.errors import RasterioError
from rasterio.transform import from_origin

from rocsafe_geo.frame import LocalFrame
from rocsafe_radiation.errors import RadiationError
from rocsafe_radiation.products.dose_map import DoseMap

BANDS = (
    ('mean', 'dose rate 1 m above ground, uSv/h'),
    ('std', 'standard deviation of the mean, uSv/h'),
    ('upper_95', 'upper 95 % of the dose rate, uSv/h'),
)


class DoseMapFileError(RadiationError):
    """A map cannot be written."""


def write_dose_map(
    path: Path, found: DoseMap, frame: LocalFrame, doubts: Sequence[str] = ()
) -> None:
    """Write `found` in a transverse Mercator projection about the origin of `frame`.

    Its axes are east and north of the frame to a millimetre within 5 km. Bands: mean, standard
    deviation, upper 95 %, each microsievert per hour. The tag ``DOUBTS`` holds `doubts`, a line
    each.

    Raises
    ------
    DoseMapFileError
        If the file cannot be written.
    """
    origin = frame.origin
    projection = CRS.from_proj4(
        f'+proj=tmerc +lat_0={origin.latitude_deg!r} +lon_0={origin.longitude_deg!r} +k=1 '
        '+x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs'
    )
    rows, columns = found.mean_usvh.shape
    # Nodes are the centres of pixels; the first row of a GeoTIFF is the northernmost.
    west = found.corner_m[0] - found.cell_m / 2.0
    top = found.corner_m[1] + (rows - 0.5) * found.cell_m
    try:
        with rasterio.open(
            path, 'w', driver='GTiff', width=columns, height=rows, count=len(BANDS),
            dtype='float32', crs=projection, compress='deflate',
            transform=from_origin(west, top, found.cell_m, found.cell_m),
        ) as raster:  # fmt: skip
            if doubts:
                raster.update_tags(DOUBTS='\n'.join(doubts))
            for number, (name, meaning) in enumerate(BANDS, 1):
                values = {
                    'mean': found.mean_usvh,
                    'std': found.std_usvh,
                    'upper_95': found.upper_usvh,
                }[name]
                raster.write(np.flipud(values).astype(np.float32), number)
                raster.set_band_description(number, f'{name}: {meaning}')
    except (RasterioError, OSError) as error:
        raise DoseMapFileError(f'{path}: cannot be written: {error}') from error
