# SPDX-License-Identifier: Apache-2.0
"""What an operator may order in flight, as errands for a kind of autopilot.

Only people give orders: nothing here is done because a link came back or a failsafe is over.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from rocsafe_geo.limits import require_between
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.autopilots.autopilot import Autopilot, Verb
from rocsafe_mavlink.flight.command_sequence import (
    CommandStep,
    Errand,
    Shown,
    Step,
    TransferStep,
    at_once,
)
from rocsafe_mavlink.flight.fence import Fence, fence_items
from rocsafe_mavlink.flight.flight_plan import Mission
from rocsafe_mavlink.flight.preflight import FlightLimits
from rocsafe_mavlink.knowledge.vehicle import Home, MissionPhase, Vehicle
from rocsafe_mavlink.protocols import command_call as commands
from rocsafe_mavlink.protocols.command_call import CommandCall
from rocsafe_mavlink.protocols.mission_item import GLOBAL_INT, RELATIVE_INT, MissionItem
from rocsafe_mavlink.protocols.mission_results import MissionType
from rocsafe_mavlink.protocols.mission_transfer import transfer
from rocsafe_mavlink.wire.authority import DO_REPOSITION
from rocsafe_mavlink.wire.dialect import Message, addressed
from rocsafe_mavlink.wire.units import e7_of_deg

Writer = Callable[['Desk', Vehicle], Errand]
CHANGE_MODE = 1.0
AS_IT_IS = -1.0
SLOWEST_MPS, FASTEST_MPS = 0.5, 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Desk:
    """Where orders are written: for one vehicle, from us.

    Attributes
    ----------
    autopilot: of the vehicle.
    target: its (system, component).
    us: ours.
    """

    autopilot: Autopilot
    target: tuple[int, int]
    us: tuple[int, int]

    def hold(self, vehicle: Vehicle) -> Errand:
        """Return the order to stand still: within the mission if it flies one."""
        if self.autopilot.is_in(vehicle, Verb.MISSION):
            return self._errand('hold', self._pause())
        return self._errand('hold', self._mode(Verb.HOLD))

    def resume(self, vehicle: Vehicle) -> Errand:
        """Return the order to go on with the mission."""
        if self.autopilot.is_in(vehicle, Verb.MISSION):
            return self._errand('resume', self._continue())
        return self._errand('resume', self._mode(Verb.MISSION))

    def return_home(self) -> Errand:
        """Return the order to fly home and land there."""
        return self._errand('return home', self._mode(Verb.RETURN))

    def land(self) -> Errand:
        """Return the order to land where it is."""
        return self._errand('land', self._mode(Verb.LAND))

    def change_speed(self, speed_mps: float) -> Errand:
        """Return the order to fly at `speed_mps`; ValueError if nothing flies so."""
        require_between('speed_mps', speed_mps, SLOWEST_MPS, FASTEST_MPS, 'm/s')
        return self._errand('speed', self._do(commands.change_speed(self.target, speed_mps)))

    def go_to(self, place: GeoPosition, height_m: float, home: Home) -> Errand:
        """Return the order to fly to a place, `height_m` above home, and stay there."""
        steps = [] if self.autopilot.repositions_itself else [self._mode(Verb.GUIDED)]
        return self._errand('go to', *steps, self._do(self._reposition(place, height_m, home)))

    def push_fence(self, fence: Fence) -> Errand:
        """Return the order to replace the polygons of the fence."""
        return self.push(MissionType.FENCE, fence_items(fence))

    def push(self, kind: MissionType, items: tuple[MissionItem, ...]) -> Errand:
        """Return the order to replace fence or rally points by `items`."""
        moving = transfer(items, self.target, first_compared=0, mission_type=kind)
        return self._errand(kind.name.lower(), TransferStep(moving=moving))

    def fly_instead(self, mission: Mission) -> Errand:
        """Return the order to stop, take another mission, and fly it from after its take-off.

        It stops in a mode of its own: an ArduCopter that only pauses its mission goes on by itself
        as soon as it has another one, before that was read back.
        """
        items = transfer(
            mission.items,
            self.target,
            first_compared=1 if self.autopilot.has_home_item else 0,
            clears_after_failure=False,
        )
        return self._errand(
            'new route',
            self._mode(Verb.HOLD),
            TransferStep(moving=items),
            *self._begin_in_air(mission),
        )

    def _errand(self, name: str, *steps: Step) -> Errand:
        return Errand(name=name, target=self.target, steps=steps)

    def _do(self, order: Message, is_shown: Shown = at_once) -> CommandStep:
        return CommandStep(call=CommandCall(command=order, us=self.us), is_shown=is_shown)

    def _mode(self, verb: Verb) -> CommandStep:
        def is_shown(vehicle: Vehicle) -> bool:
            return self.autopilot.is_in(vehicle, verb)

        return self._do(self.autopilot.mode_command(verb, self.target), is_shown)

    def _pause(self) -> CommandStep:
        """Return how it stops: an ArduPilot pauses its mission only between waypoints.

        While it climbs, stands at a waypoint or returns it refuses, and is told to brake.
        """
        brake = self._mode(Verb.HOLD)
        if not self.autopilot.pauses_missions:
            return brake
        return replace(self._do(commands.pause(self.target), _is_paused), otherwise=brake)

    def _continue(self) -> CommandStep:
        """Return how it goes on after `_pause`."""
        switch = self._mode(Verb.MISSION)
        if not self.autopilot.pauses_missions:
            return switch
        return replace(self._do(commands.resume(self.target), _is_active), otherwise=switch)

    def _begin_in_air(self, mission: Mission) -> list[CommandStep]:
        """Return how it begins a mission in the air."""
        first = mission.first_item
        is_at_first = _flies_to(first, mission.waypoint_items[0])
        switch = self._mode(Verb.MISSION)
        if not self.autopilot.starts_anywhere:
            return [self._do(commands.set_current(self.target, first), is_at_first), switch]

        def is_shown(vehicle: Vehicle) -> bool:
            return switch.is_shown(vehicle) and is_at_first(vehicle)

        return [self._do(commands.start_mission(self.target, first), is_shown)]

    def _reposition(self, place: GeoPosition, height_m: float, home: Home) -> Message:
        by_itself = self.autopilot.repositions_itself
        return addressed(
            'COMMAND_INT',
            self.target,
            frame=GLOBAL_INT if by_itself else RELATIVE_INT,
            command=DO_REPOSITION,
            param1=AS_IT_IS,
            param2=CHANGE_MODE if by_itself else 0.0,
            param4=math.nan,
            x=e7_of_deg(place.latitude_deg),
            y=e7_of_deg(place.longitude_deg),
            z=height_m + home.altitude_msl_m if by_itself else height_m,
        )


def require_reachable(
    place: GeoPosition, height_m: float, home: Home | None, limits: FlightLimits
) -> Home:
    """Return home if a place may be flown to.

    Raises
    ------
    ValueError: naming the number and its limit.
    """
    if home is None:
        raise ValueError('the vehicle has not told its home')
    require_between('height_m', height_m, limits.lowest_m, limits.highest_m, 'm')
    away_m = distance_m(GeoPosition(home.latitude_deg, home.longitude_deg), place)
    require_between('distance from home', away_m, 0.0, limits.furthest_m, 'm')
    return home


def _is_paused(vehicle: Vehicle) -> bool:
    # Old autopilots do not tell.
    return vehicle.mission.phase in (MissionPhase.PAUSED, MissionPhase.UNKNOWN)


def _is_active(vehicle: Vehicle) -> bool:
    return vehicle.mission.phase in (MissionPhase.ACTIVE, MissionPhase.UNKNOWN)


def _flies_to(first: int, last: int) -> Shown:
    def is_shown(vehicle: Vehicle) -> bool:
        return first <= vehicle.mission.current <= last

    return is_shown
