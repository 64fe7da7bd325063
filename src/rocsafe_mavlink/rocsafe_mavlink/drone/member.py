# SPDX-License-Identifier: Apache-2.0
"""What a station keeps of one vehicle, and what it reads from it by itself.

By itself it only ever reads: rates that are missing, parameters and fence on the ground, the
mission of a vehicle that is found in the air. What flies is never told anything for having been
found.
"""

import math
from dataclasses import dataclass, field, replace

from rocsafe_mavlink.autopilots.autopilot import Autopilot
from rocsafe_mavlink.autopilots.parameters import ParameterReader
from rocsafe_mavlink.autopilots.registry import autopilot_of
from rocsafe_mavlink.flight.command_sequence import Errand
from rocsafe_mavlink.flight.fence import Fence, fence_of
from rocsafe_mavlink.flight.flight import Flight, FlightStage
from rocsafe_mavlink.flight.flight_outcome import Outcome
from rocsafe_mavlink.flight.preflight import Knowledge
from rocsafe_mavlink.knowledge.events import Event, EventKind
from rocsafe_mavlink.knowledge.px4_events import text_of_event
from rocsafe_mavlink.knowledge.reducer import reduce
from rocsafe_mavlink.knowledge.vehicle import Contact, Vehicle
from rocsafe_mavlink.link.link import Address
from rocsafe_mavlink.protocols.command_call import set_interval
from rocsafe_mavlink.protocols.mission_download import Download, DownloadStage
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.protocols.mission_results import MissionType
from rocsafe_mavlink.protocols.stream_rates import StreamRates
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.texts import TextJoiner

Target = tuple[int, int]


