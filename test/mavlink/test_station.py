# SPDX-License-Identifier: Apache-2.0
"""One station, several vehicles, one link of bytes: nothing is mixed up, lost or overdone."""

import copy
import functools

import numpy as np
import pytest
from test.fakes.fake_autopilot import HOME, IDS, FakeCopter
from test.mavlink.test_flight import plan
from test.mavlink.wire import (
    DRONE,
    HEARTBEAT,
    NOW_S,
    STRANGER,
    frame,
    open_link,
    signed_frame,
    signed_link,
)

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.checks.check import CheckVerdict
from rocsafe_mavlink.drone.drone import Drone, DroneSpec
from rocsafe_mavlink.drone.station import Station
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.errors import WaitError
from rocsafe_mavlink.flight.flight_journal import Assignment, FlightJournal
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.knowledge.events import EventKind
from rocsafe_mavlink.knowledge.telemetry import LOST_AFTER_S, STALE_AFTER_S, Contact
from rocsafe_mavlink.plan.flight_limits import FlightLimits
from rocsafe_mavlink.protocols.stream_rates import WANTED
from rocsafe_mavlink.wire.counters import Reason
from rocsafe_mavlink.wire.dialect import Message, decode, encode
from rocsafe_mavlink.wire.framing import pack_frame, scan

US = (255, 190)
TICK_S = 0.1
LIMITS = FlightLimits()


class Wires:
    """A transport in memory."""

    def __init__(self):
        self.arrived = []
        self.sent = []

    def take(self, _now_s):
        """Return what has come since the last call."""
        arrived, self.arrived = self.arrived, []
        return arrived

    def send(self, address, data):
        """Keep what is sent."""
        self.sent.append((address, data))
        return True

    def close(self):
        """Do nothing."""


def spec_of(system, limits=LIMITS):
    """Return what a drone is."""
    frame = LocalFrame(GeoPosition(*HOME, 535.0))
    return DroneSpec(name=f'rav{system}', target=(system, 1), frame=frame, limits=limits)


class Air:
    """Copters and a station with bytes between them, some of them lost."""

    def __init__(self, count=1, loss=0.0, seed=1, limits=LIMITS, **rules):
        self.copters = {number + 1: FakeCopter(number + 1) for number in range(count)}
        self.link = open_link(**rules)
        self.wires = Wires()
        self.station = Station(self.wires, self.link)
        self.drones = {}
        for system in self.copters:
            session = VehicleSession.of((system, 1), US)
            self.drones[system] = Drone(spec_of(system, limits), session, FlightJournal())
            self.station.add(self.drones[system])
        self.source = np.random.default_rng(seed)
        self.loss = loss
        self.now_s = 0.0
        self.is_supervised = True
        self.events = []
        self.drones[1].listen(lambda _message: None, self.note)
        self.sent = []

    def note(self, event):
        """Keep an event; a copy of the air keeps its own."""
        self.events.append(event)

    def step(self):
        """Let a tenth of a second pass."""
        self.now_s = round(self.now_s + TICK_S, 3)
        for system, copter in self.copters.items():
            for message in copter.step(self.now_s):
                self.say(pack_frame(*encode(message), system, 1, 0, sign=False))
        self.station.tick(self.now_s, NOW_S + self.now_s, is_supervised=self.is_supervised)
        self.carry()

    def say(self, data, address=DRONE):
        """Bring bytes to the station."""
        if self.source.random() >= self.loss:
            self.wires.arrived.append((address, data))
            self.station.take(self.now_s, NOW_S + self.now_s)
            self.carry()

    def carry(self):
        """Bring what the station sends to the copters."""
        outgoing, self.wires.sent = self.wires.sent, []
        for address, data in outgoing:
            assert address == DRONE
            (frame,) = scan(data, is_whole=True).frames
            message = decode(frame.message_id, frame.payload, frame.system, frame.component)
            self.sent.append(message)
            target = message.fields.get('target_system', 0)
            for system, copter in self.copters.items():
                if target in (0, system) and self.source.random() >= self.loss:
                    copter.receive(message, (frame.system, frame.component))

    def until(self, condition, limit_s=600.0):
        """Step until `condition` holds."""
        end_s = self.now_s + limit_s
        while not condition():
            assert self.now_s < end_s, f'not within {limit_s} s'
            self.step()

    def wait(self, seconds):
        """Let time pass."""
        end_s = self.now_s + seconds
        self.until(lambda: self.now_s >= end_s - 1e-6)

    def fly(self, system=1, count=3):
        """Begin a flight."""
        flown = plan(count)
        assignment = Assignment(plan_id=f'p{count}', plan=flown, viewpoint_ids=tuple(range(count)))
        self.drones[system].fly(assignment, self.now_s)
        self.station.flush(self.now_s, NOW_S + self.now_s)
        self.carry()

    def flight(self, system=1):
        """Return the flight of a copter."""
        return self.drones[system].flight

    def vehicle(self, system=1):
        """Return what is known of a copter."""
        return self.drones[system].vehicle


