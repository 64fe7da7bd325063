# SPDX-License-Identifier: Apache-2.0
"""The record of a photograph as Exif, for every program that reads geotagged photographs."""

import math
import struct
from datetime import datetime, timezone
from fractions import Fraction
from typing import Any

import numpy as np
from PIL import Image
from PIL.ExifTags import GPS, IFD, Base
from PIL.TiffImagePlugin import IFDRational

from rocsafe_geo.pinhole import rotation_of_quaternion
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.photographs.xmp import MARK, xmp_segment

MAKE = 'ROCSAFE'
MODEL = 'ROCSAFE nadir camera'
# Denominators: 1e-7 arc second is 3 micrometres on the ground.
ARC_SECOND_STEPS = 10_000_000
MILLI = 1000
CENTI = 100
# A film frame is 36 mm x 24 mm.
FILM_WIDTH_MM = 36.0
FILM_DIAGONAL_MM = math.hypot(36.0, 24.0)
SCREEN_DPI = 72
UNIT_INCH, UNIT_CENTIMETRE = 2, 3
# Exif 3.0: heights above and below the ellipsoid.
ABOVE_ELLIPSOID, BELOW_ELLIPSOID = b'\x00', b'\x01'
# A heading is read off the image only where its top edge points somewhere over the ground.
SMALLEST_HORIZONTAL = 1e-3
JPEG_START = b'\xff\xd8'
APP0, APP1 = 0xE0, 0xE1
# Application segments and comments.
LEADING = frozenset(range(APP0, APP0 + 16)) | {0xFE}
EXIF_MARK = b'Exif\x00\x00'
Tags = dict[int, Any]


def with_exif(jpeg: bytes, record: ShotRecord) -> bytes:
    """Return `jpeg` with the Exif and XMP of `record` in place of its own; no pixel changes.

    Raises
    ------
    ValueError
        If `jpeg` does not begin like a JPEG file.
    """
    block = exif_of(record)
    segment = bytes((0xFF, APP1)) + struct.pack('>H', len(block) + 2) + block
    leading, rest = _split(jpeg)
    kept = [part for part in leading if not part[4:].startswith((EXIF_MARK, MARK))]
    # A JFIF segment, APP0, keeps its place at the very beginning.
    first = 1 if kept and kept[0][1] == APP0 else 0
    kept[first:first] = [segment, xmp_segment(record)]
    return JPEG_START + b''.join(kept) + rest


