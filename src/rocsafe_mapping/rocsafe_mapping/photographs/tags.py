# SPDX-License-Identifier: Apache-2.0
"""The tags of a photograph's file: Exif and XMP as they stand there."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image, UnidentifiedImageError
from PIL.ExifTags import IFD

from rocsafe_mapping.errors import StoreError

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

    def number(self, *names: str) -> float:
        """Return the first of some XMP values that is a number, NaN if none is."""
        for name in names:
            try:
                return float(self.xmp[name].replace('\x00', '').strip())
            except (KeyError, ValueError):
                continue
        return math.nan


def read_tags(path: Path) -> tuple[Tags, bytes]:
    """Return the tags of a photograph, and the file.

    Raises
    ------
    StoreError
        If it is no picture.
    """
    try:
        data = path.read_bytes()
        with Image.open(path) as image:
            exif = image.getexif()
            size = image.size
            camera, gps = dict(exif.get_ifd(IFD.Exif)), dict(exif.get_ifd(IFD.GPSInfo))
    except (OSError, SyntaxError, ValueError, UnidentifiedImageError) as error:
        raise StoreError(f'cannot read photograph {path}: {error}') from error
    found = _XMP.search(data)
    text = found.group(0).decode('utf-8', 'replace') if found else ''
    xmp = {f'{p}:{name}': a or b for p, name, a, b in _XMP_VALUE.findall(text)}
    tags = Tags(
        image=dict(exif), camera=camera, gps=gps, xmp=xmp, width_px=size[0], height_px=size[1]
    )
    return tags, data
