# SPDX-License-Identifier: Apache-2.0
"""A ground station for several vehicles on one link: bytes in, bytes out, no sockets, no clock.

Vehicles are told apart by (system, component), never by address alone; each keeps its own state,
flight, orders and rates. Heartbeats are sent only while whoever supervises us lives, or the
vehicle would not notice that it is alone.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from rocsafe_mavlink.drone.member import Member
from rocsafe_mavlink.errors import NotAllowedError
from rocsafe_mavlink.flight.flight import Flight, adopted, fly
from rocsafe_mavlink.flight.flight_plan import FlightPlan, Mission, mission_of
from rocsafe_mavlink.flight.operator_commands import Desk, Writer
from rocsafe_mavlink.flight.preflight import Check, FlightLimits, failures, preflight, route_checks
from rocsafe_mavlink.knowledge.events import Event
from rocsafe_mavlink.knowledge.vehicle import Contact, Vehicle
from rocsafe_mavlink.link.link import Address, Link
from rocsafe_mavlink.wire.counters import Reason
from rocsafe_mavlink.wire.dialect import Message

HEARTBEAT_PERIOD_S = 1.0
# MAV_TYPE_GCS, MAV_AUTOPILOT_INVALID, MAV_STATE_ACTIVE.
HEARTBEAT = Message(
    'HEARTBEAT', {'type': 6, 'autopilot': 8, 'system_status': 4, 'mavlink_version': 3}
)
Target = tuple[int, int]
Outgoing = list[tuple[Address, bytes]]
Heard = tuple[Target, Message]


@dataclass(slots=True)
class Received:
    """What came of bytes.

    Attributes
    ----------
    messages: believable ones of our vehicles.
    events: what happened.
    outgoing: what to send.
    """

    messages: list[Heard]
    events: list[tuple[Target, Event]]
    outgoing: Outgoing


class Station:
    """Serves the vehicles named by `targets`; others on the link are not looked at.

    Parameters
    ----------
    link: reads and writes the bytes.
    targets: (system, component) of each vehicle.
    us: our own.
    separations_m: geoid above the ellipsoid of vehicles that do not tell; absent if not known.
    """

    def __init__(
        self,
        link: Link,
        targets: Iterable[Target],
        us: Target,
        separations_m: dict[Target, float] | None = None,
    ) -> None:
        self._link = link
        self._us = us
        given = separations_m or {}
        self._members = {target: Member.of(target, us, given.get(target)) for target in targets}
        self._beat_s = -HEARTBEAT_PERIOD_S

    @property
    def link(self) -> Link:
        """The link, with its counters."""
        return self._link

    def member(self, target: Target) -> Member:
        """Return all that is kept of a vehicle; KeyError if it is none of ours."""
        return self._members[target]

    def vehicle(self, target: Target) -> Vehicle:
        """Return what is known of a vehicle; KeyError if it is none of ours."""
        return self._members[target].vehicle

    def flight(self, target: Target) -> Flight | None:
        """Return the present or last flight of a vehicle."""
        return self._members[target].flight

    def receive(self, address: Address, data: bytes, now_s: float, time_s: float) -> Received:
        """Take bytes from an address; return what came of them."""
        came = Received([], [], [])
        for message in self._link.receive(address, data, now_s, time_s):
            target = (message.system, message.component)
            member = self._members.get(target)
            if member is None or not member.may_hear(address, now_s):
                self._link.counters.drop(Reason.UNKNOWN_PEER)
                continue
            events, sent = member.take(message, now_s)
            came.messages.append((target, message))
            came.events += [(target, event) for event in events]
            came.outgoing += self._packed(member, sent, now_s, time_s)
        return came

    def tick(self, now_s: float, time_s: float, *, is_supervised: bool) -> Outgoing:
        """Let time pass; return what to send."""
        outgoing: Outgoing = []
        if is_supervised and now_s - self._beat_s >= HEARTBEAT_PERIOD_S - 1e-6:
            self._beat_s = now_s
            outgoing += [
                (peer, self._link.pack(HEARTBEAT, now_s, time_s)) for peer in self._link.peers
            ]
        for member in self._members.values():
            outgoing += self._packed(member, member.tick(now_s), now_s, time_s)
        return outgoing

    # What is asked of a vehicle.

    def checks(
        self, target: Target, plan: FlightPlan | None, limits: FlightLimits, now_s: float
    ) -> tuple[Check, ...]:
        """Return every look before a flight of `plan`, or without a plan at the vehicle alone.

        Raises
        ------
        ValueError: if the vehicle was never heard, or is of no kind that is known.
        """
        member = self._members[target]
        knowledge = member.knowledge()
        return preflight(member.vehicle, member.autopilot(), plan, limits, now_s, knowledge)

    def route_checks(
        self, target: Target, plan: FlightPlan, limits: FlightLimits
    ) -> tuple[Check, ...]:
        """Return every look at the way of a plan that is to be flown in place of another."""
        member = self._members[target]
        return route_checks(member.vehicle, plan, limits, member.knowledge())

    def fly(
        self, target: Target, plan: FlightPlan, limits: FlightLimits, now_s: float, time_s: float
    ) -> Outgoing:
        """Begin a flight; return what to send.

        Raises
        ------
        ValueError: saying which check failed, or that a flight is under way.
        """
        member = self._members[target]
        if member.is_flying:
            raise ValueError('a flight is under way')
        failed = failures(self.checks(target, plan, limits, now_s))
        if failed:
            raise ValueError(failed)
        member.flight, sent = fly(plan, member.autopilot(), member.vehicle, self._us, now_s)
        return self._packed(member, sent, now_s, time_s)

    def adopt(self, target: Target, plan: FlightPlan, *, is_torn: bool = False) -> bool:
        """Take up the flight that a vehicle is on, if it flies `plan`; send nothing.

        Of a mission that `is_torn` only a part needs to lie on the vehicle.
        """
        member = self._members[target]
        if member.stored is None:
            return False
        autopilot = member.autopilot()
        stored = None if is_torn else member.stored
        flight = adopted(plan, autopilot, member.vehicle, stored, self._us)
        member.flight = member.flight if flight is None else flight
        return flight is not None

    def order(self, target: Target, write: Writer, *, preempts: bool = False) -> None:
        """Begin the errand that `write` makes; `tick` sends it.

        With `preempts` it takes the place of one that is under way.

        Raises
        ------
        ValueError: if another is under way, or the vehicle was never heard.
        """
        member = self._members[target]
        desk = Desk(autopilot=member.autopilot(), target=target, us=self._us)
        if member.errand is not None and not member.errand.is_over and not preempts:
            raise ValueError(f'{member.errand.name} is under way')
        member.errand = write(desk, member.vehicle)
        member.errand_count += 1

    def fly_instead(self, target: Target, plan: FlightPlan, limits: FlightLimits) -> Mission:
        """Begin to fly another plan in the air; `tick` sends it.

        Raises
        ------
        ValueError: as `order`, or if nothing is being flown, or saying what of the way may not
            be flown.
        """
        member = self._members[target]
        if not member.is_flying or member.flight is None:
            raise ValueError('no flight is under way')
        failed = failures(self.route_checks(target, plan, limits))
        if failed:
            raise ValueError(failed)
        mission = mission_of(plan, member.autopilot())
        self.order(target, lambda desk, _vehicle: desk.fly_instead(mission))
        return mission

    def require_contact(self, target: Target, now_s: float) -> Vehicle:
        """Return what is known of a vehicle that is in contact and in the air.

        Raises
        ------
        ValueError: saying what is amiss.
        """
        vehicle = self._members[target].vehicle
        contact = vehicle.contact(now_s)
        if contact is not Contact.FRESH:
            raise ValueError(f'the vehicle is not in contact ({contact.value})')
        if vehicle.is_on_ground:
            raise ValueError('the vehicle is on the ground')
        return vehicle

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
