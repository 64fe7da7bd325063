# SPDX-License-Identifier: Apache-2.0
"""Products of a survey, small and made up, to plan drives on."""

import json
import math
from pathlib import Path

import numpy as np
import rasterio
from rasterio.transform import from_origin

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition

ORIGIN = GeoPosition(53.28, -9.06, 0.0)
FRAME = LocalFrame(ORIGIN)
PROJECTION = (
    f'+proj=tmerc +lat_0={ORIGIN.latitude_deg!r} +lon_0={ORIGIN.longitude_deg!r} +k=1 +x_0=0 '
    '+y_0=0 +datum=WGS84 +units=m'
)
# Half of the side, and the pixels of mosaic and dose map, metres.
HALF_M, PIXEL_M, DOSE_CELL_M = 40.0, 0.25, 2.0
GRASS, ROAD, SOIL = (110, 140, 70), (130, 130, 130), (140, 105, 75)
RED, WATER, DARK = (210, 30, 30), (40, 60, 90), (10, 10, 10)
SOURCE_RATE_USVH = 50_000.0


def position(east_m: float, north_m: float) -> GeoPosition:
    """Return a place of the village."""
    return FRAME.position_of([east_m, north_m, math.nan])


def text(east_m: float, north_m: float) -> str:
    """Return a place as on a command line."""
    place = position(east_m, north_m)
    return f'{place.latitude_deg:.9f},{place.longitude_deg:.9f}'


def write_village(
    folder: Path, *, source=(0.0, 10.0), rate_std_usvh: float = 2500.0, place_std_m: float = 0.2
) -> Path:
    """Write mosaic, dose map and sources: a meadow with a road along its northern side.

    A red wall runs from the west along north = 20 and ends at east = 10; the strip east of 36 was
    not seen.
    """
    folder.mkdir(parents=True, exist_ok=True)
    east, north = _axes(PIXEL_M)
    image = np.zeros((4, *east.shape), np.uint8)
    image[:3] = np.array(GRASS, np.uint8)[:, None, None]
    _paint(image, (north > 30.0) & (north < 36.0), ROAD)
    _paint(image, (np.abs(north - 20.0) < 0.5) & (east < 10.0), RED)
    image[3] = np.where(east < 36.0, 255, 0)
    write_bands(folder / 'mosaic.tif', image, PIXEL_M)
    east, north = _axes(DOSE_CELL_M)
    law = SOURCE_RATE_USVH / ((east - source[0]) ** 2 + (north - source[1]) ** 2 + 1e-6)
    mean = 0.1 + law
    std = law * rate_std_usvh / SOURCE_RATE_USVH
    write_bands(folder / 'dose_map.tif', np.stack([mean, std, mean + 1.645 * std]), DOSE_CELL_M)
    place = FRAME.to_geodetic([*source, 1.0])[0]
    found = {
        'place': dict(
            zip(('latitude_deg', 'longitude_deg', 'altitude_m'), place.tolist(), strict=True)
        ),
        'position_covariance_m2': [[place_std_m**2, 0, 0], [0, place_std_m**2, 0], [0, 0, 0.01]],
        'dose_rate_at_1m_usvh': SOURCE_RATE_USVH,
        'dose_rate_at_1m_std_usvh': rate_std_usvh,
    }
    document = {'background_usvh': 0.1, 'background_std_usvh': 0.01, 'sources': [found]}
    (folder / 'sources.json').write_text(json.dumps(document))
    return folder


def _axes(pixel_m):
    middle = np.arange(-HALF_M + pixel_m / 2, HALF_M, pixel_m)
    return np.meshgrid(middle, middle[::-1])


def _paint(image, where, colour):
    for band, value in zip(image[:3], colour, strict=True):
        band[where] = value


def write_bands(path: Path, bands, pixel_m: float) -> None:
    """Write bands over the village, row 0 in the north."""
    count, rows, columns = bands.shape
    with rasterio.open(
        path, 'w', driver='GTiff', count=count, height=rows, width=columns,
        dtype=str(bands.dtype), crs=PROJECTION,
        transform=from_origin(-HALF_M, HALF_M, pixel_m, pixel_m),
    ) as file:  # fmt: skip
        file.write(bands)


def write_labels(folder: Path) -> Path:
    """Write labels of the village: meadow with two drums, a pond in the way of colours."""
    east, north = _axes(PIXEL_M)
    labels = np.full((1, *east.shape), 1, np.uint8)
    labels[0][np.hypot(east + 10.0, north) < 0.5] = 2
    labels[0][np.hypot(east - 5.0, north + 15.0) < 0.4] = 2
    labels[0][np.hypot(east - 25.0, north + 25.0) < 5.0] = 3
    write_bands(folder / 'labels.tif', labels, PIXEL_M)
    rows = [
        {'value': value, 'class': name}
        for value, name in ((1, 'meadow'), (2, 'drum'), (3, 'water'))
    ]
    (folder / 'labels.json').write_text(json.dumps({'classes': rows}))
    return folder / 'labels.tif'


def write_gas(folder: Path, *, load_exponent: float | None = 2.0) -> Path:
    """Write a plume around east 0, north -20, up to 400 ppm of a gas, and its level of 100 ppm."""
    east, north = _axes(DOSE_CELL_M)
    mean = 400.0 * np.exp(-(east**2 + (north + 20.0) ** 2) / 200.0)
    write_bands(folder / 'plume.tif', np.stack([mean, 1.2 * mean]), DOSE_CELL_M)
    facts = {
        'level': 'AEGL-2', 'ppm': 100.0, 'averaging_minutes': 60.0, 'agent': 'ammonia',
        'load_exponent': load_exponent,
    }  # fmt: skip
    zones = {'type': 'FeatureCollection', 'features': [{'properties': facts}]}
    (folder / 'threat_zones.geojson').write_text(json.dumps(zones))
    return folder
