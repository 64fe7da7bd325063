# SPDX-License-Identifier: Apache-2.0
"""From a request to a plan: cover the area, share out the viewpoints, bound the makespan."""

import math
from collections.abc import Callable

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_planner.bound import lower_bound
from rocsafe_planner.coverage import Coverage, cover, coverage_spec
from rocsafe_planner.errors import BeyondEnduranceError, PlanningCancelledError
from rocsafe_planner.fleet_problem import FleetProblem, Order
from rocsafe_planner.plan import Route, SurveyPlan, Viewpoint
from rocsafe_planner.request import SurveyRequest
from rocsafe_planner.routing import METHODS

Progress = Callable[[float, float], bool]
"""Told the best makespan and lower bound so far, in seconds, NaN while unknown; False stops."""

MAX_HOME_DISTANCE_M = 100_000.0
"""Homes further from the region's centre than this are a slip of the pen."""


def plan_survey(
    request: SurveyRequest, on_progress: Progress = lambda _makespan, _bound: True
) -> SurveyPlan:
    """Return the plan of a request: the same request gives the same plan.

    Raises
    ------
    ValueError
        If a home is further than `MAX_HOME_DISTANCE_M` from the region.
    TooManyViewpointsError, BeyondEnduranceError
        If there is no plan within the limits.
    PlanningCancelledError
        If `on_progress` returned False.
    """
    _check_homes(request)
    _go_on(on_progress, math.nan, math.nan)
    frame = _frame_of(request)
    spec = coverage_spec(
        request.camera, request.height_agl_m, request.overlap_fraction, request.spacing_rule,
        request.grid, request.max_viewpoints,
    )
    coverage = cover(request.area.polygon(frame), spec)
    _go_on(on_progress, math.nan, math.nan)
    problem = _problem_of(request, coverage, frame)
    orders = METHODS[request.method](problem)
    routes = _routes(problem, orders, _viewpoints(request, coverage, frame))
    makespan = max(route.duration_s for route in routes)
    _check_endurance(routes)
    bound = lower_bound(problem, makespan, lambda seconds: _go_on(on_progress, makespan, seconds))
    return SurveyPlan(
        plan_id=request.identity(),
        request=request,
        routes=routes,
        spacing_m=spec.spacing_m[0],
        spacing_along_m=spec.spacing_m[1],
        # A bound that equals the makespan may exceed it by rounding.
        lower_bound_s=min(bound.makespan_s, makespan),
        lower_bound_method=bound.method,
        region_area_m2=coverage.region_area_m2,
        covered_area_m2=coverage.covered_area_m2,
    )


def _go_on(on_progress: Progress, makespan: float, bound: float) -> bool:
    """Report; return True or raise PlanningCancelledError."""
    if not on_progress(makespan, bound):
        raise PlanningCancelledError('planning was cancelled')
    return True


def _check_homes(request: SurveyRequest) -> None:
    centre = request.area.centroid()
    for vehicle in request.vehicles:
        distance = distance_m(centre, vehicle.home)
        if distance > MAX_HOME_DISTANCE_M:
            raise ValueError(
                f'{vehicle.name} home is {distance / 1000.0:.0f} km from the region: must be '
                f'within {MAX_HOME_DISTANCE_M / 1000.0:.0f} km'
            )


def _frame_of(request: SurveyRequest) -> LocalFrame:
    """Return the frame about the region's centre; level ground as high as the homes."""
    centre = request.area.centroid()
    ground = _ground_altitude_m(request)
    altitude = 0.0 if math.isnan(ground) else ground
    return LocalFrame(GeoPosition(centre.latitude_deg, centre.longitude_deg, altitude))


def _ground_altitude_m(request: SurveyRequest) -> float:
    """Return the mean altitude of the homes whose altitude is known, NaN if none is."""
    known = [v.home.altitude_m for v in request.vehicles if not math.isnan(v.home.altitude_m)]
    return sum(known) / len(known) if known else math.nan


def _problem_of(request: SurveyRequest, coverage: Coverage, frame: LocalFrame) -> FleetProblem:
    homes = frame.to_enu(
        [vehicle.home.latitude_deg for vehicle in request.vehicles],
        [vehicle.home.longitude_deg for vehicle in request.vehicles],
        math.nan,
    )
    return FleetProblem(
        vehicles=request.vehicles,
        homes=homes[:, :2],
        points=coverage.centres,
        height_m=request.height_agl_m,
    )


def _viewpoints(
    request: SurveyRequest, coverage: Coverage, frame: LocalFrame
) -> tuple[Viewpoint, ...]:
    """Return all viewpoints; the index is the id."""
    height = request.height_agl_m
    count = len(coverage.centres)
    geodetic = frame.to_geodetic(np.column_stack([coverage.centres, np.full(count, height)]))
    if math.isnan(_ground_altitude_m(request)):
        geodetic[:, 2] = math.nan
    corners = coverage.footprints.reshape(-1, 2)
    ground = frame.to_geodetic(np.column_stack([corners, np.full(len(corners), math.nan)]))
    footprints = ground.reshape(count, 4, 3).tolist()
    return tuple(
        Viewpoint(
            id=number,
            position=GeoPosition(*place),
            height_agl_m=height,
            yaw_rad=coverage.yaw_rad,
            footprint=tuple(GeoPosition(*corner) for corner in footprint),
        )
        for number, (place, footprint) in enumerate(
            zip(geodetic.tolist(), footprints, strict=True)
        )
    )


def _routes(
    problem: FleetProblem, orders: list[Order], viewpoints: tuple[Viewpoint, ...]
) -> tuple[Route, ...]:
    return tuple(
        Route(
            vehicle=vehicle,
            viewpoints=tuple(viewpoints[i] for i in order),
            length_m=problem.length_m(k, order),
            duration_s=problem.duration_s(k, order),
        )
        for k, (vehicle, order) in enumerate(zip(problem.vehicles, orders, strict=True))
    )


def _check_endurance(routes: tuple[Route, ...]) -> None:
    """Refuse a plan with a route that a battery does not last for; name the worst one."""
    worst = max(routes, key=lambda route: route.duration_s - route.vehicle.endurance_s)
    if worst.duration_s > worst.vehicle.endurance_s:
        raise BeyondEnduranceError(
            f'{worst.vehicle.name} needs {worst.duration_s:.0f} s for its '
            f'{len(worst.viewpoints)} viewpoints: its endurance_s is '
            f'{worst.vehicle.endurance_s:.0f} s'
        )
