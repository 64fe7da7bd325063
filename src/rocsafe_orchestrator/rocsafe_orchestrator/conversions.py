# SPDX-License-Identifier: Apache-2.0
"""Scenario and status <-> messages."""

import math
from collections.abc import Container, Iterable, Mapping

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_interfaces.action import FlyRoute, PlanSurvey
from rocsafe_interfaces.msg import (
    Autopilot,
    CameraSpec,
    DoseAlarm,
    GeoPoint,
    GeoPolygon,
    HazardSource,
    HazardSourceArray,
    MissionState,
    RadiationReading,
    Region,
    Route,
    SurveyAirspace,
    SurveyCoverage,
    SurveyEffort,
    SurveyPlan,
    SurveySeparation,
    VehicleNow,
    VehicleSpec,
    VehicleState,
)
from rocsafe_interfaces.msg import Decision as DecisionMessage
from rocsafe_orchestrator.mission.decisions import Decision
from rocsafe_orchestrator.mission.retreat import Danger, EstimatedSource, Retreat
from rocsafe_orchestrator.mission.status import (
    GROUNDED,
    FlightState,
    Monitor,
    RunStatus,
    VehicleStatus,
)
from rocsafe_ros.conversions import point_of_position, position_of_point, region_of_area
from rocsafe_scenario.camera_blocks import CameraBlock
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_blocks import RegionBlock, VehicleBlock

# What a flight that did not end as planned is called.
_FAULTS = {
    FlyRoute.Result.REJECTED: 'refused its route',
    FlyRoute.Result.CANCELLED: 'was cancelled',
    FlyRoute.Result.RETURNED_EARLY: 'returned early by request',
    FlyRoute.Result.BATTERY_LOW: 'returned early to keep its reserve of battery',
    FlyRoute.Result.ABORTED: 'aborted its flight',
    FlyRoute.Result.FAILSAFE_LINK: 'gave up its route because it heard nobody',
    FlyRoute.Result.FAILSAFE_FENCE: 'gave up its route because it left its fence',
    FlyRoute.Result.FAILSAFE_POSITION: 'gave up its route because it lost its position',
    FlyRoute.Result.LOST: 'was not heard for too long',
    FlyRoute.Result.COLLISION: 'flew into something',
}
_BY_REQUEST = (FlyRoute.Result.CANCELLED, FlyRoute.Result.RETURNED_EARLY)


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
    return PlanSurvey.Goal(
        rest_of=plan.plan_id,
        visited=sorted(visited),
        able=able_now,
        terrain_file=scenario.survey.terrain_file,
    )


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
        endurance_s=vehicle.usable_endurance_s,
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


def status_of_vehicle(message: VehicleState) -> VehicleStatus:
    """Return what a vehicle says about itself; a state that we do not know is unknown."""
    known = message.state in FlightState.__members__.values()
    return VehicleStatus(
        name=message.vehicle,
        state=FlightState(message.state) if known else FlightState.UNKNOWN,
        time_s=message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec,
        viewpoint_count=message.viewpoint_count,
        viewpoints_visited=message.viewpoints_visited,
        shots_taken=message.shots_taken,
        shots_pending=message.shots_pending,
        battery_fraction=message.battery_fraction,
        plan_id=message.plan_id,
        position=_position_of(message.position),
        speed_mps=message.speed_mps,
        is_simulated=message.is_simulated,
        ending=_ending_of(message),
        is_by_request=message.ending in _BY_REQUEST,
        taken_by=message.taken_by,
    )


def _ending_of(message: VehicleState) -> str:
    """Return why a flight will end otherwise than planned, empty if it will not."""
    if message.state == VehicleState.CRASHED and not message.ending:
        return 'crashed'
    if message.ending == FlyRoute.Result.COMPLETED:
        return ''
    fault = _FAULTS.get(message.ending, f'ends with outcome {message.ending}')
    return f'{fault}: {message.text}' if message.text else fault


def _position_of(point: GeoPoint) -> GeoPosition | None:
    """Return a position, None if it is not known."""
    if math.isnan(point.latitude) or (point.latitude, point.longitude) == (0.0, 0.0):
        return None
    return position_of_point(point)


def position_of_reading(message: RadiationReading) -> GeoPosition | None:
    """Return where a reading was taken, None without a fix."""
    if math.isnan(message.position.latitude) or math.isnan(message.position.longitude):
        return None
    return position_of_point(message.position)


