# SPDX-License-Identifier: Apache-2.0
"""Differences between autopilots, as tables; `ardupilot` and `px4` fill them."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from rocsafe_mavlink.knowledge.telemetry import Contact, Landed, MissionPhase, VehicleTelemetry
from rocsafe_mavlink.protocols.command_call import command
from rocsafe_mavlink.wire.authority import DO_SET_MODE
from rocsafe_mavlink.wire.dialect import Message

CUSTOM_MODE_ENABLED = 1.0


class FlightState(Enum):
    """What a vehicle does; names are those of VehicleState.msg, after REP 147."""

    UNKNOWN = 'unknown'
    DISARMED = 'disarmed'
    ARMED = 'armed'
    TAKING_OFF = 'taking off'
    FLYING = 'flying'
    HOLDING = 'holding'
    RETURNING = 'returning'
    LANDING = 'landing'
    LANDED = 'landed'
    LOST = 'lost'
    WAITING = 'waiting'


class Verb(Enum):
    """Purposes of modes."""

    GUIDED = 'guided'
    MISSION = 'mission'
    HOLD = 'hold'
    RETURN = 'return'
    LAND = 'land'


@dataclass(frozen=True, slots=True, kw_only=True)
class Autopilot:
    """One kind of autopilot.

    Attributes
    ----------
    name
        Name for people.
    number
        MAV_AUTOPILOT in its heartbeats.
    is_tested
        Whether the bridge was tried with the real one.
    has_home_item
        Whether item 0 of a mission is home, not the first thing to do.
    mode_names
        Names by custom mode.
    modes
        Custom mode for each purpose.
    states
        State of an airborne vehicle by custom mode; in other modes it is flying.
    is_mode_packed
        Whether a custom mode holds a main and a sub mode.
    arms_in
        Purpose of the mode in which it is armed for a mission.
    pauses_missions
        Whether it can stop within a mission, by DO_PAUSE_CONTINUE.
    repositions_itself
        Whether DO_REPOSITION changes the mode and takes an altitude above the sea.
    flies_to_takeoff
        Whether it flies to the place of a take-off item once it has climbed.
    turns_at_waypoints
        Whether a waypoint holds the heading; otherwise CONDITION_YAW does.
    starts_anywhere
        Whether MISSION_START begins with the item that it names, also in the air.
    unsent
        Messages of `stream_rates.WANTED` that it does not have.
    drives
        Whether it is a ground vehicle: it is under way while its motors are on, and at the end of
        its way somebody must switch them off.
    """

    name: str
    number: int
    is_tested: bool
    has_home_item: bool
    mode_names: Mapping[int, str]
    modes: Mapping[Verb, int]
    states: Mapping[int, FlightState]
    is_mode_packed: bool
    arms_in: Verb
    pauses_missions: bool
    repositions_itself: bool
    flies_to_takeoff: bool
    turns_at_waypoints: bool
    starts_anywhere: bool
    unsent: frozenset[str]
    drives: bool = False

    @property
    def first_own_item(self) -> int:
        """Number of the first mission item that is ours; item 0 may be the autopilot's home."""
        return 1 if self.has_home_item else 0

    def mode_name(self, custom_mode: int) -> str:
        """Return the name of a mode; ``UNKNOWN(n)`` for one without a name."""
        return self.mode_names.get(custom_mode, f'UNKNOWN({custom_mode})')

    def is_in(self, vehicle: VehicleTelemetry, verb: Verb) -> bool:
        """Whether the heartbeat of the vehicle shows the mode for `verb`."""
        return vehicle.custom_mode == self.modes[verb]

    def mode_command(self, verb: Verb, target: tuple[int, int]) -> Message:
        """Return the command that switches `target` (system, component) to the mode for `verb`."""
        mode = self.modes[verb]
        main, sub = (mode >> 16 & 0xFF, mode >> 24) if self.is_mode_packed else (mode, 0)
        return command(DO_SET_MODE, target, CUSTOM_MODE_ENABLED, main, sub)

    def state_of(self, vehicle: VehicleTelemetry, now_s: float) -> FlightState:
        """Return what `vehicle` does at `now_s`, as far as telemetry tells."""
        contact = vehicle.contact(now_s)
        if contact in (Contact.NONE, Contact.LOST):
            return FlightState.UNKNOWN if contact is Contact.NONE else FlightState.LOST
        if not vehicle.is_armed:
            return FlightState.LANDED if vehicle.has_flown else FlightState.DISARMED
        if vehicle.landed is Landed.ON_GROUND:
            return FlightState.ARMED
        return self._airborne(vehicle)

    def _airborne(self, vehicle: VehicleTelemetry) -> FlightState:
        if vehicle.landed is Landed.TAKEOFF:
            return FlightState.TAKING_OFF
        if vehicle.landed is Landed.LANDING:
            return FlightState.LANDING
        if self.is_in(vehicle, Verb.MISSION) and vehicle.mission.phase is MissionPhase.PAUSED:
            return FlightState.HOLDING
        if vehicle.custom_mode not in self.mode_names:
            return FlightState.UNKNOWN
        return self.states.get(vehicle.custom_mode, FlightState.FLYING)
