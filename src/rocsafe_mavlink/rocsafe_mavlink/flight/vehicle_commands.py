# SPDX-License-Identifier: Apache-2.0
"""Sequences of commands for one kind of autopilot: start a flight, hold, resume, go to, ...

Nothing here decides when to command. Flights start by `fly_route`; all else is commanded by people
only, never because a link came back or a failsafe is over.
"""

import math
from dataclasses import dataclass, replace

from rocsafe_geo.limits import require_between
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.autopilots.autopilot import Autopilot, Verb
from rocsafe_mavlink.flight.command_sequence import CommandSequence
from rocsafe_mavlink.flight.command_step import CommandStep, Refusal, Shown, Step, TransferStep
from rocsafe_mavlink.flight.flight_signs import home_moved, mission_changed
from rocsafe_mavlink.knowledge.telemetry import Home, Landed, MissionPhase, VehicleTelemetry
from rocsafe_mavlink.plan.fence import Fence, fence_items
from rocsafe_mavlink.plan.flight_limits import FlightLimits
from rocsafe_mavlink.plan.flight_plan import Mission
from rocsafe_mavlink.protocols import command_call as calls
from rocsafe_mavlink.protocols.command_call import CommandCall
from rocsafe_mavlink.protocols.mission_item import GLOBAL_INT, RELATIVE_INT, MissionItem
from rocsafe_mavlink.protocols.mission_results import MissionType
from rocsafe_mavlink.protocols.mission_transfer import transfer
from rocsafe_mavlink.wire.authority import DO_REPOSITION
from rocsafe_mavlink.wire.dialect import Message, addressed
from rocsafe_mavlink.wire.units import e7_of_deg

