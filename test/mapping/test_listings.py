# SPDX-License-Identifier: Apache-2.0
"""The folder of a store opens in other people's programs."""

import csv
import dataclasses
import hashlib
import itertools
import json
import math
import re
import sqlite3

import pytest

from rocsafe_geo.pinhole import (
    quaternion_of_rotation,
    rotation_enu_from_optical,
    rotation_of_quaternion,
)
from rocsafe_mapping.command_line.import_command import (
    EXIT_OK,
    EXIT_REFUSED,
    EXIT_SOME_REFUSED,
    main,
)
from rocsafe_mapping.photographs.exif import with_exif
from rocsafe_mapping.store.catalogue import StoredShot, read_store
from rocsafe_mapping.store.listings import write_listings
from rocsafe_mapping.store.photograph_files import photographs_of
from rocsafe_mapping.store.store import ImageStore
from rocsafe_mapping.store.store_index import INDEX, write_index

YAW, PITCH, ROLL = 0.7, 0.03, -0.05


@pytest.fixture
def tilted(shot):
    """A photograph of a tilted camera."""
    rotation = rotation_enu_from_optical(YAW, PITCH, ROLL)
    orientation = tuple(quaternion_of_rotation(rotation).tolist())
    return lambda number=0: shot(number, orientation_xyzw=orientation)


@pytest.fixture
def folder(tmp_path, tilted):
    """A store of three photographs with its lists."""
    store = ImageStore(tmp_path / 'images', reserve_bytes=0)
    for number in range(3):
        store.put(*tilted(number))
    store.close()
    shots = read_store(tmp_path / 'images', pytest.fail)
    write_listings(tmp_path / 'images', shots)
    write_index(tmp_path / 'images', shots)
    return tmp_path / 'images'


def test_geo_txt_is_as_opendronemap_reads_it(folder):
    """CRS, then name, longitude, latitude, altitude, yaw, pitch, roll, accuracies."""
    lines = (folder / 'geo.txt').read_text().splitlines()
    assert lines[0] == 'EPSG:4326'
    words = lines[1].split()
    assert (words[0], len(words)) == ('rav1-00000.jpg', 9)
    numbers = [float(word) for word in words[1:]]
    assert numbers[:3] == pytest.approx([-9.0633, 53.2838, 92.5])
    heading = (90.0 - math.degrees(YAW)) % 360.0
    assert numbers[3:6] == pytest.approx(
        [heading, -math.degrees(PITCH), math.degrees(ROLL)], abs=1e-3
    )
    assert numbers[6:] == pytest.approx([1.5, 2.0])


def test_cameras_are_as_opendronemap_reads_them(folder):
    """Focal length and principal point over the longer side."""
    ((name, camera),) = json.loads((folder / 'cameras.json').read_text()).items()
    assert name == 'v2 rocsafe rocsafe nadir camera 64 48 brown 0.8594'
    assert camera['focal_x'] == pytest.approx(55.0 / 64.0)
    assert (camera['c_x'], camera['c_y']) == (0.0, 0.0)
    assert camera['projection_type'] == 'brown'


def test_images_csv_has_a_row_for_each_photograph(folder):
    """With the columns named."""
    with (folder / 'images.csv').open(newline='') as file:
        rows = list(csv.DictReader(file))
    assert [row['image'] for row in rows] == [f'rav1-0000{n}.jpg' for n in range(3)]
    assert float(rows[0]['latitude_deg']) == 53.2838
    assert rows[0]['time_utc'] == '2023-11-14T22:13:20.123Z'


def test_footprints_are_anticlockwise_rings(folder):
    """RFC 7946: closed, longitude first, exterior anticlockwise."""
    document = json.loads((folder / 'footprints.geojson').read_text())
    ring = document['features'][0]['geometry']['coordinates'][0]
    assert ring[0] == ring[-1]
    area = sum(a[0] * b[1] - b[0] * a[1] for a, b in itertools.pairwise(ring))
    assert area > 0.0
    assert ring[0] == pytest.approx([-9.0633, 53.2838], abs=1e-3)


def test_stac_links_hold(folder):
    """The collection names its items, they name existing files."""
    collection = json.loads((folder / 'collection.json').read_text())
    assert (collection['type'], collection['stac_version']) == ('Collection', '1.0.0')
    links = [link['href'] for link in collection['links'] if link['rel'] == 'item']
    assert len(links) == 3
    for link in links:
        path = folder / link
        item = json.loads(path.read_text())
        assert item['stac_version'] == '1.0.0'
        west, south, east, north = item['bbox']
        assert west < -9.0633 < east
        assert south < 53.2838 < north
        for asset in item['assets'].values():
            assert (path.parent / asset['href']).resolve().exists()
        image = item['assets']['image']
        content = (path.parent / image['href']).read_bytes()
        assert image['file:size'] == len(content)
        # A multihash: code and length of SHA-256 before its digest.
        assert image['file:checksum'] == '1220' + hashlib.sha256(content).hexdigest()


# What the JSON schemas of STAC 1.0.0 and of its extensions file 2.1.0 and view 1.0.0 demand.
STAC_ITEM = {
    'stac_version', 'id', 'type', 'geometry', 'properties', 'links', 'assets',
}  # fmt: skip
STAC_COLLECTION = {
    'stac_version', 'id', 'type', 'description', 'license', 'extent', 'links',
}  # fmt: skip
RFC_3339 = re.compile(r'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?Z')


