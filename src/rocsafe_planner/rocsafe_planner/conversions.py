# SPDX-License-Identifier: Apache-2.0
"""Requests and plans <-> ROCSAFE messages."""

import math
from dataclasses import fields
from typing import Any

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_interfaces import action, msg
from rocsafe_planner.errors import (
    BeyondEnduranceError,
    PlannerError,
    PlanningCancelledError,
    TooManyViewpointsError,
)
from rocsafe_planner.options import PlannerOptions
from rocsafe_planner.plan.flight_path import ground_places
from rocsafe_planner.plan.objective import OBJECTIVE_VALUES
from rocsafe_planner.plan.plan import Bends, Route, Sortie, SurveyPlan, Viewpoint
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.situation import Situation
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
from rocsafe_planner.plan.viewpoint import viewpoints_over
from rocsafe_ros.conversions import (
    EARTH_FRAME,
    area_of_region,
    point_of_position,
    position_of_point,
    region_of_area,
)


def request_of_goal(goal: action.PlanSurvey.Goal, options: PlannerOptions) -> SurveyRequest:
    """Return what a goal asks for; `options` fill what it leaves open.

    Raises
    ------
    ValueError
        Naming the field, its value and the limit.
    """
    coverage = _coverage(goal.coverage, options)
    camera = _camera(goal.camera)
    places = [position_of_point(point) for point in goal.viewpoints]
    views = viewpoints_over(places, camera, coverage.height_agl_m) if places else ()
    return SurveyRequest(
        regions=tuple(
            SurveyRegion(area=area_of_region(region), sensors=tuple(region.sensors))
            for region in (goal.region, *goal.other_regions)
        ),
        exclusions=tuple(area_of_region(zone) for zone in goal.exclusions),
        camera=camera,
        vehicles=tuple(_vehicle(vehicle) for vehicle in goal.vehicles),
        terrain=read_terrain(goal.terrain_file) if goal.terrain_file else None,
        coverage=coverage,
        airspace=_airspace(goal.airspace),
        separation=SeparationOptions(
            **_given(
                distance_m=None
                if goal.separation.distance_m == 0.0
                else max(0.0, goal.separation.distance_m),
                by=goal.separation.by,
            )
        ),
        effort=Effort(
            method=goal.effort.method or options.default_method,
            **_given(objective=goal.effort.objective),
            budget_s=goal.effort.budget_s,
            proposals=goal.effort.proposals,
            seed=goal.effort.seed,
        ),
        continuation=Continuation(viewpoints=views),
    )


def _coverage(message: msg.SurveyCoverage, options: PlannerOptions) -> CoverageOptions:
    limit = message.max_viewpoints or options.max_viewpoints
    return CoverageOptions(
        height_agl_m=message.height_agl_m,
        spacing_rule=message.spacing_rule,
        overlap_fraction=message.overlap_fraction,
        front_overlap_fraction=_known(message.front_overlap_fraction),
        grid=message.grid or options.grid,
        max_viewpoints=min(limit, options.max_viewpoints),
    )


def _airspace(message: msg.SurveyAirspace) -> AirspaceOptions:
    return AirspaceOptions(
        wind_mps=(message.wind_east_mps, message.wind_north_mps),
        **_given(
            clearance_m=_known(message.clearance_m),
            terrain_clearance_m=_known(message.terrain_clearance_m),
            max_height_agl_m=_known(message.max_height_agl_m),
        ),
    )


def _given(**values: Any) -> dict[str, Any]:
    """Return the values that a message gives: no None and no empty text."""
    return {name: value for name, value in values.items() if value not in (None, '')}


def situation_of_goal(goal: action.PlanSurvey.Goal) -> Situation:
    """Return what became of the plan of which a goal asks for the rest.

    Raises
    ------
    ValueError
        Naming what is wrong with it.
    """
    return Situation(
        alive={vehicle.name: _now(vehicle) for vehicle in goal.able},
        visited=frozenset(int(number) for number in goal.visited),
        unheard=tuple(map(_unheard, goal.unheard)),
    )


