# SPDX-License-Identifier: Apache-2.0
"""Tags of photographs that no camera should write: read, or refused by name, value and limit."""

import math

import pytest
from PIL import Image

from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.photographs.tags import Tags
from rocsafe_mapping.store.photograph_files import photographs_of, record_of_tags

FOCAL_LENGTH_35MM = 0xA405
DUBLIN = {1: 'N', 2: (53, 20, 0), 3: 'W', 4: (6, 15, 0)}
SHA256 = '0' * 64


def record_of(gps=DUBLIN, **xmp):
    """Return the record of a photograph with these tags of GPS and XMP."""
    names = {name.replace('__', ':').replace('dji', 'drone-dji'): v for name, v in xmp.items()}
    tags = Tags(
        image={},
        camera={FOCAL_LENGTH_35MM: 30},
        gps=gps,
        xmp=names,
        width_px=800,
        height_px=600,
    )
    return record_of_tags(tags, 'camera', 0, SHA256)


@pytest.mark.parametrize(('north', 'east'), [('N', 'E'), ('s', 'w'), ('South', 'West')])
def test_hemispheres_are_told_by_their_first_letter(north, east):
    """Small letters and whole words, which some programs write."""
    record = record_of({**DUBLIN, 1: north, 3: east})
    assert (record.latitude_deg > 0.0) == (north == 'N')
    assert (record.longitude_deg > 0.0) == (east == 'E')


@pytest.mark.parametrize('named', [None, '', 'N', b'\x03', 0])
def test_a_hemisphere_is_not_guessed(named):
    """A longitude without E or W would be drawn on the other side of Greenwich."""
    gps = {**DUBLIN, 3: named}
    if named is None:
        del gps[3]
    record = record_of(gps)
    assert math.isnan(record.latitude_deg)
    assert math.isnan(record.longitude_deg)


def test_a_photograph_without_a_hemisphere_is_kept_for_a_geo_txt(tmp_path):
    """It was left out, also where a geo.txt tells its place."""
    exif = Image.Exif()
    exif.get_ifd(0x8769)[FOCAL_LENGTH_35MM] = 30
    exif.get_ifd(0x8825).update({key: DUBLIN[key] for key in (1, 2, 4)})
    Image.new('RGB', (64, 48)).save(tmp_path / 'a.jpg', exif=exif)
    said = []
    (shot,) = photographs_of(tmp_path, said.append)
    assert math.isnan(shot.record.longitude_deg)
    assert said == [
        f'{tmp_path / "a.jpg"}: GPSLongitude is neither E nor W: its own place is not used'
    ]


@pytest.mark.parametrize(
    ('reference', 'altitude_m'),
    [
        *((below, -5.0) for below in (b'\x01', b'\x03', 1, 1.0, '1')),
        *((above, 5.0) for above in (b'\x00', b'', '0', None, (1, 1))),
    ],
)
def test_reference_of_the_altitude_may_be_of_any_type(reference, altitude_m):
    """A byte by the standard; texts and numbers ended in a traceback."""
    assert record_of({**DUBLIN, 5: reference, 6: 5.0}).altitude_m == altitude_m


@pytest.mark.parametrize('text', ['nan', 'inf', '-inf', '', 'x', '1e400'])
def test_what_is_no_finite_number_is_unknown(text):
    """Not a height that is infinite."""
    record = record_of(
        dji__RelativeAltitude=text, dji__AbsoluteAltitude=text, dji__GimbalYawDegree=text
    )
    assert math.isnan(record.height_agl_m)
    assert math.isnan(record.altitude_m)
    assert record.orientation_covariance_rad2[8] == pytest.approx(math.pi**2)


@pytest.mark.parametrize(
    ('name', 'text'),
    [
        ('dji__RelativeAltitude', '1e300'),
        ('dji__AbsoluteAltitude', '-1e5'),
        ('Camera__GPSXYAccuracy', '1e200'),
        ('Camera__Yaw', '1e300'),
        ('dji__GimbalYawDegree', '1e308'),
    ],
)
def test_impossible_values_are_refused_by_name(name, text):
    """They ended in a traceback, or in a map of nothing."""
    with pytest.raises(ValueError, match=r'^\S+:\w+ = \S+ must be from -\d+ to \d+$'):
        record_of(**{name: text})


def test_folder_without_jpeg_files_tells_what_it_has(tmp_path):
    """A memory card has its photographs in folders below; TIFF and PNG are not read."""
    with pytest.raises(MappingError, match=r'has no JPEG file$'):
        photographs_of(tmp_path, print)
    (tmp_path / 'a.tif').touch()
    with pytest.raises(MappingError, match=r'has no JPEG file; other kinds are not read: 1 \.tif'):
        photographs_of(tmp_path, print)
    (tmp_path / '100MEDIA').mkdir()
    (tmp_path / '100MEDIA' / 'DJI_0001.JPG').touch()
    with pytest.raises(MappingError, match=r'folders that have some: 100MEDIA; name one of them'):
        photographs_of(tmp_path, print)
