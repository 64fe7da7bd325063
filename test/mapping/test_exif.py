# SPDX-License-Identifier: Apache-2.0
"""Other programs read from a stored photograph where, when and whereto it was taken."""

import dataclasses
import json
import math
import shutil
import subprocess

import cv2
import numpy as np
import piexif
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_optical
from rocsafe_mapping.photographs.exif import heading_deg, with_exif

# 1e-7 arc second.
ANGLE_TOLERANCE_DEG = 1e-7 / 3600.0
FOUR_QUADRANTS = [(53.28, -9.06), (-33.86, 151.21), (40.71, 74.0), (-22.9, -43.2)]


def tags_of(jpeg):
    """Return the Exif of `jpeg` as piexif reads it: its camera tags and its GPS tags."""
    exif = piexif.load(jpeg)
    return named(exif, '0th') | named(exif, 'Exif'), named(exif, 'GPS')


def named(exif, ifd):
    """Return the tags of one directory by their names."""
    return {piexif.TAGS[ifd][tag]['name']: plain(value) for tag, value in exif[ifd].items()}


def plain(value):
    """Return texts as such and fractions as numbers."""
    if isinstance(value, bytes):
        return value.decode('latin-1')
    if isinstance(value, tuple) and isinstance(value[0], tuple):
        return [numerator / denominator for numerator, denominator in value]
    return value


def number(fraction):
    """Return a fraction (numerator, denominator) as a number."""
    return fraction[0] / fraction[1]


def degrees_of(parts, reference):
    """Return signed degrees."""
    size = sum(part / 60.0**power for power, part in enumerate(parts))
    return -size if reference in 'SW' else size


def facing(yaw_deg):
    """Return the orientation of a level nadir camera."""
    return tuple(quaternion_of_rotation(rotation_enu_from_optical(math.radians(yaw_deg))).tolist())


@pytest.mark.parametrize(('latitude', 'longitude'), FOUR_QUADRANTS)
def test_the_position_is_right_in_all_four_quadrants(shot, latitude, longitude):
    """References carry the signs."""
    record, image = shot(0, latitude_deg=latitude, longitude_deg=longitude)
    _, gps = tags_of(with_exif(image, record))
    read_latitude = degrees_of(gps['GPSLatitude'], gps['GPSLatitudeRef'])
    read_longitude = degrees_of(gps['GPSLongitude'], gps['GPSLongitudeRef'])
    assert read_latitude == pytest.approx(latitude, abs=ANGLE_TOLERANCE_DEG)
    assert read_longitude == pytest.approx(longitude, abs=ANGLE_TOLERANCE_DEG)


@given(latitude=st.floats(-90, 90), longitude=st.floats(-180, 180), altitude=st.floats(-400, 9000))
@settings(max_examples=50)
def test_every_position_survives(shot, latitude, longitude, altitude):
    """Rounding of seconds never shows 60 of them."""
    record, image = shot(0, latitude_deg=latitude, longitude_deg=longitude, altitude_m=altitude)
    _, gps = tags_of(with_exif(image, record))
    assert all(0 <= part < 60 for part in gps['GPSLatitude'][1:])
    read = degrees_of(gps['GPSLongitude'], gps['GPSLongitudeRef'])
    assert read == pytest.approx(longitude, abs=ANGLE_TOLERANCE_DEG)
    sign = -1 if gps['GPSAltitudeRef'] == 1 else 1
    assert sign * number(gps['GPSAltitude']) == pytest.approx(altitude, abs=5.1e-4)


def test_the_time_is_that_of_the_exposure(shot):
    """2023-11-14 22:13:20.123456789 UTC, to the nanosecond."""
    camera, gps = tags_of(with_exif(shot(0)[1], shot(0)[0]))
    assert camera['DateTimeOriginal'] == '2023:11:14 22:13:20'
    assert camera['SubSecTimeOriginal'] == '123456789'
    assert camera['OffsetTimeOriginal'] == '+00:00'
    assert gps['GPSDateStamp'] == '2023:11:14'
    assert gps['GPSTimeStamp'] == [22.0, 13.0, 20.123]


