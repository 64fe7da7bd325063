# SPDX-License-Identifier: Apache-2.0
"""The tags of a photograph's file: Exif and XMP as they stand there."""

import io
import math
import re
import stat
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image, UnidentifiedImageError
from PIL.ExifTags import IFD

from rocsafe_mapping.errors import StoreError

MOST_BYTES = 2**29
MOST_PIXELS = 300_000_000
_XMP = re.compile(rb'<x:xmpmeta.*?</x:xmpmeta>', re.DOTALL)
_XMP_VALUE = re.compile(r'(drone-dji|Camera|FLIR|rocsafe):(\w+)(?:="([^"]*)"|>([^<]*)<)')


@dataclass(frozen=True, slots=True, kw_only=True)
class Tags:
    """The tags of a photograph.

    Attributes
    ----------
    image, camera, gps
        Exif by tag.
    xmp
        By prefix and name, e.g. ``drone-dji:GimbalYawDegree``.
    width_px, height_px
        Size of the picture.
    """

    image: Mapping[int, Any]
    camera: Mapping[int, Any]
    gps: Mapping[int, Any]
    xmp: Mapping[str, str]
    width_px: int
    height_px: int

    def text(self, tag: int) -> str:
        """Return a text of the image's Exif, without padding."""
        value = self.image.get(tag, '')
        return str(value).replace('\x00', ' ').strip()

    def number(self, *names: str, most: float = math.inf) -> float:
        """Return the first of some XMP values that is a finite number, NaN if none is.

        Raises
        ------
        ValueError
            If it is not within `most` of 0.
        """
        for name in names:
            value = number_of(self.xmp.get(name))
            if math.isfinite(value):
                return limited(name, value, most)
        return math.nan


def number_of(value: object) -> float:
    """Return the value of a tag as a finite number, NaN if it is none."""
    if isinstance(value, str):
        value = value.replace('\x00', ' ')
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError, ZeroDivisionError):
        return math.nan
    return number if math.isfinite(number) else math.nan


def limited(name: str, value: float, most: float) -> float:
    """Return a value; raise ValueError if it is not within `most` of 0, NaN may be."""
    if abs(value) > most:
        raise ValueError(f'{name} = {value:g} must be from {-most:g} to {most:g}')
    return value


def read_tags(path: Path) -> tuple[Tags, bytes]:
    """Return the tags of a photograph, and the file.

    Raises
    ------
    StoreError
        If it is no picture, or larger than any photograph.
    """
    try:
        _require_file(path)
        data = path.read_bytes()
        with Image.open(io.BytesIO(data)) as image:
            size = _credible(image.size)
            exif = image.getexif()
            camera, gps = dict(exif.get_ifd(IFD.Exif)), dict(exif.get_ifd(IFD.GPSInfo))
    except UnidentifiedImageError as error:
        raise StoreError(f'cannot read photograph {path}: it is no picture') from error
    except OSError as error:
        raise StoreError(f'cannot read photograph {path}: {error.strerror or error}') from error
    except (SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise StoreError(f'cannot read photograph {path}: {error}') from error
    found = _XMP.search(data)
    text = found.group(0).decode('utf-8', 'replace') if found else ''
    xmp = {f'{p}:{name}': a or b for p, name, a, b in _XMP_VALUE.findall(text)}
    tags = Tags(
        image=dict(exif), camera=camera, gps=gps, xmp=xmp, width_px=size[0], height_px=size[1]
    )
    return tags, data


def _credible(size: tuple[int, int]) -> tuple[int, int]:
    """Return the size that a picture claims; raise ValueError if it would fill the memory."""
    if size[0] * size[1] > MOST_PIXELS:
        raise ValueError(f'{size[0]} x {size[1]} pixels exceed {MOST_PIXELS}')
    return size


def _require_file(path: Path) -> None:
    """Raise ValueError unless `path` is a file of a credible size: a pipe would block."""
    status = path.stat()
    if not stat.S_ISREG(status.st_mode):
        raise ValueError('it is no file')
    if not 0 < status.st_size <= MOST_BYTES:
        raise ValueError(f'{status.st_size} bytes are not from 1 to {MOST_BYTES}')
