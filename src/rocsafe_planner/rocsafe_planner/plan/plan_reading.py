# SPDX-License-Identifier: Apache-2.0
"""Reader of `plan.json`."""

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.storage.named_file import require_file
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_planner.plan.document import Document
from rocsafe_planner.plan.plan import Route, Sortie, SurveyPlan
from rocsafe_planner.plan.plan_json import FORMAT_VERSION
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import (
    AirspaceOptions,
    Continuation,
    CoverageOptions,
    Effort,
    SeparationOptions,
    UnheardVehicle,
)
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Aloft, Vehicle
from rocsafe_planner.plan.viewpoint import Viewpoint


def read_plan(
    path: str | Path, terrain: Terrain | None = None, *, needs_terrain: bool = True
) -> SurveyPlan:
    """Return the plan in a file.

    Parameters
    ----------
    path
        File, usually ``plan.json``.
    terrain
        Terrain of a plan over one: the file holds its name and digest, no heights.
    needs_terrain
        Whether a plan over terrain is refused without it. A reader that plans and checks nothing
        sets False; the request of the plan then has no terrain.

    Raises
    ------
    ValueError
        If the file holds no plan, or a plan over another terrain; one line.
    """
    try:
        require_file(Path(path))
        document = json.loads(Path(path).read_text(encoding='utf-8'))
        _check(document, terrain, needs_terrain)
        return _plan(document, terrain)
    except OSError as error:
        raise ValueError(f'{path}: {error.strerror}') from error
    except KeyError as error:
        raise ValueError(f'{path}: is no plan: it has no {error.args[0]!r}') from error
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(f'{path}: {error}') from error


def exported_plan(
    paths: Iterable[Path], plan_id: str, terrain: Terrain | None = None
) -> SurveyPlan:
    """Return the plan of that id from the first of the files that holds it.

    Raises
    ------
    ValueError
        If none does.
    """
    for path in paths:
        if path.is_file():
            plan = read_plan(path, terrain)
            if plan.plan_id == plan_id:
                return plan
    raise ValueError(f'rest_of is {plan_id!r}: must be a plan of this planner')


def _check(document: Document, terrain: Terrain | None, needs_terrain: bool) -> None:
    if document['format_version'] != FORMAT_VERSION:
        raise ValueError(
            f'has format {document["format_version"]}, not {FORMAT_VERSION}: plan again'
        )
    wanted = document['request']['terrain']
    if wanted is None and terrain is not None:
        raise ValueError('is a plan over level ground: must be given no terrain')
    if wanted is not None and terrain is None and needs_terrain:
        raise ValueError(f'is a plan over {wanted["name"]}: must be given that file')
    if wanted is not None and terrain is not None and wanted['sha256'] != terrain.digest:
        raise ValueError(f'is a plan over {wanted["name"]}: {terrain.name} has other heights')


def _plan(document: Document, terrain: Terrain | None) -> SurveyPlan:
    request = _request(document['request'], terrain)
    camera = request.camera
    vehicles = zip(request.vehicles, document['routes'], strict=True)
    return SurveyPlan(
        plan_id=document['plan_id'],
        request=request,
        routes=tuple(_route(vehicle, route, camera) for vehicle, route in vehicles),
        minimum_separation_m=_known(document['minimum_separation_m'], math.inf),
        near_unheard=tuple(document.get('near_unheard', ())),
        left_out=tuple(document.get('left_out', ())),
        forbidden_area_m2=document.get('forbidden_area_m2', 0.0),
        objective_bound=_known(document['objective_bound'], math.nan),
        **{
            key: document[key]
            for key in (
                'spacing_m', 'spacing_along_m', 'lower_bound_s', 'lower_bound_method',
                'region_area_m2', 'covered_area_m2', 'largest_hole_m2',
            )
        },
    )  # fmt: skip


