# SPDX-License-Identifier: Apache-2.0
"""Outcomes of flights -> results of fly_route."""

from rocsafe_interfaces.action import FlyRoute
from rocsafe_mavlink.drone.flight_record import FlightSummary
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome

OUTCOMES = {
    FlightOutcome.COMPLETED: FlyRoute.Result.COMPLETED,
    FlightOutcome.ABORTED_BY_OPERATOR: FlyRoute.Result.RETURNED_EARLY,
    FlightOutcome.FAILSAFE_BATTERY: FlyRoute.Result.BATTERY_LOW,
    FlightOutcome.FAILSAFE_LINK: FlyRoute.Result.FAILSAFE_LINK,
    FlightOutcome.FAILSAFE_FENCE: FlyRoute.Result.FAILSAFE_FENCE,
    FlightOutcome.FAILSAFE_GPS: FlyRoute.Result.FAILSAFE_POSITION,
    FlightOutcome.FAILSAFE_OTHER: FlyRoute.Result.ABORTED,
    FlightOutcome.REJECTED: FlyRoute.Result.REJECTED,
    FlightOutcome.RESTARTED: FlyRoute.Result.ABORTED,
    FlightOutcome.LOST: FlyRoute.Result.LOST,
}


def result_message(summary: FlightSummary, shots: int) -> FlyRoute.Result:
    """Return the result of a flight that has ended."""
    is_complete = summary.outcome is FlightOutcome.COMPLETED
    words = ': '.join(filter(None, (summary.outcome.value, summary.text)))
    return FlyRoute.Result(
        outcome=OUTCOMES[summary.outcome],
        error_msg='' if is_complete else words,
        viewpoints_visited=summary.visited,
        shots_taken=shots,
        distance_flown_m=summary.distance_m,
        duration_s=summary.duration_s,
    )


def failure_message(text: str, outcome: str, visited: int, shots: int) -> FlyRoute.Result:
    """Return the result of a flight before its end; `outcome` is the name of the constant."""
    return FlyRoute.Result(
        outcome=getattr(FlyRoute.Result, outcome),
        error_msg=text,
        viewpoints_visited=visited,
        shots_taken=shots,
    )
