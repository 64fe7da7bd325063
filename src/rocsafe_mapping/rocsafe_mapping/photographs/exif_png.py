# SPDX-License-Identifier: Apache-2.0
"""The record of a photograph in a PNG file: the same Exif and XMP as in a JPEG file."""

import struct
from zlib import crc32

from rocsafe_mapping.photographs.exif import EXIF_MARK, exif_of
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.photographs.xmp import xmp_packet

PNG_START = b'\x89PNG\r\n\x1a\n'
# Keyword, no compression, no language, no translation (XMP specification, part 3).
XMP_HEAD = b'XML:com.adobe.xmp\x00\x00\x00\x00\x00'
# Length, name, 13 bytes and checksum of the chunk that comes first.
HEADER_BYTES = 25


def png_with_exif(png: bytes, record: ShotRecord) -> bytes:
    """Return `png`, which has none, with the Exif and XMP of `record`; no pixel changes.

    Raises
    ------
    ValueError
        If `png` does not begin like a PNG file.
    """
    if not png.startswith(PNG_START):
        raise ValueError('not a PNG file: it does not begin with 89 50 4E 47')
    head = len(PNG_START) + HEADER_BYTES
    exif = _chunk(b'eXIf', exif_of(record).removeprefix(EXIF_MARK))
    xmp = _chunk(b'iTXt', XMP_HEAD + xmp_packet(record).encode())
    return png[:head] + exif + xmp + png[head:]


def _chunk(name: bytes, data: bytes) -> bytes:
    checksum = crc32(name + data)
    return struct.pack('>I', len(data)) + name + data + struct.pack('>I', checksum)