def _unheard(vehicle: msg.UnheardVehicle) -> UnheardVehicle:
    return UnheardVehicle(
        name=vehicle.name,
        flight_height_m=vehicle.flight_height_m,
        home=position_of_point(vehicle.home),
        places=tuple(map(position_of_point, vehicle.places)),
    )


def _now(vehicle: msg.VehicleNow) -> Aloft | float:
    place = _only_place(f'{vehicle.name} position', vehicle.position)
    return vehicle.used_s if place is None else Aloft(position=place, used_s=vehicle.used_s)


def message_of_plan(plan: SurveyPlan) -> msg.SurveyPlan:
    """Return the plan as a message without a stamp."""
    request = plan.request
    message = msg.SurveyPlan(
        plan_id=plan.plan_id,
        method=request.effort.method,
        seed=request.effort.seed,
        objective=request.effort.objective,
        region=_region(request.regions[0]),
        other_regions=[_region(region) for region in request.regions[1:]],
        exclusions=[region_of_area(zone) for zone in request.exclusions],
        camera=_camera_message(request.camera),
        height_agl_m=request.coverage.height_agl_m,
        spacing_rule=request.coverage.spacing_rule,
        overlap_fraction=request.coverage.overlap_fraction,
        front_overlap_fraction=request.coverage.front_overlap,
        spacing_m=plan.spacing_m,
        routes=[_route(route, request) for route in plan.routes],
        makespan_s=plan.makespan_s,
        longest_route_m=plan.longest_route_m,
        total_length_m=plan.total_length_m,
        lower_bound_s=plan.lower_bound_s,
        lower_bound_method=plan.lower_bound_method,
        gap_fraction=plan.gap_fraction,
        region_area_m2=plan.region_area_m2,
        covered_area_m2=plan.covered_area_m2,
        covered_fraction=plan.covered_fraction,
        largest_hole_m2=plan.largest_hole_m2,
        separation_m=request.separation.distance_m,
        objective_value=OBJECTIVE_VALUES[request.effort.objective](plan),
        minimum_separation_m=plan.minimum_separation_m,
        near_unheard=list(plan.near_unheard),
    )
    message.header.frame_id = EARTH_FRAME
    return message


def result_of_plan(message: msg.SurveyPlan) -> action.PlanSurvey.Result:
    """Return the result of a goal that got its plan."""
    return action.PlanSurvey.Result(error_code=action.PlanSurvey.Result.NONE, plan=message)


def result_of_stopped(
    reason: str, message: msg.SurveyPlan | None = None
) -> action.PlanSurvey.Result:
    """Return the result of a goal that was stopped: why, and the best plan so far if any."""
    best = 'there is no plan yet' if message is None else 'the plan is the best so far'
    return action.PlanSurvey.Result(
        error_code=action.PlanSurvey.Result.CANCELLED,
        error_msg=f'planning was stopped: {reason}; {best}',
        plan=message or msg.SurveyPlan(),
    )


def result_of_error(error: PlannerError | ValueError) -> action.PlanSurvey.Result:
    """Return the result of a goal that got none, with the reason in one line."""
    result = action.PlanSurvey.Result(error_msg=str(error))
    codes: dict[type[Exception], int] = {
        TooManyViewpointsError: result.TOO_MANY_VIEWPOINTS,
        BeyondEnduranceError: result.BEYOND_ENDURANCE,
        PlanningCancelledError: result.CANCELLED,
    }
    result.error_code = codes.get(type(error), result.INVALID_REQUEST)
    return result


def feedback(elapsed_s: float, makespan_s: float, bound_s: float) -> action.PlanSurvey.Feedback:
    """Return the progress of a goal; NaN for what is not known."""
    gap = makespan_s / bound_s - 1.0 if bound_s > 0.0 else math.nan
    return action.PlanSurvey.Feedback(
        elapsed_s=elapsed_s,
        best_makespan_s=makespan_s,
        lower_bound_s=bound_s,
        gap_fraction=gap,
    )


