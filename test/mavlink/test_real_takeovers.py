# SPDX-License-Identifier: Apache-2.0
"""Takeovers, failsafes and exclusions in flights of a real ArduCopter in its own simulator.

`ROCSAFE_SITL` names its executable; without it these flights are skipped. No node: the station
speaks to the simulator over UDP, in the simulator's time.
"""

import contextlib
import time

import pytest
from shapely.geometry import Point, Polygon
from test.fakes.fake_autopilot import HOME
from test.mavlink import sitl
from test.mavlink.airspace import HARMLESS, free_port
from test.mavlink.real_copter import SECOND_STATION
from test.mavlink.test_flight import plan
from test.mavlink.test_homeward import CORNERS, SQUARE, around
from test.mavlink.test_station import US, spec_of

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_mavlink.autopilots.ardupilot import AUTO, LOITER, RTL
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.station import Station
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.errors import CommandRefusedError, WaitError
from rocsafe_mavlink.flight.flight_journal import Assignment, FlightJournal
from rocsafe_mavlink.link.endpoint import parse_endpoint
from rocsafe_mavlink.link.link import Link, LinkIdentity, LinkRules
from rocsafe_mavlink.link.transport import open_transport
from rocsafe_mavlink.plan.fence import Fence, fence_items
from rocsafe_mavlink.wire.dialect import Message, encode
from rocsafe_mavlink.wire.framing import pack_frame

pytestmark = [
    pytest.mark.skipif(not sitl.BINARY, reason='ROCSAFE_SITL names no ArduPilot simulator'),
    pytest.mark.system,
    pytest.mark.all,
]
SPEEDUP = 4.0
BATTERY = {'BATT_LOW_VOLT': 11.0, 'BATT_FS_LOW_ACT': 2}
FENCED = {'OA_TYPE': 2, 'FENCE_ENABLE': 1, 'FENCE_TYPE': 4, 'FENCE_ACTION': 1}


class Rig:
    """A simulator and a station in the simulator's time."""

    def __init__(self, folder, **parameters):
        port = free_port()
        self.copter = sitl.SitlCopter(1, port, folder / 'sitl', SPEEDUP, parameters)
        endpoint = parse_endpoint(f'udp://127.0.0.1:{port}')
        rules = LinkRules(is_discovering=True)
        identity = LinkIdentity(system=US[0], component=US[1])
        self.station = Station(open_transport(endpoint), Link(rules, identity))
        session = VehicleSession.of((1, 1), US, separation_m=47.0)
        self.drone = Drone(spec_of(1), session, FlightJournal())
        self.station.add(self.drone)
        self.is_supervised = True
        self.texts, self.track = [], []
        # Its second link is known once it has answered there.
        self.copter.set('SIM_BATT_VOLTAGE', 12.6)
        self._began = time.monotonic()
        self._frame = LocalFrame(GeoPosition(*HOME, 0.0))
        self.drone.listen(self._note, lambda _event: None)

    @property
    def now_s(self):
        """Steady time of the simulator, about."""
        return SPEEDUP * (time.monotonic() - self._began)

    @property
    def vehicle(self):
        """What is known of the copter."""
        return self.drone.vehicle

    @property
    def commands(self):
        """What people may command."""
        return self.drone.commands

    def _note(self, message):
        if message.name == 'STATUSTEXT':
            self.texts.append(message['text'])
        if message.name == 'GLOBAL_POSITION_INT' and self.vehicle.motion is not None:
            place = self.vehicle.motion.position
            level = GeoPosition(place.latitude_deg, place.longitude_deg, 0.0)
            self.track.append(tuple(self._frame.enu_of(level).tolist()[:2]))

    def step(self):
        """Let a little time pass."""
        now_s = self.now_s
        self.station.take(now_s, time.time())
        self.drone.step(now_s)
        self.station.tick(now_s, time.time(), is_supervised=self.is_supervised)
        time.sleep(0.005)

    def until(self, condition, limit_s=300.0):
        """Step until `condition` holds."""
        end_s = self.now_s + limit_s
        while not condition():
            assert self.now_s < end_s, f'not within {limit_s} s: {self.texts[-5:]}'
            self.step()

    def wait(self, seconds):
        """Let time pass."""
        end_s = self.now_s + seconds
        self.until(lambda: self.now_s > end_s, seconds + 60.0)

    def begin(self, flown, count):
        """Begin to fly a plan as soon as the vehicle is ready."""
        ids = tuple(range(count))
        assignment = Assignment(plan_id='p', plan=flown, viewpoint_ids=ids)

        def is_begun():
            try:
                self.drone.fly(assignment, self.now_s)
            except WaitError:
                return False
            return True

        self.until(is_begun)

    def fly(self, flown, count):
        """Fly a plan until its first waypoint is behind."""
        self.begin(flown, count)
        self.until(lambda: self.drone.flight.visited >= 1 or self.drone.flight.is_over)
        assert not self.drone.flight.is_over, self.drone.flight.reason

    def orders(self):
        """Return the orders that reached the copter so far."""
        self.copter.tap.hear_all()
        return [order for order in self.copter.tap.told if order not in HARMLESS]

    def switch(self, mode):
        """Switch its mode from the second station, as its pilot would by his stick."""
        fields = {'target_system': 1, 'target_component': 1, 'command': 176}
        message = Message('COMMAND_LONG', {**fields, 'param1': 1.0, 'param2': float(mode)})
        self.say(message)

    def say(self, message):
        """Say something from the second station."""
        data = pack_frame(*encode(message), *SECOND_STATION, 0, sign=False)
        self.copter._control.sendto(data, self.copter._peer)

    def outcome(self):
        """Return how the last command ended."""
        return self.commands.outcome(self.commands.count)

    def close(self):
        """End all."""
        self.copter.close()
        self.station.close()