def ready_air(count=0, limits=LIMITS):
    """Return an air whose copter is ready, or flies with the first of `count` waypoints behind."""
    return copy.deepcopy(_first_air(count, limits))


@functools.cache
def _first_air(count, limits):
    air = Air(limits=limits)
    air.wait(46.0)
    if count:
        air.fly(count=count)
        air.until(lambda: air.flight().visited >= 1)
    return air


@pytest.mark.slow
def test_three_vehicles_on_one_link_are_told_apart():
    """Each flies its own plan; no order reaches another."""
    air = Air(3)
    air.wait(46.0)
    for system in (1, 2, 3):
        air.fly(system, count=system)
    air.until(lambda: all(air.flight(system).is_over for system in (1, 2, 3)))
    assert [air.flight(system).visited for system in (1, 2, 3)] == [1, 2, 3]
    assert {air.flight(system).outcome for system in (1, 2, 3)} == {FlightOutcome.COMPLETED}
    for copter in air.copters.values():
        assert [number for number in copter.commands if number != 511] == [176, 400, 176, 300]


@pytest.mark.slow
@pytest.mark.parametrize(('loss', 'seed'), [(0.05, 1), (0.2, 2), (0.4, 4), (0.4, 5)])
def test_lossy_link_flies_the_whole_route(loss, seed):
    """Messages lost in both directions: it is flown whole, or refused with nothing left armed."""
    air = Air(loss=loss, seed=seed)
    air.until(lambda: air.now_s > 46.0 and may_fly(air))
    air.until(lambda: air.flight().is_over)
    assert air.flight().outcome in (FlightOutcome.COMPLETED, FlightOutcome.REJECTED)
    assert air.flight().outcome is FlightOutcome.COMPLETED or loss > 0.2
    assert not air.copters[1].is_armed


@pytest.mark.slow
def test_one_message_of_five_lost_refuses_hardly_a_flight():
    """Nobody answers the arming now and then; whoever is refused is not armed."""
    outcomes = []
    for seed in range(3, 18):
        air = Air(loss=0.2, seed=seed)
        air.until(lambda air=air: air.now_s > 46.0 and may_fly(air))
        air.until(lambda air=air: air.flight().is_over)
        outcomes.append(air.flight().outcome)
        assert not air.copters[1].is_armed
    assert set(outcomes) <= {FlightOutcome.COMPLETED, FlightOutcome.REJECTED}
    assert outcomes.count(FlightOutcome.COMPLETED) >= 14


def may_fly(air):
    """Begin a flight if every check passes; return whether it began."""
    try:
        air.fly()
    except (ValueError, WaitError):
        return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize('kind', [(0, 2), (3, 1)], ids=['generic autopilot', 'aeroplane'])
