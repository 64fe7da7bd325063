# SPDX-License-Identifier: Apache-2.0
"""The picture as GeoJSON, in the collections of OGC API - Features (OGC 17-069r4)."""

import math
from collections.abc import Callable, Iterator, Mapping
from datetime import datetime, timezone
from typing import Any
from urllib.parse import urlencode

from rocsafe_console.picture.freshness import STALE_S
from rocsafe_console.picture.picture import Picture

Feature = dict[str, Any]
CONFORMANCE = (
    'http://www.opengis.net/spec/ogcapi-features-1/1.0/conf/core',
    'http://www.opengis.net/spec/ogcapi-features-1/1.0/conf/geojson',
)
GEOJSON = 'application/geo+json'
OPENAPI = 'application/vnd.oai.openapi+json;version=3.0'
MOST_ITEMS = 10_000


def landing_of(base: str) -> dict[str, Any]:
    """Return the landing page; `base` is its address without a slash at the end."""
    return {
        'title': 'ROCSAFE',
        'description': 'The mission as it is now; WGS84 longitude and latitude.',
        'links': [
            _link(base, 'self', 'application/json'),
            _link(f'{base}/api', 'service-desc', OPENAPI),
            _link(f'{base}/conformance', 'conformance', 'application/json'),
            _link(f'{base}/collections', 'data', 'application/json'),
        ],
    }


def collections_of(base: str) -> dict[str, Any]:
    """Return the list of collections."""
    return {
        'links': [_link(f'{base}/collections', 'self', 'application/json')],
        'collections': [collection_of(base, name) for name in COLLECTIONS],
    }


def collection_of(base: str, name: str) -> dict[str, Any]:
    """Return one collection; raises `KeyError` if there is none of this name."""
    title, _ = COLLECTIONS[name]
    return {
        'id': name,
        'title': title,
        'itemType': 'feature',
        'crs': ['http://www.opengis.net/def/crs/OGC/1.3/CRS84'],
        'links': [_link(f'{base}/collections/{name}/items', 'items', GEOJSON)],
    }


def items_of(
    base: str, name: str, picture: Picture, now_s: float, query: Mapping[str, str]
) -> dict[str, Any]:
    """Return the features of a collection as it is now.

    Parameters
    ----------
    query
        ``limit`` and ``offset``, ``bbox`` (west, south, east, north); ``datetime`` selects
        nothing, because all is as it is now.

    Raises
    ------
    KeyError
        If there is no collection of this name.
    ValueError
        If the query makes no sense.
    """
    limit, offset = int(query.get('limit', MOST_ITEMS)), int(query.get('offset', 0))
    if limit < 1 or offset < 0:
        raise ValueError(f'limit = {limit}, offset = {offset}: must be 1 and 0 at least')
    limit = min(limit, MOST_ITEMS)
    features = _features(name, picture, now_s)
    if 'bbox' in query:
        box = _box_of(query['bbox'])
        features = [one for one in features if _is_in(box, one['geometry']['coordinates'])]
    items = f'{base}/collections/{name}/items'
    links = [_link(items, 'self', GEOJSON)]
    if offset + limit < len(features):
        rest = urlencode({**query, 'limit': limit, 'offset': offset + limit})
        links.append(_link(f'{items}?{rest}', 'next', GEOJSON))
    found = features[offset : offset + limit]
    return {
        'type': 'FeatureCollection',
        'features': found,
        'numberMatched': len(features),
        'numberReturned': len(found),
        'timeStamp': _time_text(now_s),
        'links': links,
    }


def item_of(base: str, name: str, picture: Picture, now_s: float, number: int) -> dict[str, Any]:
    """Return one feature of a collection; raises `KeyError` if there is none of this number."""
    found = [one for one in _features(name, picture, now_s) if one['id'] == number]
    if not found:
        raise KeyError(f'feature {number} of {name}: there is none')
    collection = f'{base}/collections/{name}'
    links = [
        _link(f'{collection}/items/{number}', 'self', GEOJSON),
        _link(collection, 'collection', 'application/json'),
    ]
    return {**found[0], 'links': links}


