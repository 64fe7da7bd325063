# SPDX-License-Identifier: Apache-2.0
"""The complete plan as JSON: names as in SurveyPlan.msg, units in the keys, null for unknown.

Altitudes are metres above the WGS84 ellipsoid. The order of the keys is fixed and nothing depends
on when or where the plan was made: equal requests give equal files.
"""

from dataclasses import asdict
from pathlib import Path

from rocsafe_planner.plan.document import (
    Document,
    area_document,
    camera_document,
    continuation_document,
    number,
    position_document,
    region_document,
    terrain_document,
    vehicle_document,
    viewpoint_document,
)
from rocsafe_planner.plan.objective import OBJECTIVE_VALUES, objective_gap
from rocsafe_planner.plan.plan import Route, Sortie, SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest

FORMAT_VERSION = 2


def further_folder(folder: Path, plan_id: str) -> Path:
    """Return where the files of a plan for the rest of a survey are, or of another round."""
    return folder / f'further-{plan_id}'


def plan_document(plan: SurveyPlan) -> Document:
    """Return all values of the plan."""
    return {
        'format': 'rocsafe-plan',
        'format_version': FORMAT_VERSION,
        **quality_document(plan),
        'spacing_m': plan.spacing_m,
        'spacing_along_m': plan.spacing_along_m,
        'request': _request(plan.request),
        'left_out': list(plan.left_out),
        'routes': [_route(route) for route in plan.routes],
    }


def _request(request: SurveyRequest) -> Document:
    return {
        'regions': [region_document(region) for region in request.regions],
        'exclusions': [area_document(zone) for zone in request.exclusions],
        'terrain': terrain_document(request.terrain),
        'camera': camera_document(request.camera),
        'vehicles': [vehicle_document(vehicle) for vehicle in request.vehicles],
        'coverage': asdict(request.coverage),
        'airspace': asdict(request.airspace),
        'separation': asdict(request.separation),
        'effort': asdict(request.effort),
        'continuation': continuation_document(request.continuation),
    }


def quality_document(plan: SurveyPlan) -> Document:
    """Return the plan's name and figures without its routes."""
    return {
        'plan_id': plan.plan_id,
        'method': plan.request.effort.method,
        'objective': plan.request.effort.objective,
        'objective_value': OBJECTIVE_VALUES[plan.request.effort.objective](plan),
        'objective_bound': number(plan.objective_bound),
        'objective_gap_fraction': number(objective_gap(plan)),
        'viewpoint_count': plan.viewpoint_count,
        'makespan_s': plan.makespan_s,
        'longest_route_m': plan.longest_route_m,
        'total_length_m': plan.total_length_m,
        'lower_bound_s': plan.lower_bound_s,
        'lower_bound_method': plan.lower_bound_method,
        'gap_fraction': plan.gap_fraction,
        'region_area_m2': plan.region_area_m2,
        'forbidden_area_m2': plan.forbidden_area_m2,
        'covered_area_m2': plan.covered_area_m2,
        'covered_fraction': plan.covered_fraction,
        'largest_hole_m2': plan.largest_hole_m2,
        'minimum_separation_m': number(plan.minimum_separation_m),
        **({'near_unheard': list(plan.near_unheard)} if plan.near_unheard else {}),
        'total_duration_s': plan.total_duration_s,
        'total_energy_wh': plan.total_energy_wh,
    }


def _route(route: Route) -> Document:
    return {
        'vehicle': route.vehicle.name,
        'home': position_document(route.vehicle.home),
        'length_m': route.length_m,
        'duration_s': route.duration_s,
        'delay_s': route.delay_s,
        'flight_height_m': route.flight_height_m,
        'ground_altitude_m': number(route.ground_altitude_m),
        'landing_height_m': number(route.landing_height_m),
        'viewpoints': [viewpoint_document(viewpoint) for viewpoint in route.viewpoints],
        'sorties': [_sortie(sortie) for sortie in route.sorties],
    }


def _sortie(sortie: Sortie) -> Document:
    """Return a flight; `bends` has a list for each leg, most of them empty."""
    return {
        'viewpoint_ids': [viewpoint.id for viewpoint in sortie.viewpoints],
        'bends': [[position_document(bend) for bend in bends] for bends in sortie.bends],
        'length_m': sortie.length_m,
        'duration_s': sortie.duration_s,
        'energy_wh': sortie.energy_wh,
    }
