# SPDX-License-Identifier: Apache-2.0
"""State of vehicles, hazards and mission <-> messages."""

import math
from collections.abc import Iterable

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import Decision as DecisionMessage
from rocsafe_interfaces.msg import (
    DoseAlarm,
    GeoPoint,
    GeoPolygon,
    HazardSource,
    HazardSourceArray,
    MissionState,
    RadiationReading,
    ReleaseEstimateArray,
    Route,
    VehicleState,
)
from rocsafe_orchestrator.mission.status import (
    FlightState,
    Monitor,
    RunStatus,
    VehicleStatus,
)
from rocsafe_orchestrator.watches.decisions import Decision
from rocsafe_orchestrator.watches.retreat import Danger, EstimatedSource, Retreat
from rocsafe_ros.conversions import point_of_position, position_of_point
from rocsafe_scenario.scenario import Scenario

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


def releases_of(message: ReleaseEstimateArray) -> tuple[tuple[GeoPosition, float], ...]:
    """Return places and rates, in the unit of the message, of the estimated releases."""
    return tuple((position_of_point(one.position), one.rate) for one in message.releases)


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
