# SPDX-License-Identifier: Apache-2.0
"""A map of a hazard as a GeoTIFF of 32-bit floats."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rasterio
from rasterio.crs import CRS
from rasterio.errors import RasterioError
from rasterio.transform import from_origin

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Band:
    """Values (rows northwards, columns eastwards) with what they mean, in words and unit."""

    meaning: str
    values: FloatArray


def write_grid(
    path: Path,
    bands: Sequence[Band],
    corner_m: tuple[float, float],
    cell_m: float,
    frame: LocalFrame,
    doubts: Sequence[str] = (),
) -> None:
    """Write bands of one shape in a transverse Mercator projection about the origin of `frame`.

    Its axes are east and north of the frame to a millimetre within 5 km.

    Parameters
    ----------
    path
        The file.
    bands
        At least one.
    corner_m, cell_m
        East and north of the first node, and distance of nodes, metres.
    frame
        The frame.
    doubts
        What is not as assumed; the tag ``DOUBTS`` holds them, a line each.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    origin = frame.origin
    projection = CRS.from_proj4(
        f'+proj=tmerc +lat_0={origin.latitude_deg!r} +lon_0={origin.longitude_deg!r} +k=1 '
        '+x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs'
    )
    rows, columns = bands[0].values.shape
    # Nodes are the centres of pixels; the first row of a GeoTIFF is the northernmost.
    west = corner_m[0] - cell_m / 2.0
    top = corner_m[1] + (rows - 0.5) * cell_m
    try:
        with rasterio.open(
            path, 'w', driver='GTiff', width=columns, height=rows, count=len(bands),
            dtype='float32', crs=projection, compress='deflate',
            transform=from_origin(west, top, cell_m, cell_m),
        ) as raster:  # fmt: skip
            if doubts:
                raster.update_tags(DOUBTS='\n'.join(doubts))
            for number, band in enumerate(bands, 1):
                raster.write(np.flipud(band.values).astype(np.float32), number)
                raster.set_band_description(number, band.meaning)
    except (RasterioError, OSError) as error:
        raise OSError(f'{path}: cannot be written: {error}') from error
