# SPDX-License-Identifier: Apache-2.0
"""State from which a restarted vehicle continues its flight; it changes with events, not steps."""

from dataclasses import dataclass, field
from enum import Enum

from rocsafe_geo.motion.state import Enu
from rocsafe_sim.flight.commands import Command
from rocsafe_sim.flight.fence import Fence
from rocsafe_sim.flight.route import FlightRoute


class FlightOutcome(Enum):
    """How a flight ended."""

    COMPLETED = 'completed'
    CANCELLED = 'cancelled'
    RETURNED_EARLY = 'returned early'
    BATTERY_LOW = 'battery low'
    FAILED = 'failed'
    COLLIDED = 'collided'


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRecord:
    """One flight, running or ended.

    Attributes
    ----------
    route
        Route of the flight.
    command
        Command in force.
    take_off_ns
        Time at which the flight began, nanoseconds.
    take_off_distance_m
        Distance flown before it since power-up, metres.
    visited
        Number of viewpoints photographed on it.
    outcome
        Outcome; None while it runs.
    ending
        Outcome that it will have at touch-down.
    text
        Reason of the outcome, for people.
    ended_ns
        Time at which it ended, nanoseconds; None while it runs.
    """

    route: FlightRoute
    command: Command
    take_off_ns: int
    take_off_distance_m: float
    visited: int = 0
    outcome: FlightOutcome | None = None
    ending: FlightOutcome = FlightOutcome.COMPLETED
    text: str = ''
    ended_ns: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleRecord:
    """State of a vehicle.

    Attributes
    ----------
    home_enu
        Place where it was switched on, metres.
    shots_taken
        Photographs since power-up; the number of the next one.
    flight
        Last flight; None before the first.
    fence
        Its geofence.
    rally_enu
        Places on the ground to return to, if nearer than home, metres.
    speed_mps
        Speed over ground of the flight under way; 0: that of the vehicle.
    wind_mps
        Wind to the east and to the north, m/s; None: that of the vehicle.
    """

    home_enu: Enu
    shots_taken: int = 0
    flight: FlightRecord | None = None
    fence: Fence = field(default_factory=Fence)
    rally_enu: tuple[Enu, ...] = ()
    speed_mps: float = 0.0
    wind_mps: tuple[float, float] | None = None
