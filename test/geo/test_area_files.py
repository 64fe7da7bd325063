# SPDX-License-Identifier: Apache-2.0
"""Areas from files people really have, and from files that attack."""

import json
import re
import zipfile

import pytest

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area_files import read_area, read_areas

OUTER = [[-9.062, 53.279], [-9.056, 53.279], [-9.056, 53.283], [-9.062, 53.283], [-9.062, 53.279]]
INNER = [[-9.060, 53.280], [-9.058, 53.280], [-9.058, 53.281], [-9.060, 53.280]]
POLYGON = {'type': 'Polygon', 'coordinates': [OUTER, INNER]}
FEATURE = {'type': 'Feature', 'properties': {'name': 'yard'}, 'geometry': POLYGON}
POINT = {
    'type': 'Feature',
    'properties': None,
    'geometry': {'type': 'Point', 'coordinates': [0, 0]},
}


def write(tmp_path, content, name='region.geojson'):
    """Write a text or a JSON value and return the path."""
    path = tmp_path / name
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def kml(inner='', opening='<kml xmlns="http://www.opengis.net/kml/2.2">', prolog=''):
    """Return a KML text with OUTER as its polygon."""
    outer = '\n'.join(f'{lon},{lat},0' for lon, lat in OUTER)
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>{prolog}{opening}<Document><name>doc</name>'
        '<Folder><Placemark><name>yard</name><Polygon>'
        f'{inner}<outerBoundaryIs><LinearRing><coordinates>{outer}</coordinates></LinearRing>'
        '</outerBoundaryIs></Polygon></Placemark></Folder></Document></kml>'
    )


HOLE = (
    '<innerBoundaryIs><LinearRing><coordinates>'
    + ' '.join(f'{lon}, {lat}' for lon, lat in INNER)
    + '</coordinates></LinearRing></innerBoundaryIs>'
)


@pytest.mark.parametrize(
    ('document', 'name'),
    [
        (POLYGON, 'region'),
        (FEATURE, 'yard'),
        ({'type': 'FeatureCollection', 'features': [POINT, FEATURE]}, 'yard'),
        (
            {
                'type': 'FeatureCollection',
                'name': 'site',
                'features': [{'type': 'Feature', 'properties': {}, 'geometry': POLYGON}],
            },
            'site',
        ),
        ({'type': 'MultiPolygon', 'coordinates': [[OUTER, INNER]]}, 'region'),
        ({'type': 'GeometryCollection', 'geometries': [POLYGON]}, 'region'),
        (
            {
                **POLYGON,
                'crs': {'type': 'name', 'properties': {'name': 'urn:ogc:def:crs:OGC:1.3:CRS84'}},
            },
            'region',
        ),
    ],
)
def test_geojson_in_every_wrapping(tmp_path, document, name):
    """The polygon and its hole are found, longitude first; the name is the nearest one."""
    area = read_area(write(tmp_path, document))
    assert area.boundary == tuple(GeoPosition(lat, lon) for lon, lat in OUTER[:-1])
    assert area.holes == (tuple(GeoPosition(lat, lon) for lon, lat in INNER[:-1]),)
    assert area.name == name


@pytest.mark.parametrize(
    'opening',
    [
        '<kml xmlns="http://www.opengis.net/kml/2.2">',
        '<kml>',
        '<kml xmlns="http://earth.google.com/kml/2.1">',
        '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">',
    ],
)
@pytest.mark.parametrize('inner', ['', HOLE])
def test_kml_of_every_namespace(tmp_path, opening, inner):
    """Namespaces differ from program to program; a hole may stand before the outer ring."""
    area = read_area(write(tmp_path, kml(inner, opening), 'region.KML'))
    assert area.boundary == tuple(GeoPosition(lat, lon) for lon, lat in OUTER[:-1])
    assert len(area.holes) == (1 if inner else 0)
    assert area.name == 'yard'