@dataclass(slots=True)
class Member:
    """One vehicle of a station.

    Attributes
    ----------
    vehicle: what is known of it.
    us: our (system, component).
    separation_m: geoid above the ellipsoid where it does not tell; NaN if not known.
    address: from where it speaks; held while it is in contact.
    flight: its present or last flight.
    errand: the operator's present or last order.
    errand_count: orders so far.
    rates: of its messages.
    texts: those of several messages.
    reader: of its parameters, from when its kind is known.
    download: of its mission or fence, while one is under way.
    stored: the mission that lies on it, as read back since it was last found; None: not read.
    fence: the polygons of its fence; None: not read.
    fence_error: why its fence cannot be read; empty while it may be.
    """

    vehicle: Vehicle
    us: Target
    separation_m: float = math.nan
    address: Address | None = None
    flight: Flight | None = None
    errand: Errand | None = None
    errand_count: int = 0
    rates: StreamRates = field(default_factory=StreamRates)
    texts: TextJoiner = field(default_factory=TextJoiner)
    reader: ParameterReader | None = None
    download: Download | None = None
    stored: tuple[MissionItem, ...] | None = None
    fence: Fence | None = None
    fence_error: str = ''
    _was_lost: bool = False

    @classmethod
    def of(cls, target: Target, us: Target, separation_m: float | None) -> 'Member':
        """Return a member that was not heard yet."""
        vehicle = Vehicle(system=target[0], component=target[1])
        return cls(vehicle, us, math.nan if separation_m is None else separation_m)

    @property
    def target(self) -> Target:
        """Its (system, component)."""
        return self.vehicle.system, self.vehicle.component

    @property
    def is_flying(self) -> bool:
        """Whether a flight of ours is under way."""
        return self.flight is not None and not self.flight.is_over

    def autopilot(self) -> Autopilot:
        """Return the tables of its kind.

        Raises
        ------
        ValueError: if it was never heard, or is of no kind that is known.
        """
        if self.vehicle.autopilot is None:
            raise ValueError('the vehicle was never heard')
        return autopilot_of(self.vehicle.autopilot, self.vehicle.vehicle_type)

    def _kind(self) -> Autopilot | None:
        try:
            return self.autopilot()
        except ValueError:
            # Something else stands where a multicopter should: it is listened to, and no more.
            return None

    def knowledge(self) -> Knowledge:
        """Return what was read from it besides."""
        return Knowledge(parameters=self.reader, fence=self.fence, fence_error=self.fence_error)

    def may_hear(self, address: Address, now_s: float) -> bool:
        """Whether `address` may speak for it: one at a time, until it falls silent."""
        if self.address != address:
            if self.vehicle.contact(now_s) in (Contact.FRESH, Contact.STALE):
                return False
            self.address = address
        return True

    def take(self, message: Message, now_s: float) -> tuple[list[Event], list[Message]]:
        """Take one of its messages; return what happened and what to send."""
        heard = self.texts.late(now_s)
        if message.name == 'STATUSTEXT':
            heard += self.texts.take(message, now_s)
        else:
            heard.append(text_of_event(message) if message.name == 'EVENT' else message)
        answers = [self._take(one, now_s) for one in heard]
        events = [event for happened, _ in answers for event in happened]
        return events, [one for _, sent in answers for one in sent]

    def _take(self, message: Message, now_s: float) -> tuple[list[Event], list[Message]]:
        self.vehicle, events = reduce(self.vehicle, message, now_s, self.separation_m)
        self.rates.hear(message.name, now_s)
        if any(event.kind is EventKind.REBOOTED for event in events):
            self._forget()
        sent: list[Message] = []
        if self.flight is not None:
            self.flight, sent = self.flight.on_message(message, now_s)
        if self.errand is not None:
            self.errand, more = self.errand.on_message(message, now_s)
            sent = sent + more
        if self.reader is not None:
            self.reader = self.reader.on_message(message)
        return events, sent + self._read(message, now_s)

    def tick(self, now_s: float) -> list[Message]:
        """Let time pass; return what to send."""
        sent: list[Message] = []
        if self.flight is not None:
            self.flight, sent = self.flight.on_tick(self.vehicle, now_s)
        if self.errand is not None:
            self.errand, more = self.errand.on_tick(self.vehicle, now_s)
            sent = sent + more
        contact = self.vehicle.contact(now_s)
        if contact is Contact.LOST:
            self._was_lost = True
        if contact is not Contact.FRESH:
            return sent
        if self._was_lost:
            # What lies on it may be another mission by now.
            self._was_lost, self.stored = False, None
            self.forget_fence()
        return sent + self._asked(now_s) + self._look(now_s)

    def forget_fence(self) -> None:
        """Forget its fence, which may be another by now, and what was read of it so far."""
        self.fence, self.fence_error = None, ''
        if self.download is not None and self.download.mission_type == MissionType.FENCE:
            self.download = None

    def _forget(self) -> None:
        """Forget what a vehicle that was started again may no longer have."""
        self.stored = self.reader = self.download = None
        self.forget_fence()
        flight = self.flight
        if flight is not None and flight.stage is FlightStage.FLYING:
            cause = flight.cause or Outcome.RESTARTED
            reason = flight.reason or 'the autopilot was started again'
            self.flight = replace(flight, cause=cause, reason=reason)

    def _asked(self, now_s: float) -> list[Message]:
        kind = self._kind()
        due = self.rates.due(now_s, frozenset() if kind is None else kind.unsent)
        return [] if due is None else [set_interval(self.target, *due)]

    def _look(self, now_s: float) -> list[Message]:
        """Read from it what is not known: in the air its mission, on the ground its settings.

        Its fence is read in both: a route may take the place of another in the air.
        """
        if self.download is not None:
            self.download, sent = self.download.on_tick(now_s)
            return sent + self._read_on()
        if not self.vehicle.is_armed:
            self.stored = None
        if self._is_beginning:
            return []
        if self.vehicle.is_armed and self.stored is None:
            return self._begin(MissionType.MISSION, now_s)
        if self.errand is not None and not self.errand.is_over:
            return []
        if self.fence is None and not self.fence_error:
            return self._begin(MissionType.FENCE, now_s)
        return [] if self.vehicle.is_armed else self._read_parameters(now_s)

    @property
    def _is_beginning(self) -> bool:
        return self.flight is not None and self.flight.stage not in (
            FlightStage.FLYING,
            FlightStage.OVER,
        )

    def _begin(self, kind: MissionType, now_s: float) -> list[Message]:
        self.download, sent = Download(target=self.target, mission_type=kind).begin(now_s)
        return sent

    def _read(self, message: Message, now_s: float) -> list[Message]:
        if self.download is None:
            return []
        self.download, sent = self.download.on_message(message, now_s)
        return sent + self._read_on()

    def _read_on(self) -> list[Message]:
        """Keep what was read, if reading is over."""
        done = self.download
        if done is None or done.stage not in (DownloadStage.DONE, DownloadStage.FAILED):
            return []
        self.download = None
        if done.mission_type == MissionType.MISSION:
            self.stored = done.items
        elif done.stage is DownloadStage.DONE:
            self.fence = _fence(done.items)
        else:
            self.fence_error = done.error
        return []

    def _read_parameters(self, now_s: float) -> list[Message]:
        kind = self._kind()
        if kind is None:
            return []
        if self.reader is None:
            self.reader = ParameterReader(autopilot=kind.number, target=self.target, found={})
        self.reader, sent = self.reader.on_tick(now_s)
        return sent


def _fence(items: tuple[MissionItem, ...]) -> Fence:
    try:
        return fence_of(items)
    except ValueError:
        # It makes no polygon: the autopilot does not keep to it either.
        return Fence()