CHANGE_MODE = 1.0
UNCHANGED = -1.0
# An autopilot flies to the place of an order if its aim is within this distance of it, metres.
AIM_M, AIM_HEIGHT_M = 2.0, 3.0
SLOWEST_MPS, FASTEST_MPS = 0.5, 30.0
# Time that arming waits for a vehicle in the way, or for a check, seconds.
ARMING_LASTS_S = 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleCommands:
    """Makes the command sequences for one vehicle.

    Attributes
    ----------
    autopilot
        Kind of autopilot of the vehicle.
    target
        (system, component) of the vehicle.
    us
        Our own (system, component).
    """

    autopilot: Autopilot
    target: tuple[int, int]
    us: tuple[int, int]

    def start_flight(
        self, mission: Mission, home: Home, may_not_arm: Refusal | None = None
    ) -> CommandSequence:
        """Return the sequence that uploads a mission, arms and starts; `home` is the planned one.

        A flight is refused after arming if the home has moved: heights would not be those of the
        plan.

        Parameters
        ----------
        mission
            What is to be flown.
        home
            Home before the flight.
        may_not_arm
            Repeats the pre-flight checks before the motors are started; None: there are none.
        """
        autopilot = self.autopilot
        steps = (
            self._mode(autopilot.arms_in),
            *([self._set_first(mission)] if autopilot.drives else []),
            replace(
                self._do(calls.arm(self.target), lambda vehicle: vehicle.is_armed),
                refusal=self._not_in(autopilot.arms_in),
                obstacle=_unless_armed(may_not_arm),
                patience_s=ARMING_LASTS_S,
            ),
            replace(
                self._mode(Verb.MISSION),
                # A rover sets its home where it is armed, and drives at no height above it.
                refusal=lambda vehicle, _now_s: (
                    '' if autopilot.drives else home_moved(home, vehicle.home)
                ),
            ),
            replace(
                self._do(calls.start_mission(self.target)),
                is_shown_unanswered=_takes_off,
                modes=frozenset({autopilot.modes[Verb.MISSION]}),
            ),
        )
        *before, last = (self._unless_changed(mission, step) for step in steps)
        # A PX4 is told the first item with the start. A rover is told it before: it keeps that of
        # a drive within which it was switched off.
        if autopilot.drives:
            before[2:] = [_unless_past(mission.first_place, step) for step in before[2:]]
        elif not autopilot.starts_anywhere:
            before = [_unless_past(mission.first_item, step) for step in before]
        return self._sequence('flight', self._upload(mission), *before, last)

    def disarm(self) -> CommandSequence:
        """Return the sequence that stops the motors, on the ground only."""
        return self._sequence('disarm', self._stop())

    def stay_down(self, name: str, verb: Verb) -> CommandSequence:
        """Return the sequence that stops the motors; in the air the mode for `verb` is set."""
        return self._urgent(name, replace(self._stop(), otherwise=self._mode(verb)))

    def nothing(self, name: str) -> CommandSequence:
        """Return the sequence of an order that is fulfilled already."""
        return self._urgent(name)

    def hold(self, vehicle: VehicleTelemetry) -> CommandSequence:
        """Return the sequence that stops the vehicle: within its mission if it flies one.

        An old autopilot does not tell that it has paused: it is switched to another mode.
        """
        is_told = vehicle.mission.phase is not MissionPhase.UNKNOWN
        if is_told and self.autopilot.is_in(vehicle, Verb.MISSION):
            return self._urgent('hold', self._pause())
        return self._urgent('hold', self._mode(Verb.HOLD))

    def resume(
        self, vehicle: VehicleTelemetry, mission: Mission, may_not_go: Refusal
    ) -> CommandSequence:
        """Return the sequence that reads the mission again and continues it.

        Another station may have changed it. It is not continued if `may_not_go` names a reason.
        """
        is_paused = self.autopilot.is_in(vehicle, Verb.MISSION)
        step = self._continue() if is_paused else self._mode(Verb.MISSION)
        reading = transfer(
            mission.items,
            self.target,
            first_compared=self.autopilot.first_own_item,
            reads_only=True,
        )
        go_on = self._unless_changed(mission, _unless(may_not_go, step))
        return self._sequence('resume', TransferStep(moving=reading), go_on)

    def return_home(self, may_not_go: Refusal) -> CommandSequence:
        """Return the sequence that flies home and lands there, unless there is a reason not to."""
        return self._urgent('return home', _unless(may_not_go, self._mode(Verb.RETURN)))

    def fly_home(self, mission: Mission, may_not_go: Refusal) -> CommandSequence:
        """Return the sequence that flies home by a mission, where the straight way is not free.

        A failsafe withdraws it as any other mission.
        """
        return replace(self.replace_mission(mission, may_not_go), name='return home')

    def land(self) -> CommandSequence:
        """Return the sequence that lands where the vehicle is."""
        return self._urgent('land', self._mode(Verb.LAND))

    def change_speed(self, speed_mps: float) -> CommandSequence:
        """Return the sequence that sets the speed over ground.

        Raises
        ------
        ValueError
            If no multicopter flies at `speed_mps`.
        """
        require_between('speed_mps', speed_mps, SLOWEST_MPS, FASTEST_MPS, 'm/s')
        return self._sequence('speed', self._do(calls.change_speed(self.target, speed_mps)))

    def go_to(
        self, place: GeoPosition, height_m: float, home: Home, may_not_go: Refusal
    ) -> CommandSequence:
        """Return the sequence that flies to a place, `height_m` above home, and stays there.

        It is not sent there, and not again, if `may_not_go` names a reason.
        """
        by_itself = self.autopilot.repositions_itself
        steps = [] if by_itself else [self._mode(Verb.GUIDED)]
        leads_to = self.autopilot.modes[Verb.HOLD if by_itself else Verb.GUIDED]
        aims_there = _aims_at(place, height_m + home.altitude_msl_m)
        reposition = self._do(self._reposition(place, height_m, home), aims_there)
        reposition = replace(reposition, modes=frozenset({leads_to}))
        return self._sequence('go to', *steps, _unless(may_not_go, reposition))

    def push_fence(self, fence: Fence) -> CommandSequence:
        """Return the sequence that replaces the polygons of the fence."""
        return self.push(MissionType.FENCE, fence_items(fence))

    def push(self, kind: MissionType, items: tuple[MissionItem, ...]) -> CommandSequence:
        """Return the sequence that replaces fence or rally points by `items`."""
        moving = transfer(items, self.target, first_compared=0, mission_type=kind)
        return self._sequence(kind.word, TransferStep(moving=moving))

    def replace_mission(self, mission: Mission, may_not_go: Refusal) -> CommandSequence:
        """Return the sequence that stops, uploads another mission and flies it from its first leg.

        It stops in a mode of its own: an ArduCopter whose mission is only paused flies on by
        itself as soon as it has another one, before that was read back. It does not start if
        `may_not_go` then names a reason.
        """
        start = [
            self._unless_changed(mission, _unless(may_not_go, step))
            for step in self._start_in_air(mission)
        ]
        return self._sequence(
            'new route',
            self._mode(Verb.HOLD),
            self._upload(mission, clears_after_failure=False),
            *start,
        )

    def _sequence(self, name: str, *steps: Step) -> CommandSequence:
        return CommandSequence(
            name=name, target=self.target, autopilot=self.autopilot, steps=steps
        )

    def _urgent(self, name: str, *steps: Step) -> CommandSequence:
        return replace(self._sequence(name, *steps), is_always_taken=True)

    def _do(self, command: Message, is_shown: Shown | None = None) -> CommandStep:
        return CommandStep(call=CommandCall(command=command, us=self.us), is_shown=is_shown)

    def _stop(self) -> CommandStep:
        """Return the step that stops the motors; in the air it is neither begun nor repeated.

        Autopilots refuse it there, unless they take themselves for landed.
        """

        def refusal(vehicle: VehicleTelemetry, _now_s: float) -> str:
            is_flying = vehicle.is_airborne and not self.autopilot.drives
            return 'it is in the air' if is_flying else ''

        step = self._do(calls.disarm(self.target), lambda vehicle: not vehicle.is_armed)
        return replace(step, refusal=refusal)

    def _upload(self, mission: Mission, *, clears_after_failure: bool = True) -> TransferStep:
        moving = transfer(
            mission.items,
            self.target,
            first_compared=self.autopilot.first_own_item,
            clears_after_failure=clears_after_failure,
        )
        return TransferStep(moving=moving)

    def _mode(self, verb: Verb) -> CommandStep:
        def is_shown(vehicle: VehicleTelemetry) -> bool:
            return self.autopilot.is_in(vehicle, verb)

        step = self._do(self.autopilot.mode_command(verb, self.target), is_shown)
        return replace(step, modes=frozenset({self.autopilot.modes[verb]}))

    def _unless_changed(self, mission: Mission, step: CommandStep) -> CommandStep:
        """Return a step, and its alternative, that waits while another mission lies there."""
        count = len(mission.items) - self.autopilot.first_own_item

        def obstacle(vehicle: VehicleTelemetry, now_s: float) -> str:
            return mission_changed(count, vehicle) or step.obstacle(vehicle, now_s)

        otherwise = step.otherwise and self._unless_changed(mission, step.otherwise)
        return replace(step, obstacle=obstacle, otherwise=otherwise)

    def _not_in(self, verb: Verb) -> Refusal:
        def refusal(vehicle: VehicleTelemetry, _now_s: float) -> str:
            if self.autopilot.is_in(vehicle, verb):
                return ''
            mode = self.autopilot.mode_name(vehicle.custom_mode)
            return f'the vehicle was switched to {mode} before it was armed'

        return refusal

    def _pause(self) -> CommandStep:
        """Return the step that stops within a mission.

        An ArduPilot pauses only between waypoints. While it climbs, stands at a waypoint or
        returns it refuses, and is switched to BRAKE instead.
        """
        brake = self._mode(Verb.HOLD)
        if not self.autopilot.pauses_missions:
            return brake
        return replace(self._do(calls.pause(self.target), _is_paused), otherwise=brake)

    def _continue(self) -> CommandStep:
        """Return the step that goes on after `_pause`."""
        switch = self._mode(Verb.MISSION)
        if not self.autopilot.pauses_missions:
            return switch
        return replace(self._do(calls.resume(self.target), _is_active), otherwise=switch)

    def _set_first(self, mission: Mission) -> CommandStep:
        """Return the step that lets a drive begin at its first item."""
        is_first = _flies_to(mission.first_item, mission.first_place)
        return self._do(calls.set_current(self.target, mission.first_item), is_first)

    def _start_in_air(self, mission: Mission) -> list[CommandStep]:
        """Return the steps that start a mission in the air, behind its take-off item."""
        first = mission.first_item
        is_at_first = _flies_to(first, mission.waypoint_items[0])
        switch = self._mode(Verb.MISSION)
        if not self.autopilot.starts_anywhere:
            return [self._do(calls.set_current(self.target, first), is_at_first), switch]

        def is_shown(vehicle: VehicleTelemetry) -> bool:
            return self.autopilot.is_in(vehicle, Verb.MISSION) and is_at_first(vehicle)

        start = self._do(calls.start_mission(self.target, first), is_shown)
        return [replace(start, modes=switch.modes)]

    def _reposition(self, place: GeoPosition, height_m: float, home: Home) -> Message:
        by_itself = self.autopilot.repositions_itself
        return addressed(
            'COMMAND_INT',
            self.target,
            frame=GLOBAL_INT if by_itself else RELATIVE_INT,
            command=DO_REPOSITION,
            param1=UNCHANGED,
            param2=CHANGE_MODE if by_itself else 0.0,
            param4=math.nan,
            x=e7_of_deg(place.latitude_deg),
            y=e7_of_deg(place.longitude_deg),
            z=height_m + home.altitude_msl_m if by_itself else height_m,
        )