def test_kml_with_a_prefixed_namespace(tmp_path):
    """A file may prefix every tag."""
    text = kml(opening='<kml>').replace('</', '\0').replace('<', '<k:').replace('\0', '</k:')
    text = text.replace('<k:?', '<?').replace(
        '<k:kml>', '<k:kml xmlns:k="http://www.opengis.net/kml/2.2">'
    )
    assert len(read_area(write(tmp_path, text, 'region.kml')).boundary) == 4


LAUGHS = '<!DOCTYPE kml [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;">]>'
FILE_THEFT = '<!DOCTYPE kml [<!ENTITY a SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize(
    ('name', 'content', 'message'),
    [
        ('a.shp', '', r'is a \.shp file: must be one of \.geojson, \.json, \.kml'),
        ('a.kmz', '', 'is not a KMZ archive: File is not a zip file'),
        ('a.json', '{', 'is not JSON: Expecting .* in line 1'),
        ('a.json', '[' * 100_000, 'nested too deeply|is not JSON'),
        ('a.json', [1], 'without "type"'),
        ('a.json', {'type': 'Polygon'}, 'Polygon without the list "coordinates"'),
        ('a.json', {'type': 'Polygon', 'coordinates': []}, 'without coordinates'),
        (
            'a.json',
            {'type': 'Polygon', 'coordinates': [[[1]]]},
            'where .longitude, latitude. must',
        ),
        ('a.json', {'type': 'Polygon', 'coordinates': [[['1', '2']]]}, 'must be a number'),
        ('a.json', '{"type": "Polygon", "coordinates": [[[NaN, 1]]]}', 'longitude_deg is nan'),
        ('a.json', {'type': 'Polygon', 'coordinates': [[[53.0, -99.0]]]}, 'longitude comes first'),
        ('a.json', {'type': 'Polygon', 'coordinates': [[[180.1, 1.0]]]}, 'cross the antimeridian'),
        ('a.json', {'type': 'MultiPolygon', 'coordinates': [[OUTER], [INNER]]}, 'has 2 polygons'),
        ('a.json', {'type': 'FeatureCollection', 'features': [POINT]}, 'has 0 polygons'),
        ('a.json', {**POLYGON, 'crs': {'properties': {'name': 'EPSG:2157'}}}, 'must be WGS84'),
        ('a.kml', '<kml', 'is not XML'),
        ('a.kml', '<gpx/>', 'its root is <gpx>'),
        ('a.kml', '<kml/>', 'has 0 polygons'),
        ('a.kml', '<kml><Placemark><Polygon/></Placemark></kml>', '0 outer rings'),
        ('a.kml', kml().replace(',53.279,0', ''), 'where longitude,latitude must be'),
        ('a.kml', kml().replace('53.279', 'north'), "has 'north' where a number must be"),
        ('a.kml', kml(prolog=LAUGHS), 'document type or entities'),
        ('a.kml', kml(prolog=FILE_THEFT), 'document type or entities'),
    ],
)
def test_bad_files_give_one_line(tmp_path, name, content, message):
    """One line: path, what is wrong, what must be."""
    path = write(tmp_path, content, name)
    with pytest.raises(ValueError, match=message) as refusal:
        read_area(path)
    assert str(refusal.value).startswith(str(path))
    assert '\n' not in str(refusal.value)


def test_unreadable_files_give_one_line(tmp_path):
    """A missing file, a folder, bytes that are no text and a file too large are refused."""
    binary = tmp_path / 'a.json'
    binary.write_bytes('<?xml version="1.0"?>'.encode('utf-16'))
    large = tmp_path / 'b.json'
    large.write_bytes(b' ' * 10_000_001)
    folder = tmp_path / 'c.json'
    folder.mkdir()
    for path, message in (
        (tmp_path / 'none.json', 'No such file'),
        (binary, 'not UTF-8'),
        (large, 'larger than'),
        (folder, 'cannot be read'),
    ):
        with pytest.raises(ValueError, match=message):
            read_area(path)


def test_kmz_is_unpacked(tmp_path):
    """The document inside an archive is read like a KML file."""
    path = tmp_path / 'yard.kmz'
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as archive:
        archive.writestr('doc.kml', kml(HOLE))
    assert read_area(path).name == 'yard'
    assert len(read_area(path).holes) == 1