@pytest.mark.parametrize(
    ('yaw_deg', 'heading'), [(90.0, 0.0), (0.0, 90.0), (-90.0, 180.0), (180.0, 270.0)]
)
def test_the_image_direction_is_the_heading_of_the_image_top(shot, yaw_deg, heading):
    """Clockwise from true north, while yaw is anticlockwise from east."""
    record, image = shot(0, orientation_xyzw=facing(yaw_deg))
    _, gps = tags_of(with_exif(image, record))
    assert gps['GPSImgDirectionRef'] == 'T'
    difference = (number(gps['GPSImgDirection']) - heading + 180.0) % 360.0 - 180.0
    assert difference == pytest.approx(0.0, abs=0.006)


def test_an_unknown_orientation_has_no_heading(shot):
    """Nothing is made up."""
    assert heading_deg(shot(0, orientation_xyzw=(0.0, 0.0, 0.0, 0.0))[0]) is None
    record, image = shot(0, orientation_xyzw=(math.nan,) * 4)
    assert 'GPSImgDirection' not in tags_of(with_exif(image, record))[1]


def test_an_unknown_position_has_no_tags(shot):
    """A photograph taken without a fix is stored all the same."""
    record, image = shot(0, latitude_deg=math.nan, longitude_deg=math.nan, altitude_m=math.nan)
    _, gps = tags_of(with_exif(image, record))
    assert not {'GPSLatitude', 'GPSLongitude', 'GPSAltitude'} & set(gps)


def test_the_focal_length_is_that_of_the_camera(shot):
    """Both ways that programs use: by film diagonal, and by pixel pitch."""
    record, image = shot()
    camera, _ = tags_of(with_exif(image, record))
    # 55 px of an 80 px diagonal; 43.27 mm is the diagonal of film.
    assert camera['FocalLengthIn35mmFilm'] == 30
    pixels_per_mm = number(camera['FocalPlaneXResolution']) / 10.0
    assert number(camera['FocalLength']) * pixels_per_mm == pytest.approx(55.0, rel=1e-4)
    assert camera['Make'] == 'ROCSAFE'
    assert camera['BodySerialNumber'] == 'rav1'


def test_no_pixel_is_coded_anew(shot):
    """The compressed pixels are the same bytes."""
    record, image = shot()
    tagged = with_exif(image, record)
    start = image.index(b'\xff\xda')
    assert tagged.endswith(image[start:])
    before, after = (cv2.imdecode(np.frombuffer(data, np.uint8), 1) for data in (image, tagged))
    np.testing.assert_array_equal(before, after)


def test_exif_of_the_camera_is_replaced(shot):
    """There is one Exif block, the newest."""
    record, image = shot()
    twice = with_exif(with_exif(image, record), dataclasses.replace(record, altitude_m=-3.0))
    assert twice.count(b'Exif\x00\x00') == 1
    _, gps = tags_of(twice)
    assert (gps['GPSAltitudeRef'], number(gps['GPSAltitude'])) == (1, 3.0)


@pytest.mark.skipif(shutil.which('exiftool') is None, reason='exiftool is not installed')
def test_exiftool_reads_the_same(shot, tmp_path):
    """In all four quadrants, below the ellipsoid, and without a warning."""
    paths = []
    for number, (latitude, longitude) in enumerate(FOUR_QUADRANTS):
        place = {'latitude_deg': latitude, 'longitude_deg': longitude, 'altitude_m': -3.25}
        record, image = shot(0, **place)
        paths.append(tmp_path / f'{number}.jpg')
        paths[-1].write_bytes(with_exif(image, record))
    command = ['exiftool', '-j', '-n', '-a', '-all', '-validate', *map(str, paths)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=60)
    for tags, (latitude, longitude) in zip(json.loads(done.stdout), FOUR_QUADRANTS, strict=True):
        assert tags['GPSLatitude'] == pytest.approx(latitude, abs=1e-9)
        assert tags['GPSLongitude'] == pytest.approx(longitude, abs=1e-9)
        assert tags['GPSAltitude'] == pytest.approx(-3.25)
        assert tags['GPSImgDirection'] == pytest.approx(60.0)
        assert tags['SubSecDateTimeOriginal'] == '2023:11:14 22:13:20.123456789+00:00'
        assert (tags['Make'], tags['ImageWidth']) == ('ROCSAFE', 64)
        # Errors, warnings, minor ones. One tag is left out that no JPEG file needs.
        assert tags['Validate'] == '0 1 0'
        assert tags['Warning'].endswith('0x9101 ComponentsConfiguration')
