# SPDX-License-Identifier: Apache-2.0
"""Outcomes of flights -> results of fly_route."""

from rocsafe_interfaces.action import FlyRoute
from rocsafe_mavlink.drone.flight_record import FlightSummary
from rocsafe_mavlink.drone.status import RemainingRoute
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


def cancelled_message(remaining: RemainingRoute, shots: int, reason: str) -> FlyRoute.Result:
    """Return the result of a cancelled flight; `reason` says why it does not even hold."""
    outcome = FlyRoute.Result.ABORTED if reason else FlyRoute.Result.CANCELLED
    return FlyRoute.Result(
        outcome=outcome,
        error_msg=reason or 'cancelled by request: the vehicle holds',
        viewpoints_visited=remaining.visited,
        shots_taken=shots,
    )


def refusal_message(reason: str) -> FlyRoute.Result:
    """Return the result of a route that is not flown."""
    return FlyRoute.Result(outcome=FlyRoute.Result.REJECTED, error_msg=reason)
