# SPDX-License-Identifier: Apache-2.0
"""One flight of a plan: ``(state, message or tick) -> (state, messages to send)``.

A sequence of commands uploads the mission, reads it back, arms and starts. Then the flight is only
watched: the autopilot flies by itself, and nothing is sent but what an operator commands. A
failsafe is never countermanded, and a link that comes back is no reason to resume. What counts is
always what the vehicle says of itself.
"""

import math
from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.autopilot import Autopilot, Verb
from rocsafe_mavlink.flight.command_sequence import CommandSequence
from rocsafe_mavlink.flight.command_step import CommandStep, Refusal
from rocsafe_mavlink.flight.custody import is_commanded
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome, failsafe_of
from rocsafe_mavlink.flight.flight_signs import is_at_home, shown_failsafe, stands
from rocsafe_mavlink.flight.vehicle_commands import VehicleCommands
from rocsafe_mavlink.knowledge.telemetry import Contact, Home, MissionPhase, VehicleTelemetry
from rocsafe_mavlink.plan.flight_plan import WAYPOINT, FlightPlan, Mission, mission_of
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.protocols.mission_transfer import compare
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.units import position_of_e7

GIVE_UP_LOST_S = 600.0
# A failsafe that lets a ground vehicle stand for so long has ended its drive.
STOOD_S = 60.0
Answer = tuple['MissionFlight', list[Message]]


