# SPDX-License-Identifier: Apache-2.0
"""The bridge as a process, killed in each state of upload and flight: the vehicle flies on.

Started again, it finds plan, mission and progress, and tells the vehicle nothing but which
messages it needs. The same with the fake copter and, where ROCSAFE_SITL names one, a real one.
"""

import itertools
import math
import os
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

import rclpy
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger
from test.fakes.fake_autopilot import HOME
from test.mavlink.airspace import HARMLESS, SET_CURRENT, told_once, write_drones
from test.mavlink.autopilots import AUTOPILOTS, make_airspace
from test.mavlink.operator_post import survey

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import VehicleState
from rocsafe_interfaces.srv import Lease, Resume
from rocsafe_ros.interfaces import topics
from rocsafe_ros.plan_digest import route_digest

pytestmark = pytest.mark.system

DEADLINE_S = 120.0
COUNT = 8
HEIGHTS_M = {'p1': 20.0, 'p2': 25.0}
REPEAT_S = 2.0
PAUSE_OR_RESUME = 'COMMAND_LONG 193'
# Of a fake copter whose way is watched from another process, and while that process starts.
WATCHED, CLOSELY_WATCHED, SLOW = 15.0, 3.0, 1.0


class Post:
    """A bridge as a process, and copter and operator in this one."""

    def __init__(self, domain_id, folder, air, **drone):
        self._folder = folder
        self._drone = drone
        self._environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(domain_id),
            'PYTHONPATH': os.pathsep.join(path for path in sys.path if path),
        }
        self.air = air
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain_id)
        self._executor = SingleThreadedExecutor(context=self._context)
        self.node = Node('operator', context=self._context)
        self._executor.add_node(self.node)
        self._client = ActionClient(self.node, FlyRoute, 'rav1/fly_route')
        self.state, self._began_s = VehicleState(), 0.0
        topics.create_subscription(self.node, topics.STATE, self._on_state, 'rav1')
        self.start()

    def start(self):
        """Start the bridge."""
        values = {
            'drones_file': write_drones(self._folder, self.air.link, **self._drone),
            'position_rate_hz': '2.0',
            'origin_latitude_deg': str(HOME[0]),
            'origin_longitude_deg': str(HOME[1]),
            'state_directory': str(self._folder / 'state'),
        }
        arguments = [part for key, value in values.items() for part in ('-p', f'{key}:={value}')]
        command = [sys.executable, '-m', 'rocsafe_mavlink.bridge_node', '--ros-args', *arguments]
        self._began_s = time.time()
        self._bridge = subprocess.Popen(command, env=self._environment)

    def kill(self):
        """End the bridge as a crash would; what it said is no longer the state."""
        self._bridge.kill()
        self._bridge.wait()
        self.state, self._began_s = VehicleState(), math.inf

    def start_again(self):
        """Kill it and start it; return the orders before, those under way at its end included."""
        self.kill()
        self.air.hear_all()
        before = self.orders()
        self.start()
        return before

    def orders(self):
        """Return what the copter was told that changes what it does."""
        return [order for order in self.air.told() if order not in HARMLESS]

    def until(self, condition):
        """Fly and spin until `condition` holds."""
        end = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < end, (self.state, self.orders()[-10:])
            self.air.step()
            self._executor.spin_once(timeout_sec=0.02)

    def call(self, name, request=None):
        """Call a service; return its answer."""
        kind = {'lease': Lease, 'resume': Resume}.get(name, Trigger)
        client = self.node.create_client(kind, f'rav1/{name}')
        self.until(client.service_is_ready)
        answers = self._answered(lambda: client.call_async(request or kind.Request()))
        # Asked twice, one may be refused because the other is under way.
        return max(answers, key=lambda answer: answer.success)

    def lease(self):
        """Take the lease, which survives a kill, and return what orders carry."""
        answer = self.call('lease', Lease.Request(holder='post', duration_s=3600.0))
        assert answer.success, answer.message
        assert answer.control.epoch == 1
        return answer.control.lease

    def fly(self, plan_id='p1', *, replace=False):
        """Send the route; return the future of the result."""
        self.until(self._client.server_is_ready)
        route = survey(COUNT, height_m=HEIGHTS_M[plan_id], step_m=60.0)
        goal = FlyRoute.Goal(
            route=route,
            plan_id=plan_id,
            replace=replace,
            lease=self.lease(),
            confirmation=route_digest(plan_id, route),
        )
        *_, accepted = self._answered(lambda: self._client.send_goal_async(goal))
        return accepted.get_result_async()

    def _answered(self, ask):
        """Ask until there is an answer; return it, and those to what was asked after it."""
        sent = []

        def is_answered():
            # Whoever was killed seems to be there for a while: what nobody takes is sent again.
            if not sent or time.monotonic() - sent[-1][0] > REPEAT_S:
                sent.append((time.monotonic(), ask()))
            return any(future.done() for _, future in sent)

        self.until(is_answered)
        heard = list(itertools.dropwhile(lambda future: not future.done(), (f for _, f in sent)))
        # They reached the same bridge: an order that comes late would look like one of its own.
        self.until(lambda: all(future.done() for future in heard))
        return [future.result() for future in heard]

    def close(self):
        """End all."""
        self._bridge.send_signal(signal.SIGKILL)
        self._bridge.wait()
        # First: what it still waits for must not be destroyed.
        self._executor.shutdown(timeout_sec=2.0)
        self._client.destroy()
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)

    def _on_state(self, message):
        # What a bridge that was killed has said may come later.
        if message.header.stamp.sec + message.header.stamp.nanosec / 1e9 >= self._began_s:
            self.state = message


