# SPDX-License-Identifier: Apache-2.0
"""One flight of a plan: ``(state, message or tick) -> (state, messages to send)``.

Upload, read back, arm, start, then watch. Once it flies, the autopilot flies by itself: nothing is
sent but what an operator orders. Its failsafes are never countermanded, a link that comes back is
no reason to resume, and what is believed is always the vehicle's own word.
"""

from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_mavlink.autopilots.autopilot import Autopilot, Verb
from rocsafe_mavlink.flight.flight_outcome import Outcome, failsafe_of
from rocsafe_mavlink.flight.flight_plan import FlightPlan, Mission, mission_of
from rocsafe_mavlink.flight.flight_signs import home_moved, shown_failsafe
from rocsafe_mavlink.knowledge.vehicle import (
    Contact,
    Home,
    Landed,
    MissionPhase,
    Vehicle,
)
from rocsafe_mavlink.protocols import command_call as commands
from rocsafe_mavlink.protocols.command_call import CallStage, CommandCall
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.protocols.mission_transfer import Transfer, TransferStage, compare, transfer
from rocsafe_mavlink.wire.dialect import Message

# A mode or arming that was accepted shows in a heartbeat within this time, two of them lost.
SHOWS_WITHIN_S = 3.5
GIVE_UP_LOST_S = 600.0
Answer = tuple['Flight', list[Message]]


class FlightStage(Enum):
    """How far a flight is."""

    UPLOADING = 'uploading'
    SWITCHING = 'switching to the mode to arm in'
    ARMING = 'arming'
    STARTING = 'switching to the mission'
    LAUNCHING = 'starting the mission'
    FLYING = 'flying'
    ABANDONING = 'disarming'
    OVER = 'over'


