# SPDX-License-Identifier: Apache-2.0
"""A bridge that stood still (stopped, swapped out, asleep) acts on nothing that is old."""

import socket
import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from std_srvs.srv import Trigger
from test.mavlink.airspace import HARMLESS, Airspace
from test.mavlink.operator_post import Ground, survey
from test.mavlink.test_flight import plan
from test.mavlink.test_withdrawal import changes, flying, replacing

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.srv import Resume
from rocsafe_mavlink.autopilots.ardupilot import BRAKE, LOITER
from rocsafe_mavlink.drone.standstill import SETTLED_S, Standstill
from rocsafe_mavlink.knowledge.telemetry import STALE_AFTER_S, Contact
from rocsafe_mavlink.link.endpoint import Endpoint, EndpointKind
from rocsafe_mavlink.link.transport import UdpTransport
from rocsafe_mavlink.wire.dialect import Message, encode
from rocsafe_mavlink.wire.framing import pack_frame
from rocsafe_ros.interfaces import topics


class Clock:
    """A clock that goes on as it is told, or with the wall."""

    def __init__(self, *, is_running=False):
        self.ahead_s = 0.0
        self._is_running = is_running

    def __call__(self):
        """Return its time."""
        return self.ahead_s + (time.monotonic() if self._is_running else 0.0)


def test_gap_between_two_looks_is_told_once():
    """And for a while after it nothing is believed."""
    clock = Clock()
    still = Standstill(clock)
    clock.ahead_s += 60.0
    assert (still.look(), still.is_deaf) == (0.0, False), 'its start is no gap'
    clock.ahead_s += STALE_AFTER_S
    assert (still.look(), still.is_deaf) == (0.0, False)
    clock.ahead_s += 60.0
    assert (still.look(), still.is_deaf) == (60.0, True)
    clock.ahead_s += SETTLED_S - 0.1
    assert (still.look(), still.is_deaf) == (0.0, True)
    clock.ahead_s += 0.2
    assert (still.look(), still.is_deaf) == (0.0, False)


def test_start_and_new_route_are_withdrawn():
    """Whatever step they have reached; the vehicle is not in contact until its next heartbeat."""
    air = flying()
    number = replacing(air)
    session, commands = air.drones[1].session, air.drones[1].commands
    session.forget_contact('the bridge stood still for 60 s', air.now_s)
    assert commands.outcome(number) == 'new route: withdrawn: the bridge stood still for 60 s'
    assert session.telemetry.contact(air.now_s) is Contact.LOST
    air.wait(20.0)
    assert [change for change in changes(air) if change != (176, float(BRAKE))] == []
    assert session.telemetry.contact(air.now_s) is Contact.FRESH
    commands.replace_route(plan(4), air.now_s)


@pytest.mark.parametrize('is_caller', [False, True])
def test_what_waits_in_a_buffer_is_thrown_away(is_caller):
    """All that the system kept, and nothing that comes later."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.bind(('127.0.0.1', 0))
        kind = EndpointKind.UDP_OUT if is_caller else EndpointKind.UDP
        port = vehicle.getsockname()[1] if is_caller else 0
        transport = UdpTransport(Endpoint(kind=kind, host='127.0.0.1', port=port))
        for number in range(500):
            vehicle.sendto(b'old %d' % number, ('127.0.0.1', transport.port))
        transport.discard(0.0)
        assert transport.take(0.0) == []
        vehicle.sendto(b'new', ('127.0.0.1', transport.port))
        assert [data for _, data in transport.take(0.0)] == [b'new']
        transport.close()


@pytest.fixture
def post(ros, tmp_path):
    """Give a bridge whose clock can be set forward, and its copter in flight."""
    air = Airspace()
    ground = Ground(ros, air, tmp_path)
    ground.clock = Clock(is_running=True)
    ground.bridge._standstill._clock = ground.clock
    yield ground
    ground.close()
    air.close()


def test_no_command_is_sent_on_what_was_heard_before(post):
    """The pilot takes the vehicle while the bridge stands still in the middle of a new route.

    Datagrams of the time before wait in its socket and show a vehicle that obeys it; newer ones
    found no room.
    """
    post.in_air()
    route = survey(3)
    goal = FlyRoute.Goal(route=route, plan_id='p2', replace=True, lease=post.lease())
    sent = post.action.send_goal_async(goal)
    copter = post.air.copters[1]
    with post.air.calm():
        post.until(lambda: copter.mode == BRAKE)
        for _ in range(200):
            post.air.step()
        copter.is_silent, copter.mode = True, LOITER
        told = len(post.air.told())
        served, old = post.air._served, {'type': 2, 'autopilot': 3, 'base_mode': 0x81}
        beat = Message('HEARTBEAT', {**old, 'custom_mode': BRAKE, 'system_status': 4})
        for _ in range(5):
            data = pack_frame(*encode(beat), 1, 1, 0, sign=False)
            served.socket.sendto(data, served.station)
        post.clock.ahead_s += 60.0
        post.until(lambda: sent.done())
        result = sent.result().get_result_async()
        post.until(result.done)
        assert 'the bridge stood still for 60 s' in result.result().result.error_msg
        assert set(post.air.told()[told:]) <= HARMLESS
        (interface,) = post.bridge._interfaces
        assert interface.drone.vehicle.contact(time.monotonic()) is Contact.LOST
        answer = post.call('rav1/resume', Resume)
        assert not answer.success
        assert 'the bridge stood still, and the order may be old' in answer.message
        copter.is_silent = False
        post.listen(topics.STATE)
        post.until(lambda: 'LOITER' in post.seen().text)
        post.until(lambda: 'old' not in post.call('rav1/resume', Resume).message)
        assert 'LOITER' in post.call('rav1/resume', Resume).message
        assert set(post.air.told()[told:]) <= HARMLESS
        assert copter.mode == LOITER


def test_take_off_that_was_ordered_before_is_none(ros, tmp_path):
    """Who gave the order may stand beside the vehicle by now.

    The bridge may take it before it sees that it stood still, or after.
    """
    air = Airspace()
    ground = Ground(ros, air, tmp_path)
    clock = ground.bridge._standstill._clock = Clock(is_running=True)
    ground.listen(topics.FIX)
    ground.until(lambda: ground.heard['fix', 'rav1'])
    ground.lease()
    clock.ahead_s += 20.0
    assert 'the bridge stood still' in ground.ended(ground.fly()).error_msg
    assert not air.copters[1].is_armed
    ground.close()
    air.close()


def test_hold_is_obeyed_again_some_seconds_later(post):
    """As soon as the vehicle is heard anew."""
    post.in_air()
    post.clock.ahead_s += 10.0
    post.until(lambda: post.call('rav1/hold', Trigger).success)