def _camera(camera: msg.CameraSpec) -> PinholeCamera:
    return PinholeCamera(camera.horizontal_fov_rad, camera.image_width_px, camera.image_height_px)


def _camera_message(camera: PinholeCamera) -> msg.CameraSpec:
    return msg.CameraSpec(
        horizontal_fov_rad=camera.horizontal_fov_rad,
        image_width_px=camera.image_width_px,
        image_height_px=camera.image_height_px,
    )


def _vehicle(vehicle: msg.VehicleSpec) -> Vehicle:
    return Vehicle(
        name=vehicle.name,
        home=position_of_point(vehicle.home),
        cruise_speed_mps=vehicle.cruise_speed_mps,
        acceleration_mps2=vehicle.acceleration_mps2,
        climb_rate_mps=vehicle.climb_rate_mps,
        descent_rate_mps=vehicle.descent_rate_mps,
        hover_s=vehicle.hover_s,
        endurance_s=vehicle.endurance_s,
        battery_swap_s=_known(vehicle.battery_swap_s),
        end=_only_place(f'{vehicle.name} end', vehicle.end),
        is_open=vehicle.is_open,
        sensors=tuple(vehicle.sensors),
        **_given(
            cruise_power_w=_known(vehicle.cruise_power_w),
            hover_power_w=_known(vehicle.hover_power_w),
        ),
        autopilot=_autopilot(vehicle.autopilot),
    )


def _autopilot(message: msg.Autopilot) -> Autopilot:
    return Autopilot(**{field.name: getattr(message, field.name) for field in fields(Autopilot)})


def _only_place(name: str, points: list[msg.GeoPoint]) -> GeoPosition | None:
    """Return the one position of a list, None if it is empty."""
    if len(points) > 1:
        raise ValueError(f'{name} has {len(points)} places: must be one at most')
    return position_of_point(points[0]) if points else None


def _region(region: SurveyRegion) -> msg.Region:
    message = region_of_area(region.area)
    message.sensors = list(region.sensors)
    return message


def _known(number: float) -> float | None:
    """Return None for the negative number that stands for no value."""
    return None if number < 0.0 else number


def _route(route: Route, request: SurveyRequest) -> msg.Route:
    """Return a route; what stands beside its flights is about all of them, and the last."""
    vehicle = route.vehicle
    flights = [_flight(sortie) for sortie in route.sorties]
    home, end = ground_places(route)
    return msg.Route(
        vehicle=vehicle.name,
        home=point_of_position(home),
        viewpoints=[viewpoint for flight in flights for viewpoint in flight.viewpoints],
        homeward=flights[-1].homeward if flights else [],
        exclusions=[region_of_area(zone).boundary for zone in request.exclusions],
        clearance_m=request.airspace.clearance_m,
        length_m=route.length_m,
        duration_s=route.duration_s,
        flights=flights,
        end=[] if end is None else [point_of_position(end)],
        is_open=vehicle.is_open,
        delay_s=route.delay_s,
        flight_height_m=route.flight_height_m,
        battery_swap_s=vehicle.battery_swap_s or 0.0,
        follows_terrain=request.terrain is not None,
    )


def _flight(sortie: Sortie) -> msg.Flight:
    to_viewpoints = sortie.bends[: len(sortie.viewpoints)]
    homeward = sortie.bends[len(sortie.viewpoints) :]
    return msg.Flight(
        viewpoints=[
            _viewpoint(viewpoint, approach)
            for viewpoint, approach in zip(sortie.viewpoints, to_viewpoints, strict=True)
        ],
        homeward=[point_of_position(bend) for bends in homeward for bend in bends],
        length_m=sortie.length_m,
        duration_s=sortie.duration_s,
    )


def _viewpoint(viewpoint: Viewpoint, approach: Bends) -> msg.Viewpoint:
    return msg.Viewpoint(
        id=viewpoint.id,
        position=point_of_position(viewpoint.position),
        height_agl_m=viewpoint.height_agl_m,
        yaw_rad=viewpoint.yaw_rad,
        approach=[point_of_position(bend) for bend in approach],
    )