def definition_of(base: str) -> dict[str, Any]:
    """Return the definition of the interface (OpenAPI 3.0)."""
    answer = {'200': {'description': 'as in OGC 17-069r4'}}
    name = {'name': 'name', 'in': 'path', 'required': True, 'schema': {'type': 'string'}}
    number = {**name, 'name': 'number', 'schema': {'type': 'integer'}}
    asked = [
        {'name': key, 'in': 'query', 'schema': {'type': kind}}
        for key, kind in (
            ('limit', 'integer'),
            ('offset', 'integer'),
            ('bbox', 'string'),
            ('datetime', 'string'),
        )
    ]
    collection = '/collections/{name}'
    paths = {
        '/': [], '/conformance': [], '/collections': [], collection: [name],
        f'{collection}/items': [name, *asked], f'{collection}/items/{{number}}': [name, number],
    }  # fmt: skip
    return {
        'openapi': '3.0.3',
        'info': {'title': 'ROCSAFE', 'version': '1.0'},
        'servers': [{'url': base}],
        'paths': {
            path: {'get': {'parameters': parameters, 'responses': answer}}
            for path, parameters in paths.items()
        },
    }


def _features(name: str, picture: Picture, now_s: float) -> list[Feature]:
    """Return the features of a collection whose places are all known."""
    _, make = COLLECTIONS[name]
    return [
        {'type': 'Feature', 'id': number, **one}
        for number, one in enumerate(make(picture, now_s), 1)
        if not any(None in place for place in _places_of(one['geometry']['coordinates']))
    ]


def _box_of(text: str) -> tuple[float, float, float, float]:
    """Return west, south, east, north of a box of four numbers, or of six with heights."""
    numbers = [float(part) for part in text.split(',')]
    if len(numbers) not in (4, 6) or not all(map(math.isfinite, numbers)):
        raise ValueError(f'bbox = {text[:80]}: must be west,south,east,north')
    west, south, *_, east, north = numbers if len(numbers) == 4 else (*numbers[:2], *numbers[3:5])
    return west, south, east, north


def _is_in(box: tuple[float, float, float, float], coordinates: list[Any]) -> bool:
    """Return whether a geometry meets a box; across 180 degrees, west is above east."""
    west, south, east, north = box
    places = list(_places_of(coordinates))
    longitudes, latitudes = [place[0] for place in places], [place[1] for place in places]
    if not places or min(latitudes) > north or max(latitudes) < south:
        return False
    if west > east:
        return max(longitudes) >= west or min(longitudes) <= east
    return max(longitudes) >= west and min(longitudes) <= east


def _places_of(coordinates: list[Any]) -> Iterator[list[float]]:
    if coordinates and isinstance(coordinates[0], list):
        for part in coordinates:
            yield from _places_of(part)
    elif coordinates:
        yield coordinates


def _time_text(seconds: float) -> str:
    return f'{datetime.fromtimestamp(seconds, tz=timezone.utc):%Y-%m-%dT%H:%M:%SZ}'


def _vehicles(picture: Picture, now_s: float) -> Iterator[Feature]:
    for vehicle in picture.vehicles.values():
        if math.isfinite(vehicle.latitude_deg):
            place = [vehicle.longitude_deg, vehicle.latitude_deg]
            altitude = [vehicle.altitude_m] if math.isfinite(vehicle.altitude_m) else []
            age_s = now_s - vehicle.placed_s
            yield _feature(
                'Point',
                [*place, *altitude],
                vehicle=vehicle.name,
                state=vehicle.report.state_name,
                battery_fraction=vehicle.report.battery_fraction,
                dose_rate_usvh=vehicle.dose_rate_now(now_s),
                dose_usv=vehicle.dose_usv,
                led_by=vehicle.holder.holder,
                age_s=age_s,
                is_stale=not age_s <= STALE_S,
            )


def _tracks(picture: Picture, _now_s: float) -> Iterator[Feature]:
    for name, points in picture.tracks().items():
        if len(points) > 1:
            yield _feature('LineString', [[p[1], p[0]] for p in points], vehicle=name)