class FlightStage(Enum):
    """How far a flight is."""

    STARTING = 'starting'
    FLYING = 'flying'
    DISARMING = 'disarming'
    OVER = 'over'


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionFlight:
    """State of one flight.

    Attributes
    ----------
    commands
        Commands for the vehicle.
    plan
        What it shall fly.
    mission
        The items that lie on it.
    home
        Home of the vehicle when it was begun: its heights are above that; None: not known.
    stage
        How far the flight is.
    sequence
        Commands of the stage; None while the flight is only watched.
    visited
        Waypoints behind the vehicle; never decreases.
    cause
        Why it left its mission; the first reason counts.
    was_called_down
        Whether an operator had it return or land, whatever it did before.
    stood_s
        Steady time since when a failsafe lets a ground vehicle stand; infinite: it does not.
    outcome
        How the flight ended; None before.
    reason
        Words for it, the autopilot's own where it has some.
    """

    commands: VehicleCommands
    plan: FlightPlan
    mission: Mission
    home: Home | None = None
    stage: FlightStage = FlightStage.STARTING
    sequence: CommandSequence | None = None
    visited: int = 0
    cause: FlightOutcome | None = None
    was_called_down: bool = False
    stood_s: float = math.inf
    outcome: FlightOutcome | None = None
    reason: str = ''

    @property
    def autopilot(self) -> Autopilot:
        """Autopilot of the vehicle."""
        return self.commands.autopilot

    @property
    def is_over(self) -> bool:
        """Whether the flight has ended."""
        return self.stage is FlightStage.OVER

    @property
    def is_beginning(self) -> bool:
        """Whether commands of the flight's own are under way."""
        return self.stage in (FlightStage.STARTING, FlightStage.DISARMING)

    @property
    def is_given_up(self) -> bool:
        """Whether an operator ended it, and its route lies on the vehicle yet."""
        is_ended = self.was_called_down or self.cause is FlightOutcome.ABORTED_BY_OPERATOR
        return is_ended and bool(self.mission.waypoint_items)

    def next_place(self, vehicle: VehicleTelemetry) -> GeoPosition | None:
        """Return to where the vehicle flies in its mission; home behind it; None: not known."""
        ahead = self.mission.items[max(vehicle.mission.current, self.mission.first_item) :]
        for item in ahead:
            if item.command == WAYPOINT:
                return position_of_e7(item.x_e7, item.y_e7, 0.0)
        return None if vehicle.home is None else vehicle.home.place

    def on_message(self, message: Message, now_s: float) -> Answer:
        """Take a message; those of other vehicles change nothing."""
        if (message.system, message.component) != self.commands.target or self.is_over:
            return self, []
        if self.stage is FlightStage.FLYING:
            is_text = message.name == 'STATUSTEXT'
            return (self._on_text(str(message['text'])) if is_text else self), []
        if self.sequence is None:
            return self, []
        sequence, sent = self.sequence.on_message(message, now_s)
        return self if sequence is self.sequence else replace(self, sequence=sequence), sent

    def on_tick(self, vehicle: VehicleTelemetry, now_s: float, holder: str = '') -> Answer:
        """Go on as far as `vehicle`, as it is known now, allows.

        `holder` is who has the vehicle in place of this bridge, see `Custody.holder`.
        """
        if self.stage is FlightStage.FLYING:
            watched = self._watch(vehicle, now_s)
            if not watched._has_arrived(vehicle):
                return watched._left_standing(vehicle, holder, now_s), []
            if holder:
                return watched._left_on(f'its {holder} brought it back'), []
            return watched._parked(vehicle, now_s)
        if self.sequence is None:
            return self, []
        sequence, sent = self.sequence.on_tick(vehicle, now_s)
        going = replace(self, sequence=sequence)
        if sequence.error:
            after, more = going._after_failure(sequence, vehicle, now_s)
            return after, sent + more
        return going._after_success() if sequence.is_over else going, sent

    def looked_at(self, vehicle: VehicleTelemetry, now_s: float) -> 'MissionFlight':
        """Return the flight after a check of the vehicle: its commands may be withdrawn."""
        if self.sequence is None:
            return self
        return replace(self, sequence=self.sequence.looked_at(vehicle, now_s))

    def interrupted(self) -> 'MissionFlight':
        """Return the flight once an operator commands it in the air: it is only watched now."""
        return replace(self, stage=FlightStage.FLYING, sequence=None)

    def may_be_armed(self, vehicle: VehicleTelemetry) -> bool:
        """Whether the start of the flight has started the motors, or may have."""
        if self.stage is FlightStage.DISARMING:
            return True
        sequence = self.sequence
        if sequence is None or sequence.is_over:
            return False
        return vehicle.is_armed or _may_be_armed(sequence, vehicle)

    def called_off(self, reason: str) -> 'MissionFlight':
        """Return the flight given up on the ground, before its motors were started."""
        return self._end(FlightOutcome.ABORTED_BY_OPERATOR, reason)

    def stopped(self, homeward: tuple[MissionItem, ...] | None = None) -> 'MissionFlight':
        """Return the flight after an operator's accepted command to return or land.

        `homeward` is the mission by which it returns, if it returns by one.
        """
        cause = self.cause or FlightOutcome.ABORTED_BY_OPERATOR
        stopped = replace(self, cause=cause, was_called_down=True)
        if homeward is None:
            return stopped
        return replace(stopped, mission=Mission(items=homeward, first_item=0, waypoint_items=()))

    def restarted(self) -> 'MissionFlight':
        """Return the flight after its autopilot restarted; one that begins is withdrawn."""
        reason = 'the autopilot was started again'
        if self.sequence is not None:
            return self.withdrawn(reason)
        if self.stage is not FlightStage.FLYING:
            return self
        cause = self.cause or FlightOutcome.RESTARTED
        reason = self.reason or reason
        return replace(self, cause=cause, reason=reason)

    def withdrawn(self, reason: str) -> 'MissionFlight':
        """Return the flight without further commands of its start."""
        if self.sequence is None:
            return self
        return replace(self, sequence=self.sequence.withdrawn(reason))

    def replanned(self, plan: FlightPlan) -> 'MissionFlight':
        """Return the flight that goes on with another plan, which lies on the vehicle now."""
        mission = mission_of(plan, self.autopilot)
        going = replace(self, plan=plan, mission=mission, visited=0, was_called_down=False)
        # An order to return or land was given for the plan before.
        is_given_up = self.cause is FlightOutcome.ABORTED_BY_OPERATOR
        return replace(going, cause=None, reason='') if is_given_up else going

    def remembering(
        self, cause: FlightOutcome | None, reason: str, *, was_called_down: bool
    ) -> 'MissionFlight':
        """Return a flight that was found, with what an earlier bridge noted of it."""
        return replace(self, cause=cause, reason=reason, was_called_down=was_called_down)

    def _has_arrived(self, vehicle: VehicleTelemetry) -> bool:
        """Whether a ground vehicle stands at the end of its way, or back at home, switched on."""
        if not (self.autopilot.drives and vehicle.is_armed) or self.is_over:
            return False
        if self.autopilot.is_in(vehicle, Verb.MISSION):
            return vehicle.mission.phase is MissionPhase.COMPLETE
        return self.autopilot.is_in(vehicle, Verb.RETURN) and is_at_home(vehicle)

    def _parked(self, vehicle: VehicleTelemetry, now_s: float) -> Answer:
        """Switch off the motors of a ground vehicle that has arrived: it does not by itself."""
        disarming, sent = self.commands.disarm().on_tick(vehicle, now_s)
        return replace(self, stage=FlightStage.DISARMING, sequence=disarming), sent

    def _left_standing(
        self, vehicle: VehicleTelemetry, holder: str, now_s: float
    ) -> 'MissionFlight':
        """Return the drive, ended if a failsafe has let the vehicle stand for long.

        Nobody may order it to go on, and its battery lasts for hours.
        """
        is_stopped = self.autopilot.drives and holder == 'failsafe' and stands(vehicle)
        since_s = min(self.stood_s, now_s) if is_stopped and not self.is_over else math.inf
        if now_s - since_s > STOOD_S:
            return self._left_on('a failsafe has stopped it')
        return self if since_s == self.stood_s else replace(self, stood_s=since_s)

    def _left_on(self, why: str) -> 'MissionFlight':
        """Return the ended drive of a vehicle that somebody else has, and may switch off."""
        cause = self.cause or FlightOutcome.ABORTED_BY_OPERATOR
        return self._end(cause, f'{self.reason or why}: its motors are on')

    def _after_success(self) -> 'MissionFlight':
        if self.stage is FlightStage.DISARMING and self.autopilot.drives and not self.reason:
            return self._ended_drive()
        if self.stage is FlightStage.DISARMING:
            return self._end(FlightOutcome.REJECTED, self.reason)
        return replace(self, stage=FlightStage.FLYING, sequence=None)

    def _after_failure(
        self, sequence: CommandSequence, vehicle: VehicleTelemetry, now_s: float
    ) -> Answer:
        """End a flight that has not begun; stop the motors if they may run."""
        ended = replace(self, reason=self.reason or sequence.error)
        if sequence.is_withdrawn and vehicle.is_armed:
            # Somebody else has it now: its flight is only watched.
            cause = failsafe_of(sequence.error) or FlightOutcome.ABORTED_BY_OPERATOR
            return replace(ended, stage=FlightStage.FLYING, sequence=None, cause=cause), []
        is_flying = vehicle.is_armed and vehicle.is_airborne and not self.autopilot.drives
        if is_flying or (self.stage is FlightStage.DISARMING and vehicle.is_armed):
            # It flies, or cannot be stopped: its flight is watched to the end.
            cause = FlightOutcome.REJECTED
            return replace(ended, stage=FlightStage.FLYING, sequence=None, cause=cause), []
        if self.stage is FlightStage.DISARMING or not _may_be_armed(sequence, vehicle):
            return ended._end(FlightOutcome.REJECTED, ended.reason), []
        if not is_commanded(vehicle, self.autopilot):
            # Its pilot may have armed it: he keeps it.
            return ended._end(FlightOutcome.REJECTED, ended.reason), []
        disarming, sent = self.commands.disarm().on_tick(vehicle, now_s)
        return replace(ended, stage=FlightStage.DISARMING, sequence=disarming), sent

    def _on_text(self, text: str) -> 'MissionFlight':
        failsafe = failsafe_of(text)
        # The text may come after the telemetry has shown it; only the first failsafe counts.
        is_first = self.cause is None or (self.cause is failsafe and not self.reason)
        return replace(self, cause=failsafe, reason=text) if failsafe and is_first else self

    def _watch(self, vehicle: VehicleTelemetry, now_s: float) -> 'MissionFlight':
        contact = vehicle.contact(now_s)
        if contact is not Contact.FRESH:
            silent_s = now_s - vehicle.heartbeat_s
            if silent_s > GIVE_UP_LOST_S:
                return self._end(FlightOutcome.LOST, f'nothing heard for {silent_s:.0f} s')
            return self
        going = replace(
            self,
            visited=max(self.visited, self._visited(vehicle)),
            cause=self.cause or shown_failsafe(vehicle),
        )
        return going if vehicle.is_armed else going._landed(vehicle)

    def _visited(self, vehicle: VehicleTelemetry) -> int:
        is_on_mission = vehicle.is_armed and self.autopilot.is_in(vehicle, Verb.MISSION)
        before_current = vehicle.mission.current - 1 if is_on_mission else -1
        return self.mission.visited(max(vehicle.mission.reached, before_current))

    def _landed(self, vehicle: VehicleTelemetry) -> 'MissionFlight':
        # Waypoints whose report was lost count if the mission is complete.
        is_complete = vehicle.mission.phase is MissionPhase.COMPLETE and self.cause is None
        count = len(self.plan.stops)
        if is_complete or self.visited == count:
            return replace(self, visited=count)._end(FlightOutcome.COMPLETED, '')
        cause = self.cause or FlightOutcome.ABORTED_BY_OPERATOR
        return self._end(cause, self.reason or 'it landed before its last waypoint')

    def _ended_drive(self) -> 'MissionFlight':
        if self.cause is None:
            return replace(self, visited=len(self.plan.stops))._end(FlightOutcome.COMPLETED, '')
        return self._end(self.cause, 'it came home before the end of its way')

    def _end(self, outcome: FlightOutcome, reason: str) -> 'MissionFlight':
        stage = FlightStage.OVER
        return replace(self, stage=stage, sequence=None, outcome=outcome, reason=reason)