def test_what_is_no_multicopter_of_ours_is_only_heard(kind):
    """It is listened to, and never flown; the others on the link are served on."""
    air = Air(2)
    autopilot, vehicle_type = kind
    other = Message(
        'HEARTBEAT',
        {'autopilot': autopilot, 'type': vehicle_type, 'system_status': 3, 'mavlink_version': 3},
    )
    air.copters[1].step = lambda now_s: [other] if round(now_s * 10) % 10 == 0 else []
    air.wait(50.0)
    assert air.vehicle(1).contact(air.now_s) is Contact.FRESH
    with pytest.raises(ValueError, match=r'is not known|is no multicopter'):
        air.fly(1)
    air.fly(2)
    air.until(lambda: air.flight(2).is_over)
    assert air.flight(2).outcome is FlightOutcome.COMPLETED


def test_heartbeats_are_sent_only_while_supervised():
    """A bridge whose supervisor died does not pretend that somebody watches."""
    air = Air()
    air.wait(5.0)
    beats = [message for message in air.sent if message.name == 'HEARTBEAT']
    assert len(beats) == 5
    air.is_supervised = False
    air.sent.clear()
    air.wait(5.0)
    assert not [message for message in air.sent if message.name == 'HEARTBEAT']


def test_rates_are_asked_for_again_after_a_reboot():
    """Only heartbeats come; within seconds everything flows again."""
    air = ready_air()
    air.copters[1].reboot()
    air.until(lambda: air.vehicle().motion is None, 5.0)
    assert EventKind.REBOOTED in {event.kind for event in air.events}
    air.until(lambda: air.vehicle().motion is not None, 10.0)


def test_messages_that_flow_are_not_asked_for(monkeypatch):
    """What the vehicle has is asked for once; what it has not, now and then."""
    monkeypatch.delitem(IDS, WANTED['ATTITUDE'][0])
    air = Air()
    air.wait(30.0)
    asked = [int(message['param1']) for message in air.sent if message.name == 'COMMAND_LONG']
    assert asked.count(33) == 1
    missing = WANTED['ATTITUDE'][0]
    assert 2 <= asked.count(missing) <= 6


def test_another_address_cannot_speak_for_a_vehicle():
    """While it is in contact its address is held; a stranger changes nothing."""
    air = Air(allowed=frozenset({DRONE, STRANGER}))
    air.wait(46.0)
    before = air.vehicle()
    forged = decode(0, b'', 1, 1)
    data = pack_frame(*encode(forged), 1, 1, 0, sign=False)
    air.say(data, STRANGER)
    assert air.vehicle() == before
    assert air.link.counters.dropped(Reason.IMPOSTOR) == 1


BEAT = frame(HEARTBEAT)
ELSEWHERE = ('192.0.2.7', 14550)


def beating(air, address, beats=1, signer=None):
    """Let a vehicle send heartbeats from an address; return whether the last was heard."""
    for _ in range(beats):
        air.now_s += 1.0
        data = signed_frame(HEARTBEAT, time_s=NOW_S + air.now_s) if signer else BEAT
        air.say(data, address)
    return air.drones[1].session.address == address


def unwatched(**rules):
    """Return a sky whose copter is silent, on a link that anybody may join."""
    air = Air(allowed=frozenset(), is_discovering=True, **rules)
    air.copters.clear()
    air.carry = air.wires.sent.clear
    return air


def test_vehicle_that_changes_its_port_is_followed_for_ever():
    """A hundred times: behind a router, or a simulator that is started again."""
    air = unwatched()
    for port in range(100):
        assert beating(air, ('127.0.0.1', 20_000 + port))
        air.now_s += LOST_AFTER_S


def test_other_host_never_takes_the_place_of_an_unsigned_vehicle():
    """Neither while it is heard nor when it is lost; it is counted, and gets no heartbeats."""
    air = unwatched()
    assert beating(air, DRONE)
    assert not beating(air, ELSEWHERE)
    air.now_s += 10 * LOST_AFTER_S
    assert not beating(air, ELSEWHERE, beats=50)
    assert air.link.counters.dropped(Reason.IMPOSTOR) == 51
    assert air.link.stations == (DRONE,)
    assert beating(air, (DRONE[0], 999))


def test_strangers_lock_no_vehicle_out():
    """A thousand ports that spoke first, in the name of another system."""
    air = unwatched()
    for port in range(1000):
        air.say(frame(HEARTBEAT, system=9), ('127.0.0.1', 20_000 + port))
    assert beating(air, DRONE)
    assert air.link.stations == (DRONE,)


