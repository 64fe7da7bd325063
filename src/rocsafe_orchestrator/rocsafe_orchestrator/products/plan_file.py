# SPDX-License-Identifier: Apache-2.0
"""Reading ``plan.json`` as the planner writes it."""

import json
import math
from pathlib import Path
from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_orchestrator.products.run_record import Plan, PlannedRoute, PlannedViewpoint

FORMAT_VERSION = 1


class PlanFileError(ValueError):
    """A file is no plan."""


def read_plan(path: Path) -> Plan:
    """Read the plan that the planner wrote to `path`.

    Raises
    ------
    PlanFileError: if it is no plan, or one of a newer format.
    """
    try:
        document = json.loads(path.read_text(encoding='utf-8'))
        version = document['format_version']
        if version != FORMAT_VERSION:
            raise PlanFileError(f'{path.name} has format {version}, not {FORMAT_VERSION}')
        return _plan(document)
    except KeyError as error:
        raise PlanFileError(f'{path.name} has no {error.args[0]!r}') from error
    except (OSError, TypeError, ValueError) as error:
        raise PlanFileError(f'{path.name} cannot be read: {error}') from error


def _plan(document: dict[str, Any]) -> Plan:
    camera = document['camera']
    return Plan(
        plan_id=document['plan_id'],
        method=document['method'],
        region=_area(document['region']),
        height_agl_m=document['height_agl_m'],
        spacing_rule=document['spacing_rule'],
        overlap_fraction=document['overlap_fraction'],
        spacing_m=document['spacing_m'],
        routes=_routes(document),
        makespan_s=document['makespan_s'],
        lower_bound_s=document['lower_bound_s'],
        lower_bound_method=document['lower_bound_method'],
        gap_fraction=document['gap_fraction'],
        region_area_m2=document['region_area_m2'],
        covered_area_m2=document['covered_area_m2'],
        covered_fraction=document['covered_fraction'],
        horizontal_fov_rad=camera['horizontal_fov_rad'],
        image_width_px=camera['image_width_px'],
        image_height_px=camera['image_height_px'],
        other_regions=tuple(map(_area, document.get('other_regions', ()))),
        exclusions=tuple(map(_area, document.get('exclusions', ()))),
        objective=document.get('objective', 'longest_time'),
        objective_value=_number(document.get('objective_value')),
        largest_hole_m2=_number(document.get('largest_hole_m2')),
        separation_m=document.get('separation_m', 0.0),
        minimum_separation_m=_number(document.get('minimum_separation_m')),
    )


def _number(value: float | None) -> float:
    """Return NaN for null, which stands for what is not known, or endless."""
    return math.nan if value is None else value


def _area(area: dict[str, Any]) -> SurveyArea:
    return SurveyArea(
        boundary=_ring(area['boundary']),
        holes=tuple(map(_ring, area['holes'])),
        name=area['name'],
    )


def _ring(corners: list[dict[str, Any]]) -> tuple[GeoPosition, ...]:
    return tuple(map(_position, corners))


def _routes(document: dict[str, Any]) -> tuple[PlannedRoute, ...]:
    vehicles = {vehicle['name']: vehicle for vehicle in document.get('vehicles', ())}
    return tuple(_route(route, vehicles.get(route['vehicle'], {})) for route in document['routes'])


def _route(route: dict[str, Any], vehicle: dict[str, Any]) -> PlannedRoute:
    return PlannedRoute(
        vehicle=route['vehicle'],
        home=_position(route['home']),
        viewpoints=tuple(map(_viewpoint, route['viewpoints'])),
        length_m=route['length_m'],
        duration_s=route['duration_s'],
        way=_way(route, vehicle.get('end')),
        delay_s=route.get('delay_s', 0.0),
        flights=len(route.get('sorties', (route,))),
    )


def _way(route: dict[str, Any], end: dict[str, Any] | None) -> tuple[GeoPosition, ...]:
    """Return the places of all flights, or of one straight flight if no flights are told.

    All but the last land at home; that lands at `end`, if there is one.
    """
    places = {view['id']: _position(view) for view in route['viewpoints']}
    home = _position(route['home'])
    if 'sorties' not in route:
        return (home, *places.values(), home)
    way = []
    landings = [home] * (len(route['sorties']) - 1) + [_position(end) if end else home]
    for sortie, landing in zip(route['sorties'], landings, strict=False):
        way.append(home)
        bends = [list(map(_position, leg)) for leg in sortie['bends']]
        for number, viewpoint in enumerate(sortie['viewpoint_ids']):
            way += [*bends[number], places[viewpoint]]
        if len(bends) > len(sortie['viewpoint_ids']):
            way += [*bends[-1], landing]
    return tuple(way)


def _viewpoint(viewpoint: dict[str, Any]) -> PlannedViewpoint:
    return PlannedViewpoint(
        id=viewpoint['id'],
        position=_position(viewpoint),
        height_agl_m=_number(viewpoint['height_agl_m']),
        yaw_rad=viewpoint['yaw_rad'],
    )


def _position(place: dict[str, Any]) -> GeoPosition:
    altitude = place.get('altitude_m')
    return GeoPosition(
        latitude_deg=place['latitude_deg'],
        longitude_deg=place['longitude_deg'],
        altitude_m=math.nan if altitude is None else altitude,
    )