def fly(
    plan: FlightPlan,
    commands: VehicleCommands,
    vehicle: VehicleTelemetry,
    now_s: float,
    may_not_arm: Refusal | None = None,
) -> Answer:
    """Begin a flight from the ground; `preflight` must have passed.

    Parameters
    ----------
    plan
        What is to be flown.
    commands
        Commands for the vehicle.
    vehicle
        The vehicle as it is known now.
    now_s
        Steady time.
    may_not_arm
        As in `VehicleCommands.start_flight`.

    Raises
    ------
    ValueError
        If the motors run, or the home is not known.
    """
    if vehicle.is_armed:
        raise ValueError('the vehicle is armed: a flight begins with the motors off')
    if vehicle.home is None:
        raise ValueError('the vehicle has not told its home')
    mission = mission_of(plan, commands.autopilot)
    sequence = commands.start_flight(mission, vehicle.home, may_not_arm)
    flight = MissionFlight(
        commands=commands, plan=plan, mission=mission, home=vehicle.home, sequence=sequence
    )
    return flight.on_tick(vehicle, now_s)


def adopted(
    plan: FlightPlan,
    commands: VehicleCommands,
    vehicle: VehicleTelemetry,
    stored: tuple[MissionItem, ...] | None,
    home: Home | None = None,
) -> MissionFlight | None:
    """Return the flight that `vehicle` is on if it flies `plan`; nothing is sent.

    A bridge that was started again finds its flight by what the vehicle says of itself, and by
    the mission `stored` that was read back from it; None: whatever lies there. The waypoints
    behind it follow from the current item. `home` is that of its begin; None: that of now.
    """
    mission, first = mission_of(plan, commands.autopilot), commands.autopilot.first_own_item
    if not vehicle.is_armed or vehicle.home is None:
        return None
    if stored is not None and compare(mission.items, stored, first):
        return None
    return MissionFlight(
        commands=commands,
        plan=plan,
        mission=mission,
        home=home or vehicle.home,
        stage=FlightStage.FLYING,
    )


def _may_be_armed(failed: CommandSequence, vehicle: VehicleTelemetry) -> bool:
    """Whether the motors may run after a sequence failed at its first step."""
    step = failed.steps[0]
    if not isinstance(step, CommandStep):
        return False
    return vehicle.is_armed or (failed.is_begun and step.switches_motors)
