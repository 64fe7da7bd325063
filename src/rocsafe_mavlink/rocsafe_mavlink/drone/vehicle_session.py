# SPDX-License-Identifier: Apache-2.0
"""The exchange of messages with one vehicle: its state, operations under way, messages to send.

All that is sent to the vehicle goes through `VehicleSession.send`. Commands come from the
sequences of its flight and of its operator, all else only reads.
"""

import math
from dataclasses import dataclass, field, replace

from rocsafe_mavlink.autopilots.autopilot import Autopilot, Verb
from rocsafe_mavlink.autopilots.registry import autopilot_of
from rocsafe_mavlink.drone.readout import Readout, Target
from rocsafe_mavlink.flight.command_sequence import CommandSequence
from rocsafe_mavlink.flight.custody import Custody
from rocsafe_mavlink.flight.flight import FlightStage, MissionFlight
from rocsafe_mavlink.flight.flight_outcome import failsafe_of
from rocsafe_mavlink.flight.flight_signs import mission_changed
from rocsafe_mavlink.flight.vehicle_commands import VehicleCommands
from rocsafe_mavlink.knowledge.events import Event, EventKind
from rocsafe_mavlink.knowledge.px4_events import text_of_event
from rocsafe_mavlink.knowledge.reducer import reduce
from rocsafe_mavlink.knowledge.telemetry import LOST_AFTER_S, Contact, VehicleTelemetry
from rocsafe_mavlink.link.link import Address, Link
from rocsafe_mavlink.protocols.answer_book import AnswerBook
from rocsafe_mavlink.protocols.mission_results import MissionType
from rocsafe_mavlink.protocols.mission_transfer import compare
from rocsafe_mavlink.protocols.mission_upload import REQUESTS, cancelled
from rocsafe_mavlink.protocols.onboard_mission import MissionCondition
from rocsafe_mavlink.protocols.stream_rates import StreamRates
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.texts import TextJoiner

_OVERWRITES = ('MISSION_COUNT', 'MISSION_CLEAR_ALL')