def _request(document: Document, terrain: Terrain | None) -> SurveyRequest:
    camera = PinholeCamera(**document['camera'])
    continuation = document['continuation']
    return SurveyRequest(
        regions=tuple(
            SurveyRegion(area=_area(region), sensors=tuple(region['sensors']))
            for region in document['regions']
        ),
        exclusions=tuple(map(_area, document['exclusions'])),
        camera=camera,
        vehicles=tuple(map(_vehicle, document['vehicles'])),
        terrain=terrain,
        coverage=CoverageOptions(**document['coverage']),
        airspace=AirspaceOptions(**document['airspace']),
        separation=SeparationOptions(**document['separation']),
        effort=Effort(**document['effort']),
        continuation=Continuation(
            viewpoints=tuple(_viewpoint(v, camera) for v in continuation['viewpoints']),
            visited=tuple(_viewpoint(v, camera) for v in continuation['visited']),
            ground_reference=tuple(map(_position, continuation['ground_reference'])),
            unheard=tuple(map(_unheard, continuation.get('unheard', ()))),
            last=tuple(continuation.get('last', ())),
        ),
    )


def _unheard(document: Document) -> UnheardVehicle:
    return UnheardVehicle(
        name=document['name'],
        flight_height_m=document['flight_height_m'],
        home=_position(document['home']),
        places=tuple(map(_position, document['places'])),
    )


def _known(value: float | None, otherwise: float) -> float:
    return otherwise if value is None else value


def _area(area: Document) -> SurveyArea:
    return SurveyArea(
        boundary=tuple(map(_position, area['boundary'])),
        holes=tuple(tuple(map(_position, hole)) for hole in area['holes']),
        name=area['name'],
    )


def _position(place: Document) -> GeoPosition:
    altitude = _known(place.get('altitude_m'), math.nan)
    return GeoPosition(place['latitude_deg'], place['longitude_deg'], altitude)


def _vehicle(vehicle: Document) -> Vehicle:
    end, aloft = vehicle['end'], vehicle['aloft']
    changes: dict[str, Any] = {
        'home': _position(vehicle['home']),
        'end': None if end is None else _position(end),
        'aloft': None
        if aloft is None
        else Aloft(position=_position(aloft), used_s=aloft['used_s']),
        'sensors': tuple(vehicle['sensors']),
        'autopilot': Autopilot(**vehicle.get('autopilot', {})),
    }
    return Vehicle(**{**vehicle, **changes})


def _route(vehicle: Vehicle, route: Document, camera: PinholeCamera) -> Route:
    views = {view['id']: _viewpoint(view, camera) for view in route['viewpoints']}
    return Route(
        vehicle=vehicle,
        delay_s=route['delay_s'],
        flight_height_m=route['flight_height_m'],
        ground_altitude_m=_known(route.get('ground_altitude_m'), math.nan),
        landing_height_m=_known(route.get('landing_height_m'), math.nan),
        sorties=tuple(
            Sortie(
                viewpoints=tuple(views[number] for number in sortie['viewpoint_ids']),
                bends=tuple(tuple(map(_position, bends)) for bends in sortie['bends']),
                length_m=sortie['length_m'],
                duration_s=sortie['duration_s'],
                energy_wh=sortie['energy_wh'],
            )
            for sortie in route['sorties']
        ),
    )


def _viewpoint(view: Document, camera: PinholeCamera) -> Viewpoint:
    place, height, yaw = _position(view), view['height_agl_m'], view['yaw_rad']
    across, along = (0.5 * side for side in camera.footprint_m(height))
    ahead, left = (math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))
    corners = ((across, -along), (-across, -along), (-across, along), (across, along))
    # Anticlockwise from the corner behind on the left, as a grid's footprints are.
    footprint = tuple(
        offset(place, x * left[0] + y * ahead[0], x * left[1] + y * ahead[1]) for x, y in corners
    )
    return Viewpoint(
        id=view['id'],
        position=place,
        height_agl_m=height,
        yaw_rad=yaw,
        footprint=tuple(GeoPosition(c.latitude_deg, c.longitude_deg) for c in footprint),
        sensors=tuple(view['sensors']),
    )