def turn_back_text(message: DoseAlarm) -> str:
    """Return why a vehicle turns back."""
    unit = 'uSv' if message.quantity == DoseAlarm.DOSE else 'uSv/h'
    return (
        f'turns back at {message.value_usv:.3g} {unit}, the limit is '
        f'{message.threshold_usv:.3g} {unit}'
    )


def sources_of(message: HazardSourceArray) -> tuple[tuple[GeoPosition, float], ...]:
    """Return places and dose rates at 1 m of the estimated sources of gamma radiation."""
    return tuple(
        (position_of_point(source.position), source.dose_rate_at_1m_usvh)
        for source in message.sources
        if source.kind == HazardSource.GAMMA and math.isfinite(source.dose_rate_at_1m_usvh)
    )


def danger_of(
    scenario: Scenario, route: Route, monitor: Monitor, here: GeoPosition
) -> tuple[Danger, LocalFrame]:
    """Return what a vehicle on `route` that turns back at `here` has around it."""
    frame = LocalFrame(scenario.origin_position())
    speed_mps = next(v.cruise_speed_mps for v in scenario.vehicles if v.name == route.vehicle)

    def enu(place: GeoPosition) -> tuple[float, float, float]:
        east, north, up = frame.enu_of(place).tolist()
        return east, north, 0.0 if math.isnan(up) else up

    def rings(zones: Iterable[GeoPolygon]) -> tuple[tuple[tuple[float, float], ...], ...]:
        return tuple(
            tuple(enu(position_of_point(point))[:2] for point in zone.points) for zone in zones
        )

    flown = monitor.flown(route.vehicle)
    danger = Danger(
        here_enu=enu(here),
        home=enu(position_of_point(route.home))[:2],
        speed_mps=speed_mps,
        flown=tuple(enu(place)[:2] for place, _ in flown),
        flown_usvh=tuple(rate for _, rate in flown),
        sources=tuple(
            EstimatedSource(place_enu=enu(place), at_1m_usvh=rate)
            for place, rate in monitor.sources
        ),
        exclusions=rings(route.exclusions),
        clearance_m=route.clearance_m,
    )
    return danger, frame


def retreat_route(route: Route, way: Retreat, here: GeoPosition, frame: LocalFrame) -> Route:
    """Return the route home by a way, at the height of the vehicle."""
    up = float(frame.enu_of(here)[2])
    bends = [frame.position_of((east, north, up)) for east, north in way.bends]
    return Route(
        vehicle=route.vehicle,
        home=route.home,
        homeward=[point_of_position(bend) for bend in bends],
        exclusions=route.exclusions,
        clearance_m=route.clearance_m,
        flight_height_m=max(1.0, here.altitude_m - route.home.altitude),
    )


def fault_of_flight(result: FlyRoute.Result) -> str:
    """Return what went wrong with a flight, empty if nothing did."""
    if result.outcome == FlyRoute.Result.COMPLETED:
        return ''
    fault = _FAULTS.get(result.outcome, f'ended with outcome {result.outcome}')
    visited = f'after {result.viewpoints_visited} viewpoints'
    return f'{fault} {visited}' + (f': {result.error_msg}' if result.error_msg else '')


def decision_message(decision: Decision, by: str, wall_time_s: float) -> DecisionMessage:
    """Return a decision of the node `by` as a message, without a stamp."""
    return DecisionMessage(
        wall_time_s=wall_time_s,
        severity=decision.severity,
        kind=decision.kind,
        by=by,
        vehicles=list(decision.vehicles),
        text=decision.text,
        reason=decision.reason,
    )


def mission_state(
    status: RunStatus, mission_id: str, vehicles: list[VehicleState]
) -> MissionState:
    """Return `status` as a message, without a stamp."""
    peak = status.peak
    return MissionState(
        mission_id=mission_id,
        phase=int(status.phase),
        text=status.text,
        images_stored=status.images_stored,
        images_expected=status.images_expected,
        highest_dose_rate_usvh=math.nan if peak is None else peak.dose_rate_usvh,
        highest_dose_rate_vehicle='' if peak is None else peak.vehicle,
        mission_time_s=status.flight_time_s,
        wall_time_s=status.wall_time_s,
        vehicles=vehicles,
    )