def _region(picture: Picture, _now_s: float) -> Iterator[Feature]:
    region = picture.sections.value('region')
    if region:
        yield _feature('Polygon', _rings(region['rings']), name=region['name'])


def _routes(picture: Picture, _now_s: float) -> Iterator[Feature]:
    plan = picture.sections.value('plan') or {}
    for name, route in plan.get('routes', {}).items():
        line = [place[::-1] for place in route['line']]
        yield _feature('LineString', line, vehicle=name, plan_id=plan['plan_id'])


def _exclusions(picture: Picture, _now_s: float) -> Iterator[Feature]:
    for rings in (picture.sections.value('plan') or {}).get('exclusions', []):
        yield _feature('Polygon', _rings(rings))


def _cordons(picture: Picture, now_s: float) -> Iterator[Feature]:
    age_s = _age_s(picture.sections.value('cordons_heard_s'), now_s)
    for one in picture.sections.value('cordons') or []:
        line = [place[::-1] for place in one['ring']]
        bound = 'mean' if one['is_mean'] else 'upper 95 %'
        yield _feature(
            'LineString', line, level_usvh=one['level_usvh'], confidence=bound, age_s=age_s
        )


def _sources(picture: Picture, now_s: float) -> Iterator[Feature]:
    found = picture.sections.value('sources') or {}
    for one in found.get('sources', []):
        known = {key: value for key, value in one.items() if key not in ('place', 'half_axes_m')}
        longer, shorter = one['half_axes_m']
        known |= {'half_axis_95_m': longer, 'shorter_half_axis_95_m': shorter}
        known['age_s'] = _age_s(found.get('heard_s'), now_s)
        yield _feature('Point', one['place'][::-1], **known)


def _releases(picture: Picture, now_s: float) -> Iterator[Feature]:
    found = picture.sections.value('releases') or {}
    for one in found.get('releases', []):
        known = {key: value for key, value in one.items() if key != 'place'}
        known['age_s'] = _age_s(found.get('heard_s'), now_s)
        yield _feature('Point', one['place'][::-1], agent=found['agent'], **known)


def _zones(picture: Picture, now_s: float) -> Iterator[Feature]:
    age_s = _age_s(picture.sections.value('zones_heard_s'), now_s)
    for one in picture.sections.value('zones') or []:
        line = [place[::-1] for place in one['ring']]
        bound = 'expected' if one['is_mean'] else 'outer 95 %'
        yield _feature('LineString', line, level=one['level'], confidence=bound, age_s=age_s)


def _marks(picture: Picture, _now_s: float) -> Iterator[Feature]:
    for one in picture.sections.value('marks') or []:
        place = [one['longitude_deg'], one['latitude_deg']]
        yield _feature('Point', place, text=one['text'], by=one['by'], time_s=one['time_s'])


COLLECTIONS: Mapping[str, tuple[str, Callable[[Picture, float], Iterator[Feature]]]] = {
    'vehicles': ('Vehicles', _vehicles),
    'tracks': ('Flown tracks', _tracks),
    'region': ('Region', _region),
    'routes': ('Planned routes', _routes),
    'exclusions': ('Exclusions', _exclusions),
    'cordons': ('Cordons', _cordons),
    'sources': ('Estimated sources', _sources),
    'releases': ('Estimated releases of gas', _releases),
    'threat_zones': ('Threat zones of gas', _zones),
    'marks': ('Marks', _marks),
}


def _age_s(heard_s: float | None, now_s: float) -> float | None:
    """Return the age of what was heard, seconds; None: nobody knows."""
    return None if heard_s is None else now_s - heard_s


def _feature(kind: str, coordinates: list[Any], **properties: Any) -> Feature:
    return {'geometry': {'type': kind, 'coordinates': coordinates}, 'properties': properties}


def _rings(rings: list[list[list[float]]]) -> list[list[list[float]]]:
    """Return rings of longitude and latitude, closed."""
    return [[place[::-1] for place in (*ring, ring[0])] for ring in rings if ring]


def _link(address: str, relation: str, kind: str) -> dict[str, str]:
    return {'href': address, 'rel': relation, 'type': kind}