@dataclass(slots=True, kw_only=True)
class VehicleSession:
    """One vehicle on a link.

    Attributes
    ----------
    us
        Our own (system, component).
    telemetry
        What the vehicle said.
    readout
        What was read from it besides
        Settings, fence, mission.
    separation_m
        Height of the geoid above the ellipsoid where the vehicle does not tell, metres; NaN if not
        known.
    address
        Address from which it speaks; held while it is in contact.
    flight
        Present or last flight.
    sequence
        Present or last sequence of commands of the operator.
    sequence_count
        Number of sequences of the operator so far.
    custody
        Who has the vehicle in the air.
    answers
        Which answers are those to the newest commands.
    texts
        Joins texts that come in several messages.
    starts_at_s
        Steady time at which a route is to be begun by itself; None: none is.
    twin_s
        Steady time at which another station spoke with our own system last.
    withdrawals
        How often a start that is to come was withdrawn.
    withdrawn_by
        What withdrew it last: a command, or what happened.
    """

    us: Target
    telemetry: VehicleTelemetry
    readout: Readout
    separation_m: float = math.nan
    address: Address | None = None
    flight: MissionFlight | None = None
    sequence: CommandSequence | None = None
    sequence_count: int = 0
    custody: Custody = field(default_factory=Custody)
    answers: AnswerBook = field(default_factory=AnswerBook)
    texts: TextJoiner = field(default_factory=TextJoiner)
    starts_at_s: float | None = None
    twin_s: float = -math.inf
    withdrawals: int = 0
    withdrawn_by: str = ''
    _outgoing: list[Message] = field(default_factory=list)

    @classmethod
    def of(
        cls,
        target: Target,
        us: Target,
        *,
        separation_m: float = math.nan,
        position_rate_hz: float | None = None,
    ) -> 'VehicleSession':
        """Return the session with a vehicle that was not heard yet."""
        return cls(
            us=us,
            telemetry=VehicleTelemetry(system=target[0], component=target[1]),
            readout=Readout(target=target, rates=StreamRates(position_rate_hz)),
            separation_m=separation_m,
        )

    @property
    def target(self) -> Target:
        """(system, component) of the vehicle."""
        return self.readout.target

    @property
    def is_flying(self) -> bool:
        """Whether a flight of ours is under way, or one that was found in the air."""
        return self.flight is not None and not self.flight.is_over

    @property
    def is_commanded(self) -> bool:
        """Whether commands are under way: of a flight that begins, or of the operator."""
        return self._is_ordered or (self.flight is not None and self.flight.is_beginning)

    @property
    def _is_ordered(self) -> bool:
        return self.sequence is not None and not self.sequence.is_over

    def autopilot(self) -> Autopilot:
        """Return the kind of autopilot of the vehicle.

        Raises
        ------
        ValueError
            If the vehicle was never heard, or its kind is not known.
        """
        if self.telemetry.autopilot is None:
            raise ValueError('the vehicle was never heard')
        return autopilot_of(self.telemetry.autopilot, self.telemetry.vehicle_type)

    def has_twin(self, now_s: float) -> bool:
        """Whether another station was heard lately that says to be us."""
        return now_s - self.twin_s < LOST_AFTER_S

    def known_autopilot(self) -> Autopilot | None:
        """Return the kind of autopilot; None if it is not known: it is then only listened to."""
        try:
            return self.autopilot()
        except ValueError:
            return None

    def commands(self) -> VehicleCommands:
        """Return what makes commands for the vehicle; raises as `autopilot`."""
        return VehicleCommands(autopilot=self.autopilot(), target=self.target, us=self.us)

    def may_hear(self, address: Address, link: Link, now_s: float) -> bool:
        """Whether the vehicle may be heard at `address`: at one address, until it is silent.

        With signatures a few seconds of silence suffice, since every sender has the key: a vehicle
        behind a router changes its port. Without them the vehicle has to be lost first.
        """
        contact = self.telemetry.contact(now_s)
        if self.address is None or contact is Contact.NONE:
            self.address = address
        if self.address == address:
            return True
        is_silent = contact is Contact.LOST or (link.is_signed and contact is Contact.STALE)
        if not is_silent or not link.may_take_over(self.address, address):
            return False
        self.address = address
        return True

    def take(self, message: Message, now_s: float) -> list[Event]:
        """Take a message of the vehicle; return what happened."""
        heard = self.texts.late(now_s)
        if message.name == 'STATUSTEXT':
            heard += self.texts.take(message, now_s)
            self._hear_early(now_s)
        else:
            heard.append(text_of_event(message) if message.name == 'EVENT' else message)
        return [event for one in heard for event in self._take(one, now_s)]

    def tick(self, now_s: float) -> None:
        """Let time pass."""
        flight, sequence = self.flight, self.sequence
        if flight is not None:
            holder = self.custody.holder(self.telemetry, flight.autopilot)
            self.flight, sent = flight.on_tick(self.telemetry, now_s, holder)
            self.send(sent, now_s)
            self._note_verified(flight.sequence, self.flight.sequence)
        if sequence is not None:
            self.sequence, sent = sequence.on_tick(self.telemetry, now_s)
            self.send(sent, now_s)
            self._note_verified(sequence, self.sequence)
            is_new = self.sequence.is_over and not sequence.is_over
            # A transfer leads to no mode: the one that the vehicle is in may be its pilot's.
            if is_new and not self.sequence.error and self.sequence.led_to >= 0:
                self.custody = self.custody.obeyed(self.sequence.led_to)
        kind, is_commanded = self.known_autopilot(), self.is_commanded
        self.send(
            self.readout.on_tick(self.telemetry, kind, now_s, is_commanded=is_commanded), now_s
        )

    def begin(self, sequence: CommandSequence, now_s: float, *, preempts: bool = False) -> None:
        """Begin a sequence of the operator; the next `tick` sends its first command.

        With `preempts` it takes the place of one that is under way, also of the start of a flight.

        Raises
        ------
        ValueError
            If another is under way.
        """
        if not preempts and self.is_commanded:
            raise ValueError(f'{self._under_way()} is under way')
        # The effect of an earlier command may show only now: that is no takeover.
        sequence = sequence.after(self._begun(), now_s)
        if self.flight is not None and self.flight.is_beginning:
            self.flight = self.flight.interrupted()
        # The vehicle is commanded in the state that it had when the order was given.
        self.sequence = sequence.looked_at(self.telemetry, now_s)
        self.sequence_count += 1

    def forget_contact(self, reason: str, now_s: float) -> None:
        """Withdraw what is under way and what is to begin: nobody knows what the vehicle did.

        It is in contact again with its next heartbeat.
        """
        self.withdraw_start(reason)
        if self.flight is not None:
            self.flight = self.flight.withdrawn(reason)
        if self.sequence is not None:
            self.sequence = self.sequence.withdrawn(reason)
        last_s = min(self.telemetry.heartbeat_s, now_s - LOST_AFTER_S)
        self.telemetry = replace(self.telemetry, heartbeat_s=last_s)

    def withdraw_start(self, cause: str) -> None:
        """Let a start that is to come be given up, if there is one."""
        self.starts_at_s, self.withdrawn_by = None, cause
        self.withdrawals += 1

    def flies_another(self) -> bool:
        """Whether it flies a mission that was read, and is not that of its plan."""
        flight, kind = self.flight, self.known_autopilot()
        if kind is None or flight is None or flight.stage is not FlightStage.FLYING:
            return False
        is_unknown = self.mission_condition() is MissionCondition.UNKNOWN
        is_read = self.readout.mission.items is not None
        return is_unknown and is_read and kind.is_in(self.telemetry, Verb.MISSION)

    def mission_condition(self) -> MissionCondition:
        """Return how well the mission is known; one read in the air is compared with the plan."""
        mission, flight = self.readout.mission, self.flight
        is_new = mission.condition is MissionCondition.UNKNOWN and mission.items is not None
        if is_new and flight is not None and flight.stage is FlightStage.FLYING:
            first = flight.autopilot.first_own_item
            if not compare(flight.mission.items, mission.items or (), first):
                self.readout.mission = mission.verified(mission.items or ())
        return self.readout.mission.condition

    def send(self, messages: list[Message], now_s: float) -> None:
        """Queue messages for the vehicle."""
        for message in messages:
            self.answers.note(message, now_s)
            if message.name in _OVERWRITES:
                self.readout.overwritten(MissionType(message['mission_type']))
            self._outgoing.append(message)

    def outgoing(self) -> list[Message]:
        """Return the queued messages, and empty the queue."""
        queued, self._outgoing = self._outgoing, []
        return queued

    def _take(self, message: Message, now_s: float) -> list[Event]:
        self.telemetry, events = reduce(self.telemetry, message, now_s, self.separation_m)
        self.readout.rates.hear(message.name, now_s)
        self._look(message, now_s)
        if message.name == 'HEARTBEAT':
            self._look_at(now_s)
        if any(event.kind is EventKind.REBOOTED for event in events):
            self.readout.forget()
            self._restarted()
        is_late = message.name == 'COMMAND_ACK' and not self._answers_newest(message, now_s)
        if self.flight is not None and not is_late:
            self.flight, sent = self.flight.on_message(message, now_s)
            self.send(sent, now_s)
        if self.sequence is not None and not is_late:
            self.sequence, sent = self.sequence.on_message(message, now_s)
            self.send(sent, now_s)
        self.send(self.readout.on_message(message, now_s), now_s)
        if message.name == 'MISSION_CURRENT':
            self._compare_count()
        if message.name in REQUESTS and not self.is_commanded:
            self._cancel(message, now_s)
        return events

    def _answers_newest(self, answer: Message, now_s: float) -> bool:
        """Whether an answer is not that to an older command; those to others are left alone."""
        named = answer.fields.get('target_system', 0), answer.fields.get('target_component', 0)
        is_ours = all(part in (0, own) for part, own in zip(named, self.us, strict=True))
        return not is_ours or self.answers.answers_newest(answer, now_s)

    def _compare_count(self) -> None:
        """Forget the mission that was read if the vehicle tells another number of items."""
        items, kind = self.readout.mission.items, self.known_autopilot()
        if items is None or kind is None or self.is_commanded:
            return
        if mission_changed(len(items) - kind.first_own_item, self.telemetry):
            self.readout.forget_mission()

    def _cancel(self, request: Message, now_s: float) -> None:
        """End an upload of ours, or of a bridge before us, that the autopilot still waits for."""
        fields = request.fields
        named = (fields.get('target_system', 0), fields.get('target_component', 0))
        if named == self.us:
            self.readout.wait(now_s)
            self.send([cancelled(request)], now_s)

    def _look(self, message: Message, now_s: float) -> None:
        """Note who has the vehicle."""
        kind = self.known_autopilot()
        if message.name == 'STATUSTEXT':
            self.custody = self.custody.heard(str(message['text']), now_s)
        elif kind is not None:
            expected = frozenset[int]().union(*(one.expected_modes for one in self._begun()))
            self.custody = self.custody.seen(self.telemetry, kind, expected, now_s)

    def _hear_early(self, now_s: float) -> None:
        """Act on a failsafe that a part of a text names: the rest may come late or never."""
        text = '' if self.texts.held is None else str(self.texts.held['text'])
        if not failsafe_of(text):
            return
        self.custody = self.custody.heard(text, now_s)
        if self.flight is not None:
            self.flight = self.flight.withdrawn(text)
        if self.sequence is not None:
            self.sequence = self.sequence.withdrawn(text)

    def _begun(self) -> list[CommandSequence]:
        """Return the sequences of the flight and of the operator."""
        flight = None if self.flight is None else self.flight.sequence
        return [one for one in (flight, self.sequence) if one is not None]

    def _look_at(self, now_s: float) -> None:
        """Withdraw the commands under way after a takeover of the vehicle."""
        if self.flight is not None:
            self.flight = self.flight.looked_at(self.telemetry, now_s)
        if self.sequence is not None:
            self.sequence = self.sequence.looked_at(self.telemetry, now_s)

    def _under_way(self) -> str:
        ordered = self.sequence if self._is_ordered else None
        return 'the start of a flight' if ordered is None else ordered.name

    def _restarted(self) -> None:
        """Withdraw what was under way when the autopilot was started again."""
        if self.flight is not None:
            self.flight = self.flight.restarted()
        if self.sequence is not None:
            self.sequence = self.sequence.withdrawn('the autopilot was started again')

    def _note_verified(
        self, before: CommandSequence | None, after: CommandSequence | None
    ) -> None:
        """Note that a mission was read back as it was sent."""
        verified = None if after is None else after.verified_mission
        if verified is not None and (before is None or before.verified_mission is None):
            self.readout.mission = self.readout.mission.verified(verified)