def test_a_bomb_is_not_unpacked(tmp_path):
    """What would unpack to more than the limit is refused."""
    path = tmp_path / 'bomb.kmz'
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as archive:
        archive.writestr('doc.kml', ' ' * 20_000_000)
    with pytest.raises(ValueError, match='has a document larger than 10000000 bytes'):
        read_area(path)


PLACES = [[lat, lon] for lon, lat in OUTER[:-1]]


def test_surveys_of_qgroundcontrol(tmp_path):
    """The polygon of a plan's survey is the area; simple items are not looked at."""
    survey = {'type': 'ComplexItem', 'complexItemType': 'survey', 'polygon': PLACES}
    plan = {'fileType': 'Plan', 'mission': {'items': [{'type': 'SimpleItem'}, survey]}}
    area = read_area(write(tmp_path, plan, 'yard.plan'))
    assert [[c.latitude_deg, c.longitude_deg] for c in area.boundary] == PLACES


@pytest.mark.parametrize(
    'text',
    [
        '\n'.join(f'{lat},{lon}' for lat, lon in PLACES),
        '# yard\n\nlon;name;lat\n' + '\n'.join(f'{lon};a;{lat}' for lat, lon in PLACES),
        'Latitude\tLongitude\n' + '\n'.join(f'{lat}\t{lon}' for lat, lon in PLACES),
    ],
)
def test_tables_of_corners(tmp_path, text):
    """With or without a header, whatever separates the columns."""
    area = read_area(write(tmp_path, text, 'yard.csv'))
    assert [[c.latitude_deg, c.longitude_deg] for c in area.boundary] == PLACES


@pytest.mark.parametrize(
    ('name', 'content', 'message'),
    [
        ('a.csv', '', 'has no lines'),
        ('a.csv', '53,9\n53\n', 'has 1 columns in line 2: must have 2'),
        ('a.csv', '53,9\n53,x\n', "line 2: could not convert string to float: 'x'"),
        ('a.csv', '53,9\n99,9\n', 'line 2: latitude_deg is 99: must be -90 to 90'),
        ('a.plan', '{', 'is not JSON'),
        ('a.plan', '{}', 'is not a QGroundControl plan'),
        ('a.plan', '{"fileType": "Plan"}', 'is a plan without the list "mission.items"'),
        ('a.plan', '{"fileType": "Plan", "mission": {"items": []}}', 'has 0 polygons'),
        (
            'a.plan',
            json.dumps(
                {
                    'fileType': 'Plan',
                    'mission': {'items': [{'type': 'ComplexItem', 'polygon': [3]}]},
                }
            ),
            'has 3 where [latitude, longitude] must be',
        ),
    ],
)
def test_broken_files_of_others_give_one_line(tmp_path, name, content, message):
    """The line begins with the path and says what is wrong."""
    path = write(tmp_path, content, name)
    with pytest.raises(ValueError, match=re.escape(message)) as caught:
        read_area(path)
    assert str(caught.value).startswith(f'{path}: ')
    assert '\n' not in str(caught.value)


def test_several_polygons_of_a_file(tmp_path):
    """All are read, those without a name after the file; one polygon is several of one."""
    path = tmp_path / 'fields.json'
    named = {
        'type': 'Feature',
        'properties': {'name': 'north'},
        'geometry': {'type': 'Polygon', 'coordinates': [OUTER]},
    }
    shapes = {'type': 'MultiPolygon', 'coordinates': [[OUTER], [INNER]]}
    features = [{'type': 'Feature', 'properties': {}, 'geometry': shapes}, named]
    path.write_text(json.dumps({'type': 'FeatureCollection', 'features': features}))
    assert [area.name for area in read_areas(path)] == ['fields', 'fields 2', 'north']
    path.write_text(json.dumps(named))
    assert read_areas(path) == (read_area(path),)
    path.write_text(json.dumps(POINT))
    with pytest.raises(ValueError, match='has 0 polygons: must have 1 to 1000'):
        read_areas(path)