@pytest.fixture
def rig(tmp_path):
    """Give a function that starts a simulator with parameters."""
    made = []

    def start(**parameters):
        made.append(Rig(tmp_path, **parameters))
        return made[-1]

    yield start
    for one in made:
        one.close()


@pytest.mark.parametrize('before_s', [1.0, 2.5, 4.0])
def test_battery_failsafe_in_the_middle_of_a_new_route(rig, before_s):
    """Whatever step it falls into: from its first sign on nothing is ordered, and it lands."""
    one = rig(**BATTERY)
    one.fly(plan(6), 6)
    one.copter.set('SIM_BATT_VOLTAGE', 10.6)
    one.wait(10.0 - before_s)
    with contextlib.suppress(CommandRefusedError):
        one.commands.replace_route(plan(4), one.now_s)
    one.until(lambda: any('Battery Failsafe' in text for text in one.texts), 30.0)
    before = one.orders()
    one.until(lambda: not one.vehicle.is_armed, 200.0)
    assert one.orders() == before
    assert one.vehicle.custom_mode == RTL


def test_pilot_takes_over_while_the_start_is_repeated(rig, monkeypatch):
    """The answer to MISSION_START never comes; LOITER is left alone."""
    one = rig()
    take = VehicleSession.take
    is_answer = lambda said: said.name == 'COMMAND_ACK' and said['command'] == 300  # noqa: E731
    monkeypatch.setattr(
        VehicleSession,
        'take',
        lambda self, said, now_s: [] if is_answer(said) else take(self, said, now_s),
    )
    one.begin(plan(4), 4)
    one.until(lambda: 'COMMAND_LONG 300' in one.copter.tap.told)
    one.switch(LOITER)
    one.until(lambda: one.vehicle.custom_mode == LOITER, 20.0)
    before = one.orders()
    one.wait(20.0)
    assert one.orders() == before
    assert one.vehicle.custom_mode == LOITER