_CALLS = frozenset(
    {
        FlightStage.SWITCHING,
        FlightStage.ARMING,
        FlightStage.STARTING,
        FlightStage.LAUNCHING,
        FlightStage.ABANDONING,
    }
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """State of one flight.

    Attributes
    ----------
    autopilot: of the vehicle.
    mission: what it shall fly.
    home: where it stood when the flight was planned.
    us: our (system, component).
    target: the vehicle's.
    stage: how far it is.
    moving: the transfer of the mission; None for a flight that was found in the air.
    call: the command of the stage.
    since_s: steady time at which the command of the stage was accepted; 0 before.
    visited: waypoints behind it; never decreases.
    cause: why it left its mission, the first reason counts.
    outcome: how it ended, None before.
    reason: words for it, the autopilot's own where it has some.
    """

    autopilot: Autopilot
    mission: Mission
    home: Home
    us: tuple[int, int]
    target: tuple[int, int]
    stage: FlightStage = FlightStage.UPLOADING
    moving: Transfer | None = None
    call: CommandCall | None = None
    since_s: float = 0.0
    visited: int = 0
    cause: Outcome | None = None
    outcome: Outcome | None = None
    reason: str = ''

    @property
    def is_over(self) -> bool:
        """Whether it has ended."""
        return self.stage is FlightStage.OVER

    def on_message(self, message: Message, now_s: float) -> Answer:
        """Take a message; those of other vehicles change nothing."""
        if (message.system, message.component) != self.target or self.is_over:
            return self, []
        if self.stage is FlightStage.UPLOADING and self.moving is not None:
            moving, sent = self.moving.on_message(message, now_s)
            return replace(self, moving=moving), sent
        if self.stage is FlightStage.FLYING and message.name == 'STATUSTEXT':
            return self._hear(str(message['text'])), []
        if self.call is not None:
            return replace(self, call=self.call.on_message(message, now_s)), []
        return self, []

    def on_tick(self, vehicle: Vehicle, now_s: float) -> Answer:
        """Go on as far as `vehicle`, as it is known now, allows."""
        if self.stage is FlightStage.UPLOADING and self.moving is not None:
            return self._upload(self.moving, now_s)
        if self.stage is FlightStage.FLYING:
            return self._watch(vehicle, now_s), []
        if self.stage in _CALLS and self.call is not None:
            return self._command(self.call, vehicle, now_s)
        return self, []

    def stopped(self) -> 'Flight':
        """Return the flight after an operator's accepted order to return or land."""
        return replace(self, cause=self.cause or Outcome.ABORTED_BY_OPERATOR)

    def replanned(self, plan: FlightPlan) -> 'Flight':
        """Return the flight that goes on with another plan, which lies on the vehicle now."""
        return replace(self, mission=mission_of(plan, self.autopilot), visited=0)

    def _upload(self, moving: Transfer, now_s: float) -> Answer:
        moving, sent = moving.on_tick(now_s)
        going = replace(self, moving=moving)
        if moving.stage is TransferStage.FAILED:
            return going._end(Outcome.REJECTED, f'mission not taken: {moving.error}'), sent
        if moving.stage is not TransferStage.VERIFIED:
            return going, sent
        order = self.autopilot.mode_command(self.autopilot.arms_in, self.target)
        begun, more = going._begin(FlightStage.SWITCHING, order, now_s)
        return begun, sent + more

    def _command(self, call: CommandCall, vehicle: Vehicle, now_s: float) -> Answer:
        call, sent = call.on_tick(now_s)
        going = replace(self, call=call)
        if not call.is_over:
            return going, sent
        if call.stage is CallStage.UNANSWERED and self._is_done_anyway(vehicle):
            return going._advance(vehicle, now_s)
        if call.stage is not CallStage.ACCEPTED:
            return going._abandon(call.error, vehicle, now_s)
        if not self.since_s:
            return replace(going, since_s=now_s), sent
        if self._is_shown(vehicle):
            return going._advance(vehicle, now_s)
        if now_s - self.since_s > SHOWS_WITHIN_S:
            error = f'{self.stage.value}: accepted, but its heartbeats do not show it'
            return going._abandon(error, vehicle, now_s)
        return going, sent

    def _is_shown(self, vehicle: Vehicle) -> bool:
        """Whether the vehicle's heartbeat says that the command of the stage was done."""
        if self.stage is FlightStage.SWITCHING:
            return self.autopilot.is_in(vehicle, self.autopilot.arms_in)
        if self.stage is FlightStage.ARMING:
            return vehicle.is_armed
        if self.stage is FlightStage.STARTING:
            return self.autopilot.is_in(vehicle, Verb.MISSION)
        return self.stage is FlightStage.LAUNCHING or not vehicle.is_armed

    def _is_done_anyway(self, vehicle: Vehicle) -> bool:
        """Whether only the answer got lost: the vehicle shows that it did what it was told."""
        if self.stage is FlightStage.LAUNCHING:
            return vehicle.landed in (Landed.TAKEOFF, Landed.IN_AIR)
        return self._is_shown(vehicle)

    def _advance(self, vehicle: Vehicle, now_s: float) -> Answer:
        if self.stage is FlightStage.SWITCHING:
            return self._begin(FlightStage.ARMING, commands.arm(self.target), now_s)
        if self.stage is FlightStage.ARMING:
            moved = home_moved(self.home, vehicle.home)
            if moved:
                return self._abandon(moved, vehicle, now_s)
            order = self.autopilot.mode_command(Verb.MISSION, self.target)
            return self._begin(FlightStage.STARTING, order, now_s)
        if self.stage is FlightStage.STARTING:
            order = commands.start_mission(self.target)
            return self._begin(FlightStage.LAUNCHING, order, now_s)
        if self.stage is FlightStage.LAUNCHING:
            return replace(self, stage=FlightStage.FLYING, call=None), []
        return self._end(Outcome.REJECTED, self.reason), []

    def _begin(self, stage: FlightStage, order: Message, now_s: float) -> Answer:
        call, sent = CommandCall(command=order, us=self.us).begin(now_s)
        return replace(self, stage=stage, call=call, since_s=0.0), sent

    def _abandon(self, reason: str, vehicle: Vehicle, now_s: float) -> Answer:
        """End a flight that has not begun, the motors off if they may be on."""
        ended = replace(self, reason=self.reason or reason)
        may_be_armed = vehicle.is_armed or self.stage is FlightStage.ARMING
        if self.stage is FlightStage.ABANDONING and vehicle.is_armed:
            # It cannot be called back: what flies is watched to its end.
            return replace(ended, stage=FlightStage.FLYING, cause=Outcome.REJECTED), []
        if self.stage is FlightStage.ABANDONING or not may_be_armed:
            return ended._end(Outcome.REJECTED, ended.reason), []
        return ended._begin(FlightStage.ABANDONING, commands.disarm(self.target), now_s)

    def _hear(self, text: str) -> 'Flight':
        failsafe = failsafe_of(text)
        # Its words may come after what it shows; only the first failsafe counts.
        is_first = self.cause is None or (self.cause is failsafe and not self.reason)
        return replace(self, cause=failsafe, reason=text) if failsafe and is_first else self

    def _watch(self, vehicle: Vehicle, now_s: float) -> 'Flight':
        contact = vehicle.contact(now_s)
        if contact is not Contact.FRESH:
            silent_s = now_s - vehicle.heartbeat_s
            if silent_s > GIVE_UP_LOST_S:
                return self._end(Outcome.LOST, f'nothing heard for {silent_s:.0f} s')
            return self
        going = replace(
            self,
            visited=max(self.visited, self._visited(vehicle)),
            cause=self.cause or shown_failsafe(vehicle),
        )
        return going if vehicle.is_armed else going._landed(vehicle)

    def _visited(self, vehicle: Vehicle) -> int:
        is_on_mission = vehicle.is_armed and self.autopilot.is_in(vehicle, Verb.MISSION)
        before_current = vehicle.mission.current - 1 if is_on_mission else -1
        return self.mission.visited(max(vehicle.mission.reached, before_current))

    def _landed(self, vehicle: Vehicle) -> 'Flight':
        # What was reached unheard shows in the end: its mission is complete.
        is_complete = vehicle.mission.phase is MissionPhase.COMPLETE and self.cause is None
        count = len(self.mission.waypoint_items)
        if is_complete or self.visited == count:
            return replace(self, visited=count)._end(Outcome.COMPLETED, '')
        cause = self.cause or Outcome.ABORTED_BY_OPERATOR
        return self._end(cause, self.reason or 'it landed before its last waypoint')

    def _end(self, outcome: Outcome, reason: str) -> 'Flight':
        stage = FlightStage.OVER
        return replace(self, stage=stage, call=None, outcome=outcome, reason=reason)


def fly(
    plan: FlightPlan, autopilot: Autopilot, vehicle: Vehicle, us: tuple[int, int], now_s: float
) -> Answer:
    """Begin a flight from the ground; look at `preflight` before.

    Raises
    ------
    ValueError: if the vehicle is not on the ground with its motors off, or its home not known.
    """
    if vehicle.is_armed:
        raise ValueError('the vehicle is armed: a flight begins with the motors off')
    if vehicle.home is None:
        raise ValueError('the vehicle has not told its home')
    mission, target = mission_of(plan, autopilot), (vehicle.system, vehicle.component)
    first = 1 if autopilot.has_home_item else 0
    moving, sent = transfer(mission.items, target, first_compared=first).begin(now_s)
    flight = Flight(
        autopilot=autopilot,
        mission=mission,
        home=vehicle.home,
        us=us,
        target=target,
        moving=moving,
    )
    return flight, sent


def adopted(
    plan: FlightPlan,
    autopilot: Autopilot,
    vehicle: Vehicle,
    stored: tuple[MissionItem, ...] | None,
    us: tuple[int, int],
) -> Flight | None:
    """Return the flight that `vehicle` is on if it flies `plan`, without sending anything.

    So a bridge that was started again finds its flight: by what the vehicle says of itself, and by
    the mission read back from it, `stored`; None: whatever lies there. Which waypoints are behind
    follows from its current item.
    """
    mission, first = mission_of(plan, autopilot), 1 if autopilot.has_home_item else 0
    if not vehicle.is_armed or vehicle.home is None:
        return None
    if stored is not None and compare(mission.items, stored, first):
        return None
    return Flight(
        autopilot=autopilot,
        mission=mission,
        home=vehicle.home,
        us=us,
        target=(vehicle.system, vehicle.component),
        stage=FlightStage.FLYING,
    )
