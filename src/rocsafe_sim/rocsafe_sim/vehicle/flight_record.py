# SPDX-License-Identifier: Apache-2.0
"""All that a vehicle must remember to continue a flight: written at each change, not each step."""

from dataclasses import dataclass
from enum import Enum

from rocsafe_geo.motion.state import Enu
from rocsafe_sim.flight.orders import Order
from rocsafe_sim.flight.route import Route


class Outcome(Enum):
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
    route : being flown.
    order : in force.
    take_off_ns : when the flight began.
    take_off_distance_m : flown before it since power-up.
    visited : viewpoints photographed on it.
    outcome : None while it runs.
    ending : outcome that it will have at touch-down.
    text : for people: why it ends as it does.
    ended_ns : when it ended, None while it runs.
    """

    route: Route
    order: Order
    take_off_ns: int
    take_off_distance_m: float
    visited: int = 0
    outcome: Outcome | None = None
    ending: Outcome = Outcome.COMPLETED
    text: str = ''
    ended_ns: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleRecord:
    """A vehicle's memory.

    Attributes
    ----------
    home_enu : where it was put, metres.
    shots_taken : since power-up; the next photograph's sequence number.
    flight : the last one, None if it never flew.
    """

    home_enu: Enu
    shots_taken: int = 0
    flight: FlightRecord | None = None
