# SPDX-License-Identifier: Apache-2.0
"""Begin and end of flights: conditions, outcomes, changes of the battery."""

import math
from dataclasses import replace

from rocsafe_geo.motion.state import Enu
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.commands import Command, CommandKind
from rocsafe_sim.flight.course import Course
from rocsafe_sim.flight.route import FlightRoute, horizontal_m
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.flight_record import FlightOutcome, FlightRecord

# Largest distance between the home of a route and that of the vehicle: a route with a home further
# away is meant for another vehicle.
HOME_TOLERANCE_M = 5.0
# After a flight with such an outcome a vehicle does not fly again.
_BROKEN = frozenset({FlightOutcome.FAILED, FlightOutcome.COLLIDED})
_BUSY = frozenset({Mode.TAKING_OFF, Mode.FLYING, Mode.RETURNING, Mode.LANDING})


def require_ready(
    route: FlightRoute, flight: FlightRecord | None, mode: Mode, home_enu: Enu, *, replaces: bool
) -> None:
    """Refuse a route that a vehicle cannot fly now.

    Parameters
    ----------
    route
        Route of the command.
    flight, mode
        Last flight of the vehicle, running or ended, and its mode.
    home_enu
        Place where it stands or took off, metres.
    replaces
        Whether the route may replace one that is being flown.

    Raises
    ------
    CommandRefusedError
        If the vehicle cannot fly it; the text states why.
    """
    if flight is not None and flight.outcome is None and not replaces:
        raise CommandRefusedError(f'flies plan {flight.route.plan_id!r}: cancel that first')
    if flight is not None and flight.ending in _BROKEN:
        raise CommandRefusedError(f'cannot fly a route: {flight.text}')
    if mode is Mode.LANDING or (mode in _BUSY and not replaces):
        raise CommandRefusedError(f'cannot fly a route: {mode.value}')
    if not route.waypoints and not mode.is_airborne:
        raise CommandRefusedError(f'route of plan {route.plan_id!r} has 0 viewpoints: must have 1')
    off_m = horizontal_m(route.home_enu, home_enu)
    if off_m > HOME_TOLERANCE_M:
        raise CommandRefusedError(
            f'home of the route is {off_m:.1f} m from home of the vehicle: '
            f'must be within {HOME_TOLERANCE_M:g} m'
        )


def cut_short(flight: FlightRecord, ending: FlightOutcome, text: str) -> FlightRecord:
    """Return the flight with the reason why it ends early, unless it ended or is complete."""
    is_done = flight.visited == len(flight.route.waypoints)
    if is_done or flight.outcome is not None or flight.ending is not FlightOutcome.COMPLETED:
        return flight
    return replace(flight, ending=ending, text=text)


def failure_ns(flight: FlightRecord, course: Course, airframe: Airframe) -> int | float:
    """Return the time at which the battery fails; infinite if it does not, or already did."""
    if not airframe.fails_after_s or flight.ending in _BROKEN or course.command.is_held:
        return math.inf
    fails_ns = flight.take_off_ns + round(airframe.fails_after_s * NS_PER_S)
    return fails_ns if course.command.start_ns <= fails_ns < course.touch_down_ns else math.inf


def failed(flight: FlightRecord) -> FlightRecord:
    """Return the flight with the failure of its battery."""
    text = f'the battery failed after {flight.visited} viewpoints'
    return replace(flight, ending=FlightOutcome.FAILED, text=text)


def collided(flight: FlightRecord, thing: str) -> FlightRecord:
    """Return the flight with its collision."""
    text = f'flew into {thing} after {flight.visited} viewpoints'
    return replace(flight, ending=FlightOutcome.COLLIDED, text=text)


def is_over(flight: FlightRecord) -> bool:
    """Return whether a landing ends a flight, with no other flight of its route to follow."""
    is_whole = flight.command.kind is CommandKind.FLY and flight.ending is FlightOutcome.COMPLETED
    return not is_whole or flight.route.is_last(flight.command.number)


def with_new_battery(flight: FlightRecord, landed: Command) -> FlightRecord:
    """Return the next flight of a route, after the change of the battery."""
    swap_ns = round(flight.route.swap_s * NS_PER_S)
    command = replace(
        landed,
        start_ns=landed.start_ns + swap_ns,
        wait_ns=swap_ns,
        charge_fraction=1.0,
        number=landed.number + 1,
    )
    return replace(flight, command=command)
