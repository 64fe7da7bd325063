# SPDX-License-Identifier: Apache-2.0
"""A ground station for several vehicles on one link: bytes in, bytes out, no sockets, no clock.

Vehicles are told apart by (system, component), never by address alone; each keeps its own state,
flight and rates. Heartbeats are sent only while whoever supervises us lives, or the vehicle would
not notice that it is alone.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from rocsafe_mavlink.autopilots import autopilot_of
from rocsafe_mavlink.commands import set_interval
from rocsafe_mavlink.counters import Reason
from rocsafe_mavlink.dialect import Message
from rocsafe_mavlink.errors import NotAllowedError
from rocsafe_mavlink.events import Event
from rocsafe_mavlink.flight import Flight, fly
from rocsafe_mavlink.flight_plan import FlightPlan
from rocsafe_mavlink.link import Address, Link
from rocsafe_mavlink.preflight import FlightLimits, failures, preflight
from rocsafe_mavlink.reducer import reduce
from rocsafe_mavlink.stream_rates import StreamRates
from rocsafe_mavlink.vehicle import Contact, Vehicle

HEARTBEAT_PERIOD_S = 1.0
# MAV_TYPE_GCS, MAV_AUTOPILOT_INVALID, MAV_STATE_ACTIVE.
HEARTBEAT = Message(
    'HEARTBEAT', {'type': 6, 'autopilot': 8, 'system_status': 4, 'mavlink_version': 3}
)
Target = tuple[int, int]
Outgoing = list[tuple[Address, bytes]]


@dataclass(slots=True)
class Member:
    """What the station keeps of one vehicle.

    Attributes
    ----------
    vehicle: what is known of it.
    address: from where it speaks; held while it is in contact.
    flight: its present or last flight.
    rates: of its messages.
    """

    vehicle: Vehicle
    address: Address | None = None
    flight: Flight | None = None
    rates: StreamRates = field(default_factory=StreamRates)


class Station:
    """Serves the vehicles named by `targets`; others on the link are not looked at.

    Parameters
    ----------
    link: reads and writes the bytes.
    targets: (system, component) of each vehicle.
    us: our own.
    """

    def __init__(self, link: Link, targets: Iterable[Target], us: Target) -> None:
        self._link = link
        self._us = us
        self._members = {
            target: Member(Vehicle(system=target[0], component=target[1])) for target in targets
        }
        self._beat_s = -HEARTBEAT_PERIOD_S

    def vehicle(self, target: Target) -> Vehicle:
        """Return what is known of a vehicle; KeyError if it is none of ours."""
        return self._members[target].vehicle

    def flight(self, target: Target) -> Flight | None:
        """Return the present or last flight of a vehicle."""
        return self._members[target].flight

    def receive(
        self, address: Address, data: bytes, now_s: float, time_s: float
    ) -> tuple[list[tuple[Target, Event]], Outgoing]:
        """Take bytes from an address; return what happened, and what to send."""
        events: list[tuple[Target, Event]] = []
        outgoing: Outgoing = []
        for message in self._link.receive(address, data, now_s, time_s):
            target = (message.system, message.component)
            member = self._members.get(target)
            if member is None or not self._may_speak(member, address, now_s):
                self._link.counters.drop(Reason.UNKNOWN_PEER)
                continue
            events += [(target, event) for event in self._take(member, message, now_s)]
            if member.flight is not None:
                member.flight, sent = member.flight.on_message(message, now_s)
                outgoing += self._packed(member, sent, now_s, time_s)
        return events, outgoing

    def tick(self, now_s: float, time_s: float, *, is_supervised: bool) -> Outgoing:
        """Let time pass; return what to send."""
        outgoing: Outgoing = []
        if is_supervised and now_s - self._beat_s >= HEARTBEAT_PERIOD_S - 1e-6:
            self._beat_s = now_s
            outgoing += [
                (peer, self._link.pack(HEARTBEAT, now_s, time_s)) for peer in self._link.peers
            ]
        for target, member in self._members.items():
            if member.flight is not None:
                member.flight, sent = member.flight.on_tick(member.vehicle, now_s)
                outgoing += self._packed(member, sent, now_s, time_s)
            if member.vehicle.contact(now_s) is Contact.FRESH:
                outgoing += self._asked(target, member, now_s, time_s)
        return outgoing

    def fly(
        self, target: Target, plan: FlightPlan, limits: FlightLimits, now_s: float, time_s: float
    ) -> Outgoing:
        """Begin a flight; return what to send.

        Raises
        ------
        ValueError: saying which check failed, or that a flight is under way.
        """
        member = self._members[target]
        vehicle = member.vehicle
        if member.flight is not None and not member.flight.is_over:
            raise ValueError('a flight is under way')
        if vehicle.autopilot is None:
            raise ValueError('the vehicle was never heard')
        autopilot = autopilot_of(vehicle.autopilot, vehicle.vehicle_type)
        failed = failures(preflight(vehicle, autopilot, plan, limits, now_s))
        if failed:
            raise ValueError(failed)
        member.flight, sent = fly(plan, autopilot, vehicle, self._us, now_s)
        return self._packed(member, sent, now_s, time_s)

    def _may_speak(self, member: Member, address: Address, now_s: float) -> bool:
        """Whether `address` may speak for a vehicle: one at a time, until it falls silent."""
        if member.address != address:
            if member.vehicle.contact(now_s) in (Contact.FRESH, Contact.STALE):
                return False
            member.address = address
        return True

    def _take(self, member: Member, message: Message, now_s: float) -> list[Event]:
        member.vehicle, events = reduce(member.vehicle, message, now_s)
        member.rates.hear(message.name, now_s)
        return events

    def _asked(self, target: Target, member: Member, now_s: float, time_s: float) -> Outgoing:
        due = member.rates.due(now_s)
        if due is None:
            return []
        return self._packed(member, [set_interval(target, *due)], now_s, time_s)

    def _packed(
        self, member: Member, messages: Iterable[Message], now_s: float, time_s: float
    ) -> Outgoing:
        outgoing: Outgoing = []
        for message in messages:
            try:
                data = self._link.pack(message, now_s, time_s)
            except NotAllowedError:
                # Too many at once: every order here is repeated by who gave it.
                self._link.counters.drop(Reason.NOT_SENT)
                continue
            outgoing.append((member.address, data))
        return outgoing
