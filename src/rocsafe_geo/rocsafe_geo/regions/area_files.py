# SPDX-License-Identifier: Apache-2.0
"""Survey areas from GeoJSON (RFC 7946), KML 2.2, KMZ, QGroundControl plans and CSV tables."""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import Ring, SurveyArea
from rocsafe_geo.regions.area_sources import csv_ring, kml_of_kmz, plan_rings
from rocsafe_geo.storage.named_file import require_file

MAX_FILE_BYTES = 10_000_000
"""A larger file is not a survey region drawn by hand."""

MAX_AREAS = 1000
"""More polygons are not regions drawn by hand."""

_WGS84_NAMES = ('CRS84', 'EPSG::4326', 'EPSG:4326')

# GeoJSON objects that hold others, and under which key.
_MEMBERS = {'FeatureCollection': 'features', 'GeometryCollection': 'geometries'}

# One polygon of a file: its rings, outer one first, and the name given to it.
_NamedRings = tuple[list[Ring], str]


def read_area(path: str | Path) -> SurveyArea:
    """Return the one polygon of a `.geojson`, `.json`, `.kml`, `.kmz`, `.plan` or `.csv` file.

    Raises
    ------
    ValueError
        One line that starts with the path: unreadable file, unknown kind, not exactly one polygon,
        wrong coordinates, or whatever `SurveyArea` refuses.
    """
    return _areas(Path(path), most=1)[0]


def read_areas(path: str | Path) -> tuple[SurveyArea, ...]:
    """Return all polygons of such a file, at least one and at most `MAX_AREAS`.

    Polygons without a name get that of the file, with a number from the second one on.

    Raises
    ------
    ValueError
        As `read_area` does.
    """
    return _areas(Path(path), most=MAX_AREAS)


def areas_of_kind(path: str | Path, kind: str) -> tuple[SurveyArea, ...]:
    """Return the polygons of a GeoJSON file of ROCSAFE whose property `kind` is this.

    Raises
    ------
    ValueError
        One line that starts with the path, if the file cannot be read or is no GeoJSON.
    """
    file = Path(path)
    try:
        require_file(file)
        features = json.loads(file.read_text(encoding='utf-8'))['features']
        chosen = [one for one in features if one['properties'].get('kind') == kind]
        polygons = list(_polygons_in({'type': 'FeatureCollection', 'features': chosen}, kind))
        return tuple(_numbered(file, polygons, number) for number in range(1, len(polygons) + 1))
    except (OSError, LookupError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(f'{file}: cannot be read as GeoJSON of ROCSAFE: {error}') from error


def _areas(file: Path, most: int) -> tuple[SurveyArea, ...]:
    try:
        polygons = _reader_of(file)(_text_of(file))
        if not 1 <= len(polygons) <= most:
            limit = 'exactly 1' if most == 1 else f'1 to {most}'
            raise ValueError(f'has {len(polygons)} polygons: must have {limit}')  # noqa: TRY301
        return tuple(_numbered(file, polygons, number) for number in range(1, len(polygons) + 1))
    except (ValueError, RecursionError) as error:
        reason = 'is nested too deeply' if isinstance(error, RecursionError) else error
        raise ValueError(f'{file}: {reason}') from error


def _numbered(file: Path, polygons: list[_NamedRings], number: int) -> SurveyArea:
    """Return one polygon of a file, the first of which has the number 1."""
    rings, name = polygons[number - 1]
    which = f'polygon {number}: ' if len(polygons) > 1 else ''
    if not rings:
        raise ValueError(f'{which}has a polygon without coordinates')
    try:
        return SurveyArea(
            rings[0], tuple(rings[1:]), name or file.stem + (f' {number}' if number > 1 else '')
        )
    except ValueError as error:
        raise ValueError(f'{which}{error}') from error


def _reader_of(file: Path) -> Callable[[str], list[_NamedRings]]:
    """Return the reader for the file's extension."""
    readers: dict[str, Callable[[str], list[_NamedRings]]] = {
        '.geojson': _geojson_polygons,
        '.json': _geojson_polygons,
        '.kml': _kml_polygons,
        '.kmz': _kml_polygons,
        '.plan': lambda text: [([ring], '') for ring in plan_rings(text)],
        '.csv': lambda text: [([csv_ring(text)], '')],
    }
    reader = readers.get(file.suffix.lower())
    if reader is None:
        raise ValueError(
            f'is a {file.suffix or "nameless"} file: must be one of {", ".join(readers)}'
        )
    return reader


def _text_of(file: Path) -> str:
    """Return the file's text; UTF-8 only, so that no other encoding hides a document type."""
    try:
        require_file(file)
        with file.open('rb') as stream:
            content = stream.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise ValueError(f'cannot be read: {error.strerror or error}') from error
    if len(content) > MAX_FILE_BYTES:
        raise ValueError(f'is larger than {MAX_FILE_BYTES} bytes, the limit')
    if file.suffix.lower() == '.kmz':
        content = kml_of_kmz(content, MAX_FILE_BYTES)
    try:
        return content.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        raise ValueError(f'is not UTF-8 text: byte {error.start} is wrong') from error


def _geojson_polygons(text: str) -> list[_NamedRings]:
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f'is not JSON: {error.msg} in line {error.lineno}') from error
    _check_reference_system(document)
    return list(_polygons_in(document, ''))