def test_return_after_a_lost_link_is_not_called_back(rig):
    """The bridge falls silent and comes back: everything is refused until it has landed."""
    one = rig(FS_GCS_ENABLE=1, MAV_GCS_SYSID=255)
    one.fly(plan(6), 6)
    one.is_supervised = False
    one.until(lambda: one.vehicle.custom_mode == RTL, 60.0)
    one.is_supervised = True
    before = one.orders()
    for order in (
        lambda: one.commands.resume(one.now_s),
        lambda: one.commands.replace_route(plan(4), one.now_s),
        lambda: one.commands.hold(one.now_s),
    ):
        with pytest.raises(CommandRefusedError, match='not ours to command'):
            order()
    one.until(lambda: not one.vehicle.is_armed, 200.0)
    assert one.orders() == before


def test_fence_drawn_in_the_air_by_another_station_is_told(rig):
    """A hold is offered; nothing is ordered."""
    one = rig()
    one.fly(plan(6), 6)
    before = one.orders()
    corners = ((-30, -30), (30, -30), (30, 90), (-30, 90))
    ring = tuple(offset(GeoPosition(*HOME), *corner) for corner in corners)
    items = fence_items(Fence(inclusions=(ring,)))
    target = {'target_system': 1, 'target_component': 1, 'mission_type': 1}
    one.say(Message('MISSION_COUNT', {**target, 'count': len(items)}))
    for number in range(len(items)):
        item = items[number].message(number, (1, 1), 1)
        one.copter._ask(item, lambda said: said.name.startswith('MISSION_'))
    one.until(lambda: one.drone.status(one.now_s).advice == 'hold', 60.0)
    assert 'its fence was changed' in one.drone.status(one.now_s).text
    assert [order for order in one.orders()[len(before) :] if 'COMMAND' in order] == []


def test_failsafe_returns_around_the_exclusion(rig):
    """ArduCopter's own path planner keeps it out, as the check before the flight supposes."""
    one = rig(**BATTERY, **FENCED)
    one.until(lambda: one.vehicle.home is not None)
    one.until(lambda: one.drone.session.readout.settings.rally is not None)
    one.commands.push_fence(Fence(exclusions=(SQUARE,)), one.now_s)
    one.until(lambda: one.outcome() is not None, 60.0)
    assert one.outcome() == ''
    one.begin(around(clearance_m=10.0), 1)
    one.until(lambda: bool(one.track) and one.track[-1][1] > 130.0 and one.track[-1][0] < 15.0)
    one.copter.set('SIM_BATT_VOLTAGE', 10.6)
    one.until(lambda: one.vehicle.custom_mode == RTL, 60.0)
    assert one.track[-1][1] > 100.0
    one.until(lambda: not one.vehicle.is_armed, 300.0)
    zone = Polygon(CORNERS)
    assert min(zone.distance(Point(place)) for place in one.track) > 0.0


def test_commanded_return_flies_around(rig):
    """By a mission of its own, without any path planner of the autopilot."""
    one = rig(**FENCED)
    one.until(lambda: one.drone.session.readout.settings.rally is not None)
    one.commands.push_fence(Fence(exclusions=(SQUARE,)), one.now_s)
    one.until(lambda: one.outcome() is not None, 60.0)
    one.begin(around(clearance_m=10.0), 1)
    one.until(lambda: bool(one.track) and one.track[-1][1] > 130.0 and one.track[-1][0] < 15.0)
    one.commands.return_home(one.now_s)
    one.until(lambda: one.outcome() is not None, 60.0)
    assert one.outcome() == ''
    assert one.vehicle.custom_mode == AUTO
    one.until(lambda: not one.vehicle.is_armed, 300.0)
    zone = Polygon(CORNERS)
    assert min(zone.distance(Point(place)) for place in one.track) > 5.0


def test_flight_after_one_that_was_broken_off_begins_at_its_first_item(rig):
    """The autopilot forgets the item of before as soon as its motors stand still."""
    one = rig()
    one.fly(plan(4), 4)
    one.until(lambda: one.drone.flight.visited >= 2)
    one.commands.return_home(one.now_s)
    one.until(lambda: one.drone.flight.is_over)
    one.fly(plan(2), 2)
    assert len(one.drone.flight.plan.waypoints) == 2
