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
    move_timeline,
    return_timeline,
)
from rocsafe_sim.flight.timeline import Timeline


class CommandKind(Enum):
    """What a command asks for."""

    FLY = 'fly'
    HOLD = 'hold'
    GO_TO = 'go to'
    MOVE = 'move'
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
    via_enu
        Places in the air to pass on the way to it, metres.
    velocity_enu
        Velocity to fly at, m/s.
    flown_s
        Time to fly at it, seconds.
    turn_rate_radps
        Yaw rate meanwhile, anticlockwise from above.
    yaw_rad
        Yaw at the end of a way, or to turn to at a velocity, rad, ENU; None: the present one.
    speed_mps
        Speed over ground; 0: that of the vehicle.
    wind_mps
        Wind to the east and to the north; None: that of the vehicle.
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
    via_enu: tuple[Enu, ...] = ()
    velocity_enu: Enu | None = None
    flown_s: float = 0.0
    turn_rate_radps: float = 0.0
    yaw_rad: float | None = None
    speed_mps: float = 0.0
    wind_mps: tuple[float, float] | None = None
    is_held: bool = False


def timeline_of(command: Command, route: FlightRoute, airframe: Airframe) -> Timeline | Fall:
    """Return the motion that follows from a command."""
    if command.kind is CommandKind.FLY:
        from_here = (command.number, command.first_index)
        return fly_timeline(airframe, command.start, route, from_here, command.hover_s)
    if command.kind is CommandKind.HOLD:
        return hold_timeline(airframe, command.start)
    if command.kind is CommandKind.GO_TO and command.goal_enu is not None:
        goals = (*command.via_enu, command.goal_enu)
        return go_to_timeline(airframe, command.start, route, goals, command.yaw_rad)
    if command.kind is CommandKind.MOVE and command.velocity_enu is not None:
        velocity = (command.velocity_enu, command.flown_s)
        turn = (command.turn_rate_radps, command.yaw_rad)
        return move_timeline(airframe, command.start, velocity, *turn)
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