def require_reachable(
    place: GeoPosition, height_m: float, home: Home | None, limits: FlightLimits
) -> Home:
    """Return home if the vehicle may fly to a place.

    Raises
    ------
    ValueError
        Naming the number and its limit.
    """
    if home is None:
        raise ValueError('the vehicle has not told its home')
    require_between('height_m', height_m, limits.lowest_m, limits.max_height_agl_m, 'm')
    away_m = distance_m(GeoPosition(home.latitude_deg, home.longitude_deg), place)
    require_between('distance from home', away_m, 0.0, limits.furthest_m, 'm')
    return home


def _unless_past(first: int, step: CommandStep) -> CommandStep:
    """Return a step of a start that waits while the mission would begin past item `first`.

    Another station has chosen that item, or it is one of an earlier flight: the legs before it
    would be left out, and nobody has checked the way to it.
    """

    def obstacle(vehicle: VehicleTelemetry, now_s: float) -> str:
        item = vehicle.mission.current
        words = f'it would begin with item {item}: another station has chosen that'
        return words if item > first else step.obstacle(vehicle, now_s)

    return replace(step, obstacle=obstacle)


def _unless(may_not_go: Refusal, step: CommandStep) -> CommandStep:
    """Return a step, and its alternative, that is refused for a further reason."""
    otherwise = None if step.otherwise is None else _unless(may_not_go, step.otherwise)
    return replace(step, refusal=may_not_go, otherwise=otherwise)


