# SPDX-License-Identifier: Apache-2.0
"""Commands to a vehicle, and the motion that follows from each."""

from dataclasses import dataclass
from enum import Enum

from rocsafe_geo.motion.state import Enu
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.fall import Fall
from rocsafe_sim.flight.route import FlightRoute
from rocsafe_sim.flight.segment import FlightPose
from rocsafe_sim.flight.tasks import (
    fly_timeline,
    go_to_timeline,
    hold_timeline,
    land_timeline,
    return_timeline,
)
from rocsafe_sim.flight.timeline import Timeline


class CommandKind(Enum):
    """What a command asks for."""

    FLY = 'fly'
    HOLD = 'hold'
    GO_TO = 'go to'
    RETURN = 'return'
    DIVERT = 'divert'
    LAND = 'land'
    FALL = 'fall'


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """A command with the state in which it reached the vehicle; both determine the flight.

    Attributes
    ----------
    kind
        What the command asks for.
    start_ns
        Simulated time at which it takes effect, nanoseconds.
    wait_ns
        Time on the ground before that, nanoseconds.
    hover_s
        Time to stand in the air after that before it is carried out, seconds.
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
    goal_enu
        Place in the air to fly to, or on the ground to return to instead of home, metres.
    speed_mps
        Speed over ground; 0: that of the vehicle.
    is_held
        Whether it stays on the ground, where it waits, until it is resumed.
    """

    kind: CommandKind
    start_ns: int
    start: FlightPose
    first_index: int
    charge_fraction: float
    distance_m: float
    number: int = 0
    wait_ns: int = 0
    hover_s: float = 0.0
    ground_up_m: float | None = None
    goal_enu: Enu | None = None
    speed_mps: float = 0.0
    is_held: bool = False


def timeline_of(command: Command, route: FlightRoute, airframe: Airframe) -> Timeline | Fall:
    """Return the motion that follows from a command."""
    if command.kind is CommandKind.FLY:
        from_here = (command.number, command.first_index)
        return fly_timeline(airframe, command.start, route, from_here, command.hover_s)
    if command.kind is CommandKind.HOLD:
        return hold_timeline(airframe, command.start)
    if command.kind is CommandKind.GO_TO and command.goal_enu is not None:
        return go_to_timeline(airframe, command.start, route, command.goal_enu)
    if command.kind is CommandKind.RETURN:
        place = command.goal_enu or route.home_enu
        return return_timeline(airframe, command.start, route, place)
    if command.kind is CommandKind.DIVERT:
        place = route.refuge(command.start.position_enu, command.number)
        return return_timeline(airframe, command.start, route, place)
    if command.kind is CommandKind.FALL:
        below = route.ground_below(command.start.position_enu)[2]
        return Fall(command.start, below if command.ground_up_m is None else command.ground_up_m)
    return land_timeline(airframe, command.start, route, command.ground_up_m)
