# SPDX-License-Identifier: Apache-2.0
"""Pictures inside the page: the map's ground and a thumbnail of each photograph, as data URIs."""

import base64
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rasterio
from numpy.typing import NDArray
from PIL import Image
from pyproj import Transformer
from rasterio.enums import Resampling
from rasterio.errors import RasterioError
from rasterio.transform import xy

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_orchestrator.products.run_record import Photograph
from rocsafe_view.map_marks import GroundPicture

MOST_MOSAIC_PX = 2000
MOST_MOSAIC_BYTES = 1_200_000
_MOSAIC_QUALITIES = (82, 70, 55, 40)
# All thumbnails together; beyond it they become smaller, then fewer.
MOST_THUMBNAIL_BYTES = 800_000
_THUMBNAIL_QUALITY = 55
_SMALLER_WIDTHS_PX = (224, 160, 96)


def ground_picture(path: Path, frame: LocalFrame) -> GroundPicture | None:
    """Return the mosaic at `path` scaled down to be embedded, None if it cannot be read."""
    try:
        with rasterio.open(path) as raster:
            if raster.crs is None:
                return None
            scale = min(MOST_MOSAIC_PX / max(raster.width, raster.height), 1.0)
            width = max(round(raster.width * scale), 1)
            height = max(round(raster.height * scale), 1)
            picture = _rgba(raster, width, height)
            rows, columns = (0, 0, raster.height), (0, raster.width, 0)
            places = np.column_stack(xy(raster.transform, rows, columns, offset='ul'))
            crs = raster.crs
    except (RasterioError, OSError, ValueError):
        return None
    return GroundPicture(
        data_uri=_webp(Image.fromarray(picture, 'RGBA')),
        width_px=width,
        height_px=height,
        matrix=_matrix(map_xy(places, crs, frame), width, height),
    )


def thumbnails(photographs: Sequence[Photograph]) -> dict[str, str]:
    """Return a JPEG data URI of each photograph that can be read, by shot id.

    All together stay below `MOST_THUMBNAIL_BYTES`; if even the smallest are too many, the last
    ones have none.
    """
    made: dict[str, str] = {}
    for width in _SMALLER_WIDTHS_PX:
        made = {shot.shot_id: uri for shot in photographs if (uri := _thumbnail(shot, width))}
        if sum(map(len, made.values())) <= MOST_THUMBNAIL_BYTES:
            return made
    return _within(made, MOST_THUMBNAIL_BYTES)


def _within(uris: dict[str, str], limit: int) -> dict[str, str]:
    kept, used = {}, 0
    for name, uri in uris.items():
        used += len(uri)
        if used > limit:
            break
        kept[name] = uri
    return kept


def _thumbnail(photograph: Photograph, width: int) -> str:
    try:
        with Image.open(photograph.path) as image:
            image.draft('RGB', (width, width))
            size = (width, max(round(width * image.height / image.width), 1))
            small = image.convert('RGB').resize(size, Image.Resampling.LANCZOS)
    except OSError:
        return ''
    stream = io.BytesIO()
    small.save(stream, 'JPEG', quality=_THUMBNAIL_QUALITY, optimize=True)
    return _data_uri('image/jpeg', stream.getvalue())


def _rgba(raster: 'rasterio.DatasetReader', width: int, height: int) -> NDArray[np.uint8]:
    bands = [1, 2, 3] if raster.count >= 3 else [1, 1, 1]
    shape = (height, width)
    colours = raster.read(bands, out_shape=(3, *shape), resampling=Resampling.average)
    alpha = raster.dataset_mask(out_shape=shape)
    rgba: NDArray[np.uint8] = np.dstack([*colours, alpha]).astype(np.uint8)
    return rgba


def map_xy(places: FloatArray, crs: object, frame: LocalFrame) -> FloatArray:
    """Return places (n, 2) of `crs` as map coordinates: east and south of the origin, metres."""
    to_wgs84 = Transformer.from_crs(crs, 'EPSG:4326', always_xy=True)
    longitudes, latitudes = to_wgs84.transform(places[:, 0], places[:, 1])
    altitudes = np.full(len(places), frame.origin.altitude_m)
    enu = frame.to_enu(np.asarray(latitudes), np.asarray(longitudes), altitudes)
    return np.column_stack([enu[:, 0], -enu[:, 1]])


def _matrix(
    corners: FloatArray, width: int, height: int
) -> tuple[float, float, float, float, float, float]:
    """Return the affine map that takes the picture's first three corners to `corners`."""
    across = (corners[1] - corners[0]) / width
    down = (corners[2] - corners[0]) / height
    a, b = map(float, across)
    c, d = map(float, down)
    e, f = map(float, corners[0])
    return a, b, c, d, e, f


def _webp(image: Image.Image) -> str:
    data = b''
    for quality in _MOSAIC_QUALITIES:
        stream = io.BytesIO()
        image.save(stream, 'WEBP', quality=quality, method=4)
        data = stream.getvalue()
        if len(data) <= MOST_MOSAIC_BYTES:
            break
    return _data_uri('image/webp', data)


def _data_uri(media_type: str, data: bytes) -> str:
    return f'data:{media_type};base64,{base64.b64encode(data).decode()}'
