# SPDX-License-Identifier: Apache-2.0
"""Scenario -> region and requests to the planner, as messages."""

import math
from collections.abc import Container, Iterable, Mapping

from rocsafe_geo.regions.area import SurveyArea
from rocsafe_interfaces.action import PlanSurvey
from rocsafe_interfaces.msg import (
    Autopilot,
    CameraSpec,
    GeoPoint,
    Region,
    Route,
    SurveyAirspace,
    SurveyCoverage,
    SurveyEffort,
    SurveyPlan,
    SurveySeparation,
    UnheardVehicle,
    VehicleNow,
    VehicleSpec,
)
from rocsafe_orchestrator.mission.status import (
    GROUNDED,
    FlightState,
    Monitor,
    VehicleStatus,
)
from rocsafe_ros.conversions import point_of_position, region_of_area
from rocsafe_scenario.blocks.cameras import CameraBlock
from rocsafe_scenario.blocks.mission import RegionBlock
from rocsafe_scenario.blocks.vehicles import VehicleBlock
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.search_reserve import planned_endurance_s


def region_of_scenario(scenario: Scenario) -> Region:
    """Return the region to survey, without a stamp."""
    return _region(scenario.area(), scenario.region)


def _region(area: SurveyArea, block: RegionBlock) -> Region:
    region = region_of_area(area)
    region.sensors = list(block.sensors)
    return region


def plan_goal(scenario: Scenario) -> PlanSurvey.Goal:
    """Return the request to the planner."""
    survey = scenario.survey
    return PlanSurvey.Goal(
        region=region_of_scenario(scenario),
        exclusions=[region_of_area(zone) for zone in scenario.exclusion_areas()],
        other_regions=[
            _region(area, block)
            for area, block in zip(scenario.other_areas(), scenario.other_regions, strict=True)
        ],
        camera=camera_spec(scenario.camera),
        vehicles=[_vehicle_spec(scenario, vehicle) for vehicle in scenario.vehicles],
        coverage=SurveyCoverage(
            height_agl_m=survey.height_agl_m,
            spacing_rule=survey.spacing_rule,
            overlap_fraction=survey.overlap_fraction,
            front_overlap_fraction=-1.0
            if survey.front_overlap_fraction is None
            else survey.front_overlap_fraction,
            grid=survey.grid,
            max_viewpoints=survey.max_viewpoints,
        ),
        airspace=SurveyAirspace(
            clearance_m=survey.airspace.clearance_m,
            terrain_clearance_m=survey.airspace.terrain_clearance_m,
            max_height_agl_m=survey.airspace.max_height_agl_m,
            wind_east_mps=survey.airspace.wind_mps[0],
            wind_north_mps=survey.airspace.wind_mps[1],
        ),
        separation=SurveySeparation(
            distance_m=survey.separation.distance_m or -1.0, by=survey.separation.by
        ),
        effort=SurveyEffort(
            method=survey.effort.method,
            objective=survey.effort.objective,
            budget_s=survey.effort.budget_s,
            seed=scenario.seed,
        ),
        terrain_file=survey.terrain_file,
    )


def further_goal(
    goal: PlanSurvey.Goal, viewpoints: list[GeoPoint], flown: list[SurveyPlan]
) -> PlanSurvey.Goal:
    """Return `goal` for a further round to `viewpoints`, with what batteries still hold.

    Every vehicle begins where it has landed.
    """
    goal.viewpoints = viewpoints
    for vehicle in goal.vehicles:
        routes = (r for plan in flown for r in plan.routes if r.vehicle == vehicle.name)
        for route in (route for route in routes if route.viewpoints):
            # since the last change of its battery
            used_s = route.flights[-1].duration_s if route.flights else route.duration_s
            vehicle.endurance_s = max(1.0, vehicle.endurance_s - used_s)
            vehicle.home = _landing(route, vehicle)
    return goal


def _landing(route: Route, vehicle: VehicleSpec) -> GeoPoint:
    """Return where a route ends, on the ground."""
    if route.end:
        return route.end[0]
    if not route.is_open:
        return vehicle.home
    last = route.viewpoints[-1]
    place: GeoPoint = last.position
    return GeoPoint(
        latitude=place.latitude,
        longitude=place.longitude,
        altitude=place.altitude - last.height_agl_m,
    )