@pytest.mark.parametrize('has_fix', [True, False])
def test_stac_has_what_its_schemas_demand(tmp_path, shot, has_fix):
    """Required fields and their forms, also of a photograph whose place is not known."""
    record, _ = shot(**({} if has_fix else {'latitude_deg': math.nan, 'longitude_deg': math.nan}))
    stored = StoredShot(
        record=record, path=tmp_path / 'rav1-00000.jpg', sha256='ab' * 32, size_bytes=7
    )
    write_listings(tmp_path, [stored])
    collection = json.loads((tmp_path / 'collection.json').read_text())
    item = json.loads((tmp_path / 'items' / 'rav1-00000.json').read_text())
    assert collection.keys() >= STAC_COLLECTION
    assert re.fullmatch(r'[\w.+-]+', collection['license'])
    assert len(collection['extent']['spatial']['bbox'][0]) == 4
    times = collection['extent']['temporal']['interval'][0]
    assert all(RFC_3339.fullmatch(time) for time in [*times, item['properties']['datetime']])
    assert item.keys() >= STAC_ITEM
    assert item['type'] == 'Feature'
    assert ('bbox' in item) == (item['geometry'] is not None) == has_fix
    # An item names its collection both by a field and by a link.
    assert item['collection'] == collection['id']
    assert {'collection', 'root'} <= {link['rel'] for link in item['links']}
    assert all(link['href'] for link in item['links'] + collection['links'])
    assert all(asset['href'] for asset in item['assets'].values())
    assert {url.split('/')[3] for url in item['stac_extensions']} == {'file', 'view'}
    assert 0 <= item['properties']['view:off_nadir'] <= 90
    image = item['assets']['image']
    assert re.fullmatch('1220[a-f0-9]{64}', image['file:checksum'])
    assert image['file:size'] == 7


def test_index_can_be_asked_and_made_again(folder):
    """From the files alone, also when it is damaged."""
    shots = read_store(folder, pytest.fail)
    query = 'SELECT COUNT(*) FROM photographs WHERE vehicle = ? AND latitude_deg > 53'
    for damage in (None, b'no database at all'):
        if damage is not None:
            (folder / INDEX).write_bytes(damage)
            write_index(folder, shots)
        with sqlite3.connect(folder / INDEX) as table:
            assert table.execute(query, ('rav1',)).fetchone() == (3,)


def test_xmp_brings_back_the_pose(tmp_path, tilted):
    """What is read from a tagged photograph is the pose that was written, to a thousandth."""
    record, jpeg = tilted()
    (tmp_path / 'a.jpg').write_bytes(with_exif(jpeg, record))
    (shot,) = photographs_of(tmp_path, pytest.fail)
    read = shot.record
    assert (read.latitude_deg, read.longitude_deg) == pytest.approx((53.2838, -9.0633), abs=1e-9)
    assert (read.altitude_m, read.height_agl_m) == (92.5, 32.5)
    assert rotation_of_quaternion(read.orientation_xyzw) == pytest.approx(
        rotation_of_quaternion(record.orientation_xyzw), abs=1e-4
    )
    assert read.camera == dataclasses.replace(record.camera)
    assert read.position_covariance_m2[0] == pytest.approx(2.25, rel=1e-3)


def test_import_takes_photographs_once(tmp_path, tilted, capsys):
    """Their own bytes; again, or under another name, they are there already."""
    source = tmp_path / 'card'
    source.mkdir()
    for number in range(2):
        record, jpeg = tilted(number)
        (source / f'DJI_{number:04d}.JPG').write_bytes(with_exif(jpeg, record))
    assert main([str(source), str(tmp_path / 'store')]) == EXIT_OK
    (source / 'DJI_0000.JPG').rename(source / 'renamed.JPG')
    record, jpeg = tilted(7)
    (source / 'DJI_0007.JPG').write_bytes(with_exif(jpeg, record))
    assert main([str(source), str(tmp_path / 'store')]) == EXIT_OK
    out = capsys.readouterr().out
    assert '2 stored, 0 there already' in out
    assert '1 stored, 2 there already' in out
    shots = read_store(tmp_path / 'store', pytest.fail)
    originals = {path.read_bytes() for path in source.iterdir()}
    assert {shot.read_image() for shot in shots} == originals
    assert (tmp_path / 'store' / 'geo.txt').exists()


def test_import_names_what_it_refuses(tmp_path, tilted, capsys):
    """A broken file is told, the others are taken."""
    source = tmp_path / 'card'
    source.mkdir()
    record, jpeg = tilted()
    (source / 'good.jpg').write_bytes(with_exif(jpeg, record))
    (source / 'torn.jpg').write_bytes(with_exif(jpeg, record)[:-200])
    assert main([str(source), str(tmp_path / 'store')]) == EXIT_SOME_REFUSED
    captured = capsys.readouterr()
    assert '1 stored, 0 there already, 1 refused' in captured.out
    assert 'torn.jpg' in captured.err
    assert main([str(tmp_path / 'missing'), str(tmp_path / 'store')]) == EXIT_REFUSED


def shot_of(record, path) -> StoredShot:
    """Return a stored photograph."""
    return StoredShot(record=record, path=path)


def test_photographs_without_a_fix_are_listed_all_the_same(tmp_path, shot):
    """With empty cells, without a footprint and without a line for OpenDroneMap."""
    record, _ = shot(latitude_deg=math.nan, longitude_deg=math.nan)
    write_listings(tmp_path, [shot_of(record, tmp_path / 'rav1-00000.jpg')])
    assert (tmp_path / 'geo.txt').read_text() == 'EPSG:4326\n'
    assert ',,' in (tmp_path / 'images.csv').read_text()
    assert json.loads((tmp_path / 'footprints.geojson').read_text())['features'] == []