def _check_reference_system(document: object) -> None:
    """Refuse the `crs` of old GeoJSON unless it means WGS84."""
    if isinstance(document, dict) and document.get('crs') is not None:
        crs = json.dumps(document['crs'])
        if not any(name in crs for name in _WGS84_NAMES):
            raise ValueError(f'has coordinates in {crs[:120]}: must be WGS84 (RFC 7946)')


def _polygons_in(item: object, name: str) -> Iterator[_NamedRings]:
    """Yield the polygons in a GeoJSON object of any type; other geometries have none."""
    if not isinstance(item, Mapping) or not isinstance(item.get('type'), str):
        raise ValueError('is not GeoJSON: an object without "type"')  # noqa: TRY004
    kind = item['type']
    if kind in _MEMBERS:
        for part in _list(item, _MEMBERS[kind]):
            yield from _polygons_in(part, str(item.get('name') or name))
    elif kind == 'Feature' and item.get('geometry') is not None:
        properties = item.get('properties')
        own_name = properties.get('name') if isinstance(properties, Mapping) else None
        yield from _polygons_in(item['geometry'], str(own_name or name))
    elif kind == 'MultiPolygon':
        for rings in _list(item, 'coordinates'):
            yield _rings(rings), name
    elif kind == 'Polygon':
        yield _rings(_list(item, 'coordinates')), name


def _list(item: Mapping[str, Any], key: str) -> list[Any]:
    value = item.get(key)
    if not isinstance(value, list):
        raise ValueError(f'has a {item["type"]} without the list "{key}"')  # noqa: TRY004
    return value


def _rings(rings: object) -> list[Ring]:
    """Return the rings of GeoJSON polygon coordinates."""
    if not isinstance(rings, list) or not all(isinstance(ring, list) for ring in rings):
        raise ValueError('has a polygon whose coordinates are not lists of positions')
    return [tuple(_position(position) for position in ring) for ring in rings]


def _position(position: object) -> GeoPosition:
    """Return the position of one [longitude, latitude, ...]."""
    if not isinstance(position, list) or len(position) < 2:
        raise ValueError(f'has {_short(position)} where [longitude, latitude] must be')
    return _geo_position(position)


def _geo_position(values: Sequence[Any]) -> GeoPosition:
    try:
        return GeoPosition(values[1], values[0])
    except ValueError as error:
        hint = _hint(values[0])
        raise ValueError(f'has the position {_short(list(values))}: {error} ({hint})') from error


def _hint(longitude: object) -> str:
    """Return what is probably wrong with a position of this longitude."""
    if isinstance(longitude, int | float) and 180.0 < abs(longitude) <= 540.0:
        return 'a region must not cross the antimeridian, 180 deg: divide it there'
    return 'longitude comes first'


def _kml_polygons(text: str) -> list[_NamedRings]:
    # Entity attacks need a document type, and KML has none.
    if '<!DOCTYPE' in text or '<!ENTITY' in text:
        raise ValueError('declares a document type or entities, which a KML file must not')
    try:
        root = ElementTree.fromstring(text)  # noqa: S314 (no entities: refused above)
    except ElementTree.ParseError as error:
        raise ValueError(f'is not XML: {error}') from error
    if _tag(root) != 'kml':
        raise ValueError(f'is not KML: its root is <{_tag(root)}>')
    placed = [
        (polygon, placemark)
        for placemark in _descendants(root, 'Placemark')
        for polygon in _descendants(placemark, 'Polygon')
    ]
    return [(_kml_rings(polygon), _child_text(mark, 'name')) for polygon, mark in placed]


def _kml_rings(polygon: ElementTree.Element) -> list[Ring]:
    """Return outer ring, then inner ones, whatever their order in the file."""
    outer, inner = (
        [
            ring
            for boundary in polygon
            if _tag(boundary) == side
            for ring in _descendants(boundary, 'LinearRing')
        ]
        for side in ('outerBoundaryIs', 'innerBoundaryIs')
    )
    if len(outer) != 1:
        raise ValueError(f'has a Polygon with {len(outer)} outer rings: must have exactly 1')
    return [_kml_ring(_child_text(ring, 'coordinates')) for ring in outer + inner]


def _kml_ring(coordinates: str) -> Ring:
    """Return the ring of 'longitude,latitude[,altitude] ...'; blanks at commas are accepted."""
    tuples = re.sub(r'\s*,\s*', ',', coordinates).split()
    for item in tuples:
        if item.count(',') not in (1, 2):
            raise ValueError(f'has {_short(item)} where longitude,latitude must be')
    return tuple(_geo_position([_float(part) for part in item.split(',')]) for item in tuples)


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise ValueError(f'has {_short(text)} where a number must be') from error


def _descendants(element: ElementTree.Element, tag: str) -> list[ElementTree.Element]:
    return [child for child in element.iter() if _tag(child) == tag]


def _child_text(element: ElementTree.Element, tag: str) -> str:
    return next(((child.text or '').strip() for child in element if _tag(child) == tag), '')


def _tag(element: ElementTree.Element) -> str:
    """Return the tag without its namespace: files use KML 2.0 to 2.3, Google's, or none."""
    return str(element.tag).rpartition('}')[2]


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + '...'
