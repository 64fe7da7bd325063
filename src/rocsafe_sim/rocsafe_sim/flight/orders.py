# SPDX-License-Identifier: Apache-2.0
"""Commands to a vehicle, and the motion that follows from each."""

from dataclasses import dataclass
from enum import Enum

from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.fall import Fall
from rocsafe_sim.flight.route import Route
from rocsafe_sim.flight.segment import Pose
from rocsafe_sim.flight.tasks import fly_timeline, hold_timeline, land_timeline, return_timeline
from rocsafe_sim.flight.timeline import Timeline


class OrderKind(Enum):
    """What a command asks for."""

    FLY = 'fly'
    HOLD = 'hold'
    RETURN = 'return'
    DIVERT = 'divert'
    LAND = 'land'
    FALL = 'fall'


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """A command with the state in which it reached the vehicle; both determine the flight.

    Attributes
    ----------
    kind
        What the command asks for.
    start_ns
        Simulated time at which it takes effect, nanoseconds.
    wait_ns
        Time on the ground before that, nanoseconds.
    start
        Pose at that time.
    first_index
        Index of the first viewpoint of the route that is not yet photographed.
    charge_fraction
        Charge of the battery at that time, 0 to 1.
    distance_m
        Horizontal distance flown until that time since power-up, metres.
    number
        Number of the flight of the route, from 0.
    ground_up_m
        Height of the ground to land or fall on, metres; None: as the route has it.
    """

    kind: OrderKind
    start_ns: int
    start: Pose
    first_index: int
    charge_fraction: float
    distance_m: float
    number: int = 0
    wait_ns: int = 0
    ground_up_m: float | None = None


def timeline_of(order: Order, route: Route, airframe: Airframe) -> Timeline | Fall:
    """Return the motion that follows from a command."""
    if order.kind is OrderKind.FLY:
        return fly_timeline(airframe, order.start, route, (order.number, order.first_index))
    if order.kind is OrderKind.HOLD:
        return hold_timeline(airframe, order.start)
    if order.kind is OrderKind.RETURN:
        return return_timeline(airframe, order.start, route, route.home_enu)
    if order.kind is OrderKind.DIVERT:
        place = route.refuge(order.start.position_enu, order.number)
        return return_timeline(airframe, order.start, route, place)
    if order.kind is OrderKind.FALL:
        below = route.ground_below(order.start.position_enu)[2]
        return Fall(order.start, below if order.ground_up_m is None else order.ground_up_m)
    return land_timeline(airframe, order.start, route, order.ground_up_m)
