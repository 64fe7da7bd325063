# SPDX-License-Identifier: Apache-2.0
"""Drives of real ground vehicles <-> messages."""

import math

from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.action import DriveRoute
from rocsafe_interfaces.msg import GroundRoute, GroundStop
from rocsafe_mavlink.drone.drone import DroneSpec
from rocsafe_mavlink.drone.flight_record import FlightSummary
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint
from rocsafe_ros.conversions import position_of_point

# Numbers of the photographs of evidence: no viewpoint of a survey has one of these.
FIRST_EVIDENCE_ID = 2**31
OUTCOMES = {
    FlightOutcome.COMPLETED: DriveRoute.Result.COMPLETED,
    FlightOutcome.ABORTED_BY_OPERATOR: DriveRoute.Result.RETURNED_EARLY,
    FlightOutcome.FAILSAFE_BATTERY: DriveRoute.Result.BATTERY_LOW,
    FlightOutcome.REJECTED: DriveRoute.Result.REJECTED,
    FlightOutcome.LOST: DriveRoute.Result.LOST,
}


def drive_assignment(route: GroundRoute, spec: DroneSpec) -> Assignment:
    """Return the plan of a drive; the first stop is where the vehicle stands.

    Raises
    ------
    ValueError
        Naming what cannot be driven.
    """
    if len(route.stops) < 2:
        raise ValueError(f'the route has {len(route.stops)} stops: must be 2 or more')
    if not any(stop.evidence for stop in route.stops):
        raise ValueError('the route has no evidence: must have a stop for it')
    plan = FlightPlan(
        waypoints=tuple(_waypoint(stop) for stop in route.stops[1:]),
        speed_mps=spec.speed_mps,
        takes_photographs=spec.takes_photographs,
        home=_level(route.stops[0]),
        is_drive=True,
    )
    ids = [n for n, stop in enumerate(route.stops) if n and stop.evidence]
    return Assignment(
        plan_id=route.route_id,
        plan=plan,
        viewpoint_ids=tuple(FIRST_EVIDENCE_ID + number for number in ids),
    )


def _waypoint(stop: GroundStop) -> FlightWaypoint:
    return FlightWaypoint(
        position=_level(stop),
        height_m=0.0,
        hold_s=stop.dwell_s,
        is_bend=not stop.evidence,
        speed_mps=stop.speed_limit_mps or None,
    )


def _level(stop: GroundStop) -> GeoPosition:
    place = position_of_point(stop.position)
    return GeoPosition(place.latitude_deg, place.longitude_deg, 0.0)


def drive_result(summary: FlightSummary, route: GroundRoute) -> DriveRoute.Result:
    """Return the result of a drive that has ended; its dose is not known."""
    is_complete = summary.outcome is FlightOutcome.COMPLETED
    words = ': '.join(filter(None, (summary.outcome.value, summary.text)))
    return DriveRoute.Result(
        outcome=OUTCOMES.get(summary.outcome, DriveRoute.Result.ABORTED),
        error_msg='' if is_complete else words,
        evidence_taken=_evidence(route)[: summary.visited],
        distance_driven_m=summary.distance_m,
        duration_s=summary.duration_s,
        dose_usv=math.nan,
    )


def drive_failure(route: GroundRoute, text: str, outcome: str, visited: int) -> DriveRoute.Result:
    """Return the result of a drive before its end, after `visited` stops at evidence."""
    return DriveRoute.Result(
        outcome=getattr(DriveRoute.Result, outcome),
        error_msg=text,
        evidence_taken=_evidence(route)[:visited],
    )


def _evidence(route: GroundRoute) -> list[str]:
    return [stop.evidence for stop in route.stops[1:] if stop.evidence]