def test_holder_of_the_key_moves_within_seconds():
    """With signatures another host may be the vehicle; a stranger without the key never is."""
    air = unwatched()
    air.link = air.station.link = signed_link()
    assert beating(air, DRONE, signer=True)
    assert not beating(air, ELSEWHERE, signer=True)
    air.now_s += STALE_AFTER_S
    assert not beating(air, ELSEWHERE)
    assert beating(air, ELSEWHERE, signer=True)


def test_other_systems_are_not_looked_at():
    """A vehicle that is none of ours leaves nothing behind."""
    air = Air()
    air.copters[9] = FakeCopter(9)
    air.wait(5.0)
    assert air.link.counters.dropped(Reason.UNKNOWN_PEER) > 3


def test_flight_that_may_not_begin_is_refused_with_the_check():
    """Never heard, not ready, and flying another route already."""
    air = Air()
    with pytest.raises(WaitError, match='never heard'):
        air.fly()
    air.wait(15.0)
    with pytest.raises(WaitError, match='fix is the autopilot does not use the receiver'):
        air.fly()
    air.wait(31.0)
    air.fly()
    with pytest.raises(ValueError, match='is flying another route'):
        air.fly(count=4)
    assert air.vehicle().contact(air.now_s) is Contact.FRESH


def test_bytes_of_a_payload_come_from_the_address_of_its_vehicle_only():
    """Any component of the vehicle may send them; they change nothing that is known of it."""
    air = unwatched()
    assert beating(air, DRONE)
    before, got = air.vehicle(), []
    air.drones[1].listen(got.append, lambda _event: None)
    payload = list(b'0.25\n'.ljust(128, b'\0'))
    tunnel = Message('TUNNEL', {'payload_type': 0, 'payload_length': 5, 'payload': payload})
    for system, component, address in ((1, 191, DRONE), (1, 191, STRANGER), (2, 191, DRONE)):
        air.say(pack_frame(*encode(tunnel), system, component, 0, sign=False), address)
    (message,) = got
    assert bytes(message['payload'][: message['payload_length']]) == b'0.25\n'
    assert air.vehicle() == before


TWIN = Message('HEARTBEAT', {'type': 6, 'autopilot': 8, 'custom_mode': 0, 'mavlink_version': 3})


@pytest.mark.slow
@pytest.mark.parametrize(
    ('must_return', 'verdict'), [(True, CheckVerdict.FAIL), (False, CheckVerdict.WARN)]
)
def test_another_station_with_our_number_is_told(must_return, verdict):
    """A second bridge, or a ground station: the vehicle would not notice that we are silent."""
    air = Air(limits=FlightLimits(must_return_on_link_loss=must_return))
    air.station = Station(air.wires, air.link, 7)
    air.station.add(air.drones[1])
    air.wait(46.0)

    def found():
        checks = air.drones[1].checks(plan(3), air.now_s)
        return [check.verdict for check in checks if check.name == 'station']

    echo = Message('HEARTBEAT', {**TWIN.fields, 'custom_mode': 7})
    for beat in (echo, Message('HEARTBEAT', TWIN.fields)):
        # The first is our own, which the link gave back.
        assert found() == []
        air.say(pack_frame(*encode(beat), *US, 0, sign=False))
    assert found() == [verdict]
    assert 'another station speaks as system 255' in air.drones[1].status(air.now_s).text
    air.say(pack_frame(*encode(TWIN), 254, 190, 0, sign=False))
    air.wait(11.0)
    assert found() == []
    assert 'another station' not in air.drones[1].status(air.now_s).text


def test_heartbeats_of_a_station_bear_its_number():
    """By it its own are known from those of others."""
    air = Air()
    air.station = Station(air.wires, air.link, 7)
    air.station.add(air.drones[1])
    air.wait(3.0)
    assert {m['custom_mode'] for m in air.sent if m.name == 'HEARTBEAT'} == {7}
