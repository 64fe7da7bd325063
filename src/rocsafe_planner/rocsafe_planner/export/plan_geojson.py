# SPDX-License-Identifier: Apache-2.0
"""The plan for a map: GeoJSON (RFC 7946), styled by simplestyle-spec 1.1.

Each feature's property `kind` says what it is: region, exclusion, route (one a flight), home, end,
viewpoint or footprint.
Coordinates are WGS84 longitude, latitude, and altitude above the ellipsoid where it is known.
"""

import math
from collections.abc import Iterable, Iterator
from typing import Any

import shapely

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.export.route_colors import EXCLUSION_COLOR, route_color
from rocsafe_planner.plan.document import Document
from rocsafe_planner.plan.flight_path import flight_path
from rocsafe_planner.plan.flight_summary import flight_summary
from rocsafe_planner.plan.plan import Route, SurveyPlan, Viewpoint
from rocsafe_planner.plan.plan_json import quality_document

_DECIMALS = 9  # of a degree: a tenth of a millimetre


def plan_geojson(plan: SurveyPlan) -> Document:
    """Return regions, routes, homes and viewpoints."""
    features = [*_regions(plan), *(_exclusion(zone) for zone in plan.request.exclusions)]
    for index, route in enumerate(plan.routes):
        color = route_color(index)
        features.extend(_stands(route, color))
        features.extend(_flight(route, number, color) for number in range(len(route.sorties)))
        for order, viewpoint in enumerate(route.viewpoints, start=1):
            features.append(_viewpoint(route, viewpoint, order, color))
    return {'type': 'FeatureCollection', 'features': features}


def _regions(plan: SurveyPlan) -> list[Document]:
    """Return the regions; the first one has the figures of the whole plan."""
    features = []
    for number, region in enumerate(plan.request.regions):
        properties = {
            'kind': 'region',
            'name': region.area.name,
            'sensors': list(region.sensors),
            **(quality_document(plan) if number == 0 else {}),
            'stroke': '#333333',
            'fill': '#333333',
            'fill-opacity': 0.08,
        }
        features.append(_feature('Polygon', area_rings(region.area), properties))
    return features


def _exclusion(zone: SurveyArea) -> Document:
    properties = {
        'kind': 'exclusion',
        'name': zone.name,
        'stroke': EXCLUSION_COLOR,
        'fill': EXCLUSION_COLOR,
        'fill-opacity': 0.25,
    }
    return _feature('Polygon', area_rings(zone), properties)


def _flight(route: Route, number: int, color: str) -> Document:
    sortie, summary = route.sorties[number], flight_summary(route, number)
    properties = {
        'kind': 'route',
        'vehicle': route.vehicle.name,
        'flight': number + 1,
        'length_m': sortie.length_m,
        'duration_s': sortie.duration_s,
        'takes_off_s': summary.takes_off_s,
        'lands_s': summary.lands_s,
        'begins': summary.begins,
        'lands': summary.lands,
        'description': summary.text,
        'viewpoint_count': len(sortie.viewpoints),
        'stroke': color,
        'stroke-width': 2,
    }
    # Without heights: that of a home is on the ground, that of a viewpoint in the air.
    places = [_coordinates(stop.position)[:2] for stop in flight_path(route, number)]
    return _feature('LineString', places, properties)


def _stands(route: Route, color: str) -> Iterator[Document]:
    """Yield the place of take-off, and the place of landing if that is another."""
    for kind, place in (('home', route.vehicle.home), ('end', route.vehicle.end)):
        properties = {
            'kind': kind,
            'vehicle': route.vehicle.name,
            'marker-color': color,
            'marker-symbol': 'heliport',
        }
        if place is not None:
            yield _feature('Point', _coordinates(place), properties)


def _viewpoint(route: Route, viewpoint: Viewpoint, order: int, color: str) -> Document:
    properties = {
        'kind': 'viewpoint',
        'vehicle': route.vehicle.name,
        'id': viewpoint.id,
        'order': order,
        'height_agl_m': viewpoint.height_agl_m,
        'yaw_rad': viewpoint.yaw_rad,
        'marker-color': color,
        'marker-size': 'small',
    }
    return _feature('Point', _coordinates(viewpoint.position), properties)


def area_rings(area: SurveyArea) -> list[list[list[float]]]:
    """Return closed rings, the outer one anticlockwise, holes clockwise (RFC 7946, 3.1.6)."""
    polygon = shapely.Polygon(_closed(area.boundary), [_closed(hole) for hole in area.holes])
    oriented = shapely.geometry.polygon.orient(polygon)
    return [
        [list(corner) for corner in ring.coords]
        for ring in (oriented.exterior, *oriented.interiors)
    ]


def _closed(ring: Iterable[GeoPosition]) -> list[list[float]]:
    corners = [_coordinates(corner)[:2] for corner in ring]
    return [*corners, corners[0]]


def _coordinates(position: GeoPosition) -> list[float]:
    place = [round(position.longitude_deg, _DECIMALS), round(position.latitude_deg, _DECIMALS)]
    if not math.isnan(position.altitude_m):
        place.append(round(position.altitude_m, 3))
    return place


def _feature(kind: str, coordinates: list[Any], properties: Document) -> Document:
    return {
        'type': 'Feature',
        'properties': properties,
        'geometry': {'type': kind, 'coordinates': coordinates},
    }