def rest_goal(
    scenario: Scenario,
    plans: tuple[SurveyPlan, Mapping[tuple[str, str], Route]],
    monitor: Monitor,
    able: Container[str],
    unheard: Iterable[str] = (),
) -> PlanSurvey.Goal:
    """Return the request for the rest of a survey, for those that are able.

    Photographs that another vehicle has not handed over count as not taken. Who has landed away
    from home stays there, and so does every real vehicle that has landed: it starts again by hand
    only.

    Parameters
    ----------
    scenario
        What is surveyed, by which vehicles.
    plans
        The present plan, and the routes of all plans by their plan id and vehicle: a vehicle that
        was not heard for a while has flown one of an earlier plan.
    monitor
        What is known of the vehicles.
    able
        Names of the vehicles that can be given a route.
    unheard
        Names of those that are in no plan: nothing is heard of them, or others have them. The
        vehicles of the plan stay away from where those may be that may be in the air.
    """
    plan, routes = plans
    left = {viewpoint.id for route in plan.routes for viewpoint in route.viewpoints}
    visited: set[int] = set()
    for vehicle in scenario.vehicles:
        status = monitor.vehicle(vehicle.name)
        flown = routes.get((status.plan_id, vehicle.name))
        if flown is None:
            continue
        count = status.viewpoints_visited
        if vehicle.name not in able:
            count = max(0, count - status.shots_pending)
        visited |= left & {viewpoint.id for viewpoint in flown.viewpoints[:count]}
    away = {route.vehicle for route in plan.routes if route.viewpoints and _ends_away(route)}
    able_now = [
        _vehicle_now(vehicle, monitor.vehicle(vehicle.name))
        for vehicle in scenario.vehicles
        if vehicle.name in able
        and not (
            (vehicle.name in away or vehicle.link)
            and monitor.vehicle(vehicle.name).state is FlightState.LANDED
        )
    ]
    homes = {
        vehicle.name: point_of_position(scenario.ground_position(vehicle.home))
        for vehicle in scenario.vehicles
    }
    return PlanSurvey.Goal(
        rest_of=plan.plan_id,
        visited=sorted(visited),
        able=able_now,
        unheard=_in_the_air(unheard, routes, monitor, homes),
        terrain_file=scenario.survey.terrain_file,
    )


def _in_the_air(
    unheard: Iterable[str],
    routes: Mapping[tuple[str, str], Route],
    monitor: Monitor,
    homes: Mapping[str, GeoPoint],
) -> list[UnheardVehicle]:
    """Return what is known of vehicles that are in no plan, unless they stood for good."""
    found = []
    for name in sorted(unheard):
        status = monitor.vehicle(name)
        flown = routes.get((status.plan_id, name))
        may_fly = status.state not in GROUNDED or status.is_waiting
        if flown is not None and flown.viewpoints and may_fly:
            last = [] if status.position is None else [point_of_position(status.position)]
            places = [viewpoint.position for viewpoint in flown.viewpoints]
            # It lands where its route ends, or at home.
            found += [
                UnheardVehicle(
                    name=name,
                    flight_height_m=flown.flight_height_m,
                    home=home,
                    places=[*last, *places],
                )
                for home in (homes[name], *flown.end)
            ]
    return found


def _ends_away(route: Route) -> bool:
    return bool(route.end) or bool(route.is_open)


def _vehicle_now(vehicle: VehicleBlock, status: VehicleStatus) -> VehicleNow:
    charge = status.battery_fraction
    used_s = 0.0 if math.isnan(charge) else (1.0 - charge) * vehicle.endurance_s
    is_aloft = status.state not in GROUNDED and status.position is not None
    place = [point_of_position(status.position)] if is_aloft and status.position else []
    return VehicleNow(name=vehicle.name, position=place, used_s=max(0.0, used_s))


def viewpoint_count(plan: SurveyPlan) -> int:
    """Return the number of viewpoints on all routes of `plan`."""
    return sum(len(route.viewpoints) for route in plan.routes)


def unseen_viewpoint(scenario: Scenario, plan: SurveyPlan) -> str:
    """Return why a vehicle of `plan` cannot photograph flat ground; empty if all can."""
    if scenario.camera.backend != 'flat' or not scenario.simulated:
        return ''
    over_terrain = [route for route in plan.routes if route.follows_terrain]
    altitudes_m = [v.position.altitude for route in over_terrain for v in route.viewpoints]
    lowest_m, ground_m = min(altitudes_m, default=math.inf), scenario.origin.ground_altitude_m
    if lowest_m > ground_m:
        return ''
    return (
        f'origin.ground_altitude_m = {ground_m:g} is above a viewpoint over the terrain, at '
        f'{lowest_m:.1f}: it must be that of the lowest ground, or camera.backend engine'
    )


def camera_spec(camera: CameraBlock) -> CameraSpec:
    """Return what planning needs to know of the camera."""
    return CameraSpec(
        horizontal_fov_rad=math.radians(camera.horizontal_fov_deg),
        image_width_px=camera.image_width_px,
        image_height_px=camera.image_height_px,
    )


def _vehicle_spec(scenario: Scenario, vehicle: VehicleBlock) -> VehicleSpec:
    return VehicleSpec(
        name=vehicle.name,
        home=point_of_position(scenario.ground_position(vehicle.home)),
        cruise_speed_mps=vehicle.cruise_speed_mps,
        acceleration_mps2=vehicle.acceleration_mps2,
        climb_rate_mps=vehicle.climb_rate_mps,
        descent_rate_mps=vehicle.descent_rate_mps,
        hover_s=vehicle.hover_s,
        endurance_s=planned_endurance_s(scenario, vehicle),
        battery_swap_s=-1.0 if vehicle.battery_swap_s is None else vehicle.battery_swap_s,
        end=[]
        if vehicle.end is None
        else [point_of_position(scenario.ground_position(vehicle.end))],
        is_open=vehicle.is_open,
        sensors=list(vehicle.sensors),
        cruise_power_w=vehicle.cruise_power_w,
        hover_power_w=vehicle.hover_power_w,
        autopilot=Autopilot(**vehicle.autopilot.model_dump()),
    )