def exif_of(record: ShotRecord) -> bytes:
    """Return the Exif block of `record`, its mark included."""
    exposed = datetime.fromtimestamp(record.time_ns // NS_PER_S, tz=timezone.utc)
    exif = Image.Exif()
    exif.update(_image_tags(exposed))
    # Set whole: what get_ifd returns is written by Pillow 11.1 and newer only.
    exif[IFD.Exif] = _camera_tags(record, exposed)
    exif[IFD.GPSInfo] = _gps_tags(record, exposed)
    return exif.tobytes()


def heading_deg(record: ShotRecord) -> float | None:
    """Return the heading of the image's top, degrees clockwise from north, None if unknown."""
    try:
        rotation = rotation_of_quaternion(record.orientation_xyzw)
    except ValueError:
        return None
    east, north, _ = rotation @ np.array([0.0, -1.0, 0.0])
    if math.hypot(east, north) < SMALLEST_HORIZONTAL:
        return None
    return math.degrees(math.atan2(east, north)) % 360.0


def _split(jpeg: bytes) -> tuple[list[bytes], bytes]:
    """Return the application and comment segments that lead `jpeg`, and what follows them."""
    if not jpeg.startswith(JPEG_START):
        raise ValueError('not a JPEG file: it does not begin with FF D8')
    segments = []
    start = len(JPEG_START)
    while start + 4 <= len(jpeg) and jpeg[start + 1] in LEADING:
        end = start + 2 + struct.unpack_from('>H', jpeg, start + 2)[0]
        segments.append(jpeg[start:end])
        start = end
    return segments, jpeg[start:]


def _image_tags(exposed: datetime) -> Tags:
    return {
        Base.Make: MAKE,
        Base.Model: MODEL,
        Base.Orientation: 1,
        Base.XResolution: _rational(SCREEN_DPI, 1),
        Base.YResolution: _rational(SCREEN_DPI, 1),
        Base.ResolutionUnit: UNIT_INCH,
        Base.DateTime: exposed.strftime('%Y:%m:%d %H:%M:%S'),
        Base.YCbCrPositioning: 1,
    }


def _camera_tags(record: ShotRecord, exposed: datetime) -> Tags:
    """Return the camera's tags.

    The size of the sensor is not known and does not matter: the focal length is given for a sensor
    36 mm wide, whose pixel pitch the focal plane resolution states.
    """
    camera = record.camera
    focal_mm = camera.fx_px * FILM_WIDTH_MM / camera.width_px
    diagonal_px = math.hypot(camera.width_px, camera.height_px)
    pixels_per_cm = _rational(camera.width_px * CENTI, round(FILM_WIDTH_MM * CENTI / 10.0))
    return {
        Base.ExifVersion: b'0232',
        Base.DateTimeOriginal: exposed.strftime('%Y:%m:%d %H:%M:%S'),
        Base.SubsecTimeOriginal: f'{record.time_ns % NS_PER_S:09d}',
        Base.OffsetTimeOriginal: '+00:00',
        Base.FlashPixVersion: b'0100',
        Base.ColorSpace: 1,
        Base.ExifImageWidth: camera.width_px,
        Base.ExifImageHeight: camera.height_px,
        Base.FocalLength: _rational(round(focal_mm * MILLI), MILLI),
        Base.FocalLengthIn35mmFilm: round(camera.fx_px * FILM_DIAGONAL_MM / diagonal_px),
        Base.FocalPlaneXResolution: pixels_per_cm,
        Base.FocalPlaneYResolution: pixels_per_cm,
        Base.FocalPlaneResolutionUnit: UNIT_CENTIMETRE,
        Base.BodySerialNumber: record.vehicle,
        Base.ImageUniqueID: record.sha256[:32],
    }


def _gps_tags(record: ShotRecord, exposed: datetime) -> Tags:
    second_ms = exposed.second * MILLI + record.time_ns % NS_PER_S * MILLI // NS_PER_S
    tags: Tags = {
        GPS.GPSVersionID: b'\x02\x03\x00\x00',
        GPS.GPSMapDatum: 'WGS-84',
        GPS.GPSDateStamp: exposed.strftime('%Y:%m:%d'),
        GPS.GPSTimeStamp: (
            _rational(exposed.hour, 1),
            _rational(exposed.minute, 1),
            _rational(second_ms, MILLI),
        ),
    }
    heading = heading_deg(record)
    if heading is not None:
        tags[GPS.GPSImgDirectionRef] = 'T'
        tags[GPS.GPSImgDirection] = _rational(round(heading * CENTI) % (360 * CENTI), CENTI)
    return tags | _position_tags(record) if record.has_position else tags


def _position_tags(record: ShotRecord) -> Tags:
    below = record.altitude_m < 0.0
    tags: Tags = {
        GPS.GPSLatitudeRef: 'S' if record.latitude_deg < 0.0 else 'N',
        GPS.GPSLatitude: _sexagesimal(record.latitude_deg),
        GPS.GPSLongitudeRef: 'W' if record.longitude_deg < 0.0 else 'E',
        GPS.GPSLongitude: _sexagesimal(record.longitude_deg),
        GPS.GPSAltitudeRef: BELOW_ELLIPSOID if below else ABOVE_ELLIPSOID,
        GPS.GPSAltitude: _rational(round(abs(record.altitude_m) * MILLI), MILLI),
    }
    variance_m2 = record.position_covariance_m2[0] + record.position_covariance_m2[4]
    if 0.0 < variance_m2 < math.inf:
        error_mm = round(math.sqrt(variance_m2) * MILLI)
        tags[GPS.GPSHPositioningError] = _rational(error_mm, MILLI)
    return tags


def _sexagesimal(angle_deg: float) -> tuple[IFDRational, IFDRational, IFDRational]:
    """Return degrees, minutes and seconds of the size of `angle_deg`."""
    # Exact: a product of floats would round up to 60 seconds, or lose a step.
    steps = round(abs(Fraction(angle_deg)) * 3600 * ARC_SECOND_STEPS)
    minutes, seconds = divmod(steps, 60 * ARC_SECOND_STEPS)
    degrees, minutes = divmod(minutes, 60)
    return (
        _rational(degrees, 1),
        _rational(minutes, 1),
        _rational(seconds, ARC_SECOND_STEPS),
    )


def _rational(numerator: int, denominator: int) -> IFDRational:
    return IFDRational(numerator, denominator)
