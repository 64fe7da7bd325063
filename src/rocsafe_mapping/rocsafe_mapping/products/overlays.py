# SPDX-License-Identifier: Apache-2.0
"""The map for programs that do not read GeoTIFF: picture with world file, KML, MBTiles."""

import math
from pathlib import Path
from xml.sax.saxutils import escape

import cv2
import numpy as np
import rasterio
import rasterio.shutil
from numpy.typing import NDArray
from pyproj import CRS, Transformer
from rasterio.enums import Resampling
from rasterio.io import DatasetReader
from rasterio.transform import Affine
from rasterio.vrt import WarpedVRT
from rasterio.warp import calculate_default_transform, transform_bounds

from rocsafe_geo.storage.durable import discard_part, finish_part, part_of, write_whole
from rocsafe_mapping.drawing.grid import FINEST_ZOOM, TILE_PX, WEB_MERCATOR_EPSG, WORLD_M
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.products.cog import CACHE_BYTES, GDAL_ERRORS, LOCAL_WKT

LONGEST_SIDE_PX = 2048
KML = """<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">
<GroundOverlay>
  <name>{name}</name>
  <Icon><href>{picture}</href></Icon>
  <gx:LatLonQuad><coordinates>{corners}</coordinates></gx:LatLonQuad>
</GroundOverlay>
</kml>
"""


def write_overlays(cog: Path, stem: Path) -> tuple[Path, ...]:
    """Write `stem`.png, its world file, its projection and `stem`.kml; return their paths.

    The picture's longer side is at most 2048 pixels. A local map has no KML.

    Raises
    ------
    MappingError
        If the map cannot be read or a file cannot be written.
    """
    picture, world, projection, kml = (
        stem.with_suffix(suffix) for suffix in ('.png', '.pgw', '.prj', '.kml')
    )
    try:
        with rasterio.open(cog) as file:
            shrink = max(1.0, max(file.width, file.height) / LONGEST_SIDE_PX)
            width, height = round(file.width / shrink), round(file.height / shrink)
            rgba = file.read(out_shape=(4, height, width), resampling=Resampling.average)
            transform, crs = file.transform, file.crs
            scale = file.width / width, file.height / height
        write_whole(picture, _png(np.moveaxis(rgba, 0, 2)))
        pixel = transform.a * scale[0], transform.e * scale[1]
        first = transform.c + 0.5 * pixel[0], transform.f + 0.5 * pixel[1]
        lines = (pixel[0], 0.0, 0.0, pixel[1], *first)
        write_whole(world, ''.join(f'{value:.10f}\n' for value in lines).encode())
        epsg = crs.to_epsg()
        if epsg is None:
            write_whole(projection, LOCAL_WKT.encode())
            return picture, world, projection
        write_whole(projection, CRS.from_epsg(epsg).to_wkt('WKT1_ESRI').encode())
        east = transform.c + width * pixel[0]
        south = transform.f + height * pixel[1]
        corners = _corners(epsg, (transform.c, south, east, transform.f))
        text = KML.format(name=escape(stem.name), picture=escape(picture.name), corners=corners)
        write_whole(kml, text.encode())
    except GDAL_ERRORS as error:
        raise MappingError(f'cannot write overlays of {cog}: {error}') from error
    return picture, world, projection, kml


def write_mbtiles(cog: Path, path: Path) -> None:
    """Write the map as tiles of the web's projection in one SQLite file (MBTiles 1.3).

    Raises
    ------
    MappingError
        If it cannot be written.
    """
    part = part_of(path).with_suffix('.mbtiles')
    try:
        part.unlink(missing_ok=True)
        with rasterio.Env(GDAL_CACHEMAX=CACHE_BYTES):
            with rasterio.open(cog) as map_file, _on_tiles(map_file) as tiled:
                rasterio.shutil.copy(tiled, part, driver='MBTILES', TILE_FORMAT='PNG', ZLEVEL='1')
            with rasterio.open(part, 'r+') as file:
                levels = [2**power for power in range(1, 10)
                          if max(file.width, file.height) >> power >= 64]  # fmt: skip
                file.build_overviews(levels or [2], Resampling.average)
        part.replace(part_of(path))
        finish_part(path)
    except GDAL_ERRORS as error:
        part.unlink(missing_ok=True)
        discard_part(path)
        raise MappingError(f'cannot write tiles {path}: {error}') from error


def _on_tiles(source: DatasetReader) -> WarpedVRT:
    """Return a map in Web Mercator whose edges are edges of tiles.

    Otherwise GDAL shifts the map by up to a pixel.
    """
    wished, _, _ = calculate_default_transform(
        source.crs, f'EPSG:{WEB_MERCATOR_EPSG}', source.width, source.height, *source.bounds
    )
    zoom = min(round(math.log2(2.0 * WORLD_M / TILE_PX / wished.a)), FINEST_ZOOM)
    pixel_m = 2.0 * WORLD_M / TILE_PX / 2**zoom
    side_m = TILE_PX * pixel_m
    west, south, east, north = transform_bounds(
        source.crs, f'EPSG:{WEB_MERCATOR_EPSG}', *source.bounds
    )
    first, top = math.floor((west + WORLD_M) / side_m), math.floor((WORLD_M - north) / side_m)
    columns = math.ceil((east + WORLD_M) / side_m) - first
    rows = math.ceil((WORLD_M - south) / side_m) - top
    return WarpedVRT(
        source,
        crs=f'EPSG:{WEB_MERCATOR_EPSG}',
        transform=Affine(
            pixel_m, 0.0, first * side_m - WORLD_M, 0.0, -pixel_m, WORLD_M - top * side_m
        ),
        width=columns * TILE_PX,
        height=rows * TILE_PX,
        resampling=Resampling.bilinear,
    )


def _corners(epsg: int, bounds_m: tuple[float, float, float, float]) -> str:
    """Return lower left, lower right, upper right, upper left as KML wants them."""
    west, south, east, north = bounds_m
    to_wgs84 = Transformer.from_crs(epsg, 4326, always_xy=True)
    longitudes, latitudes = to_wgs84.transform(
        [west, east, east, west], [south, south, north, north]
    )
    return ' '.join(
        f'{longitude:.9f},{latitude:.9f}'
        for longitude, latitude in zip(longitudes, latitudes, strict=True)
    )


def _png(rgba: NDArray[np.uint8]) -> bytes:
    _, png = cv2.imencode('.png', cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGRA),
                          [cv2.IMWRITE_PNG_COMPRESSION, 1])  # fmt: skip
    return bytes(png)