def _unless_armed(may_not_arm: Refusal | None) -> Refusal:
    def obstacle(vehicle: VehicleTelemetry, now_s: float) -> str:
        # It is armed already where only the answer to the command was lost.
        if may_not_arm is None or vehicle.is_armed:
            return ''
        return may_not_arm(vehicle, now_s)

    return obstacle


def _takes_off(vehicle: VehicleTelemetry) -> bool:
    return vehicle.landed is Landed.TAKEOFF or vehicle.is_airborne


def _aims_at(place: GeoPosition, altitude_msl_m: float) -> Shown:
    """Whether a vehicle tells that it flies to a place; one that never tells is believed."""

    def is_shown(vehicle: VehicleTelemetry) -> bool:
        aim = vehicle.aim
        if aim is None:
            return not vehicle.tells_aim
        away_m = distance_m(GeoPosition(aim.latitude_deg, aim.longitude_deg), place)
        return away_m < AIM_M and abs(aim.altitude_msl_m - altitude_msl_m) < AIM_HEIGHT_M

    return is_shown


def _is_paused(vehicle: VehicleTelemetry) -> bool:
    return vehicle.mission.phase is MissionPhase.PAUSED


def _is_active(vehicle: VehicleTelemetry) -> bool:
    return vehicle.mission.phase in (MissionPhase.ACTIVE, MissionPhase.UNKNOWN)


def _flies_to(first: int, last: int) -> Shown:
    def is_shown(vehicle: VehicleTelemetry) -> bool:
        return first <= vehicle.mission.current <= last

    return is_shown