@pytest.fixture(params=AUTOPILOTS)
def post(request, ros_domain_id, tmp_path):
    """Give a bridge to kill."""
    air = make_airspace(request.param, tmp_path, rate=3.0)
    made = Post(ros_domain_id, tmp_path, air)
    yield made
    made.close()
    air.close()


def completed(post, plan_id='p1'):
    """Send the route again and fly to its end."""
    result = post.fly(plan_id)
    post.until(result.done)
    answer = result.result().result
    found = (answer.outcome, answer.viewpoints_visited, answer.error_msg)
    assert found == (FlyRoute.Result.COMPLETED, COUNT, '')


def is_known(post, *states, visited=0):
    """Whether the bridge says of the flight that it is so far."""

    def holds():
        said = post.state
        return said.plan_id == 'p1' and said.state in states and said.viewpoints_visited >= visited

    return holds


def test_flight_is_picked_up_each_time(post):
    """Killed while it climbs, is on its way, is held, and flies home: no order is sent again.

    What is held goes on when the operator says so, and not before.
    """
    in_air = (VehicleState.TAKING_OFF, VehicleState.FLYING, VehicleState.RETURNING)
    post.fly()
    for visited in (0, 2, COUNT):
        with post.air.calm(WATCHED):
            post.until(is_known(post, *in_air, visited=max(visited - 1, 0)))
        # On a busy machine the way home, or the climb, could pass between two reports.
        with post.air.calm(CLOSELY_WATCHED):
            post.until(is_known(post, *in_air, visited=visited))
            before = post.start_again()
        with post.air.calm(SLOW):
            # On a busy machine it may have come home meanwhile.
            landed = (VehicleState.LANDING, VehicleState.LANDED) if visited == COUNT else ()
            post.until(is_known(post, *in_air, *landed, visited=visited))
            assert post.orders() == before
            if visited == 2:
                hold_and_resume(post)
    before = post.orders()
    completed(post)
    assert post.orders() == before


def hold_and_resume(post):
    """Kill the bridge while the flight is held; resume it."""
    before = len(post.orders())
    while not (answer := post.call('hold')).success:
        assert 'contact' in answer.message
    held = post.start_again()
    post.until(is_known(post, VehicleState.HOLDING))
    assert post.orders() == held
    resume(post)
    # Asked twice where an answer was lost; by its mode where it cannot pause.
    assert set(post.orders()[before:]) <= {PAUSE_OR_RESUME, 'COMMAND_LONG 176'}


def resume(post):
    """Let the vehicle go on; a bridge that has just begun has to look at it first.

    Of two calls the second may be answered first: the order of the other is under way.
    """
    request = Resume.Request(lease=post.lease())
    while not (answer := post.call('resume', request)).success:
        assert 'still being read' in answer.message or 'resume is under way' in answer.message


@pytest.mark.all
def test_flight_that_has_not_begun_begins_again(post):
    """Killed while uploading, switching and arming: nothing is armed by finding it.

    The route is flown once, when the motors that the killed bridge started have stopped: a start
    that waits for that is withdrawn, since a person may have stopped them.
    """
    for last in ('MISSION_COUNT 0', 'COMMAND_LONG 176', 'COMMAND_LONG 400'):
        count = post.orders().count(last)
        with post.air.calm():
            post.fly()
            post.until(lambda last=last, count=count: post.orders().count(last) > count)
            before = post.start_again()
            post.until(lambda: post.state.state != VehicleState.UNKNOWN)
        assert post.orders() == before
    post.until(lambda: post.state.state != VehicleState.ARMED)
    completed(post)
    # A PX4 takes off as soon as it is armed: whoever armed it, and was killed, began the flight.
    starts = 1 if post.air.begins_with == SET_CURRENT else 0
    assert told_once(post.orders()).count('COMMAND_LONG 300') == starts


@pytest.mark.all
def test_flight_that_ended_unwatched_is_not_flown_again(post):
    """Killed in the air and started after the landing: the goal gets the result."""
    post.fly()
    with post.air.calm(WATCHED):
        post.until(lambda: post.state.viewpoints_visited >= COUNT - 1)
    post.kill()
    post.until(lambda: not post.air.is_armed())
    before = post.orders()
    post.start()
    completed(post)
    assert post.orders() == before


@pytest.mark.all
def test_route_that_was_being_replaced_is_picked_up(post):
    """Killed while a new route is uploaded and begun in the air: it is known which one is flown.

    No order is sent; what stands still goes on when the operator says so.
    """
    post.fly()
    with post.air.calm(WATCHED):
        post.until(is_known(post, VehicleState.FLYING, visited=1))
        killed_while_replacing(post, 'MISSION_COUNT 0')
    post.until(lambda: post.state.state == VehicleState.HOLDING and post.state.plan_id == 'p1')
    killed_while_replacing(post, post.air.begins_with)
    if post.air.begins_with == SET_CURRENT:
        post.until(lambda: post.state.state == VehicleState.HOLDING and post.state.plan_id == 'p2')
        resume(post)
    completed(post, 'p2')


def killed_while_replacing(post, last):
    """Replace the route; kill the bridge when it has sent `last`: its next run orders nothing."""
    count = post.orders().count(last)
    with post.air.calm(SLOW):
        post.fly('p2', replace=True)
        post.until(lambda: post.orders().count(last) > count)
        before = post.start_again()
        post.until(lambda: post.state.state != VehicleState.UNKNOWN)
    assert post.orders() == before
