# SPDX-License-Identifier: Apache-2.0
"""The bridge as a process, killed in each state of upload and flight: the vehicle flies on.

The copter is a process of its own as well; it prints what it is told. Started again, the bridge
finds plan, mission and progress, and tells the vehicle nothing but which messages it needs.
"""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

import rclpy
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from test.fakes.fake_autopilot import HOME
from test.mavlink.airspace import free_port
from test.mavlink.operator_post import survey

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import VehicleState
from rocsafe_ros import topics

pytestmark = pytest.mark.system

REPOSITORY = Path(__file__).parents[2]
DEADLINE_S = 60.0
RATE = 12.0
# Nothing of this changes what a vehicle does.
HARMLESS = {'COMMAND_LONG 511', 'COMMAND_LONG 512'}
COUNT = 8
REPEAT_S = 2.0


class Post:
    """A copter and a bridge as processes, and an operator in this one."""

    def __init__(self, domain_id, folder):
        self._folder = folder
        self._environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(domain_id),
            'PYTHONPATH': os.pathsep.join(path for path in sys.path if path),
        }
        self._port = free_port()
        self._told = (folder / 'told.txt').open('wb')
        script = REPOSITORY / 'test' / 'fakes' / 'fake_process.py'
        self._copter = subprocess.Popen(
            [sys.executable, script, '--to', f'127.0.0.1:{self._port}', '--rate', str(RATE)],
            env=self._environment,
            stdout=self._told,
        )
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain_id)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._node = Node('operator', context=self._context)
        self._executor.add_node(self._node)
        self._client = ActionClient(self._node, FlyRoute, 'rav1/fly_route')
        self.state = VehicleState()
        topics.create_subscription(self._node, topics.STATE, self._on_state, 'rav1')
        self.start()

    def start(self):
        """Start the bridge."""
        values = {
            'vehicles': '[rav1]',
            'links': f'["udp://127.0.0.1:{self._port}"]',
            'geoid_separations_m': '[47.0]',
            'speeds_mps': '[10.0]',
            'hovers_s': '[0.0]',
            'position_rate_hz': '2.0',
            'origin_latitude_deg': str(HOME[0]),
            'origin_longitude_deg': str(HOME[1]),
            'state_directory': str(self._folder / 'state'),
        }
        arguments = [part for key, value in values.items() for part in ('-p', f'{key}:={value}')]
        command = [sys.executable, '-m', 'rocsafe_mavlink.bridge_node', '--ros-args', *arguments]
        self._bridge = subprocess.Popen(command, env=self._environment)

    def kill(self):
        """End the bridge as a crash would; what it said is no longer the state."""
        self._bridge.kill()
        self._bridge.wait()
        self.state = VehicleState()

    def told(self):
        """Return what the copter was told so far, a line each."""
        return [
            line.partition(' ')[2] for line in (self._folder / 'told.txt').read_text().splitlines()
        ]

    def orders(self):
        """Return those that change what it does."""
        return [line for line in self.told() if line not in HARMLESS]

    def until(self, condition):
        """Spin until `condition` holds."""
        end = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < end, self.told()[-10:]
            self._executor.spin_once(timeout_sec=0.02)

    def fly(self):
        """Send the route; return the future of the result."""
        self.until(self._client.server_is_ready)
        goal = FlyRoute.Goal(route=survey(COUNT, height_m=20.0), plan_id='p1')
        sent = []

        def is_accepted():
            # Whoever was killed seems to be there for a while: what nobody takes is sent again.
            if not sent or time.monotonic() - sent[-1][0] > REPEAT_S:
                sent.append((time.monotonic(), self._client.send_goal_async(goal)))
            return any(future.done() for _, future in sent)

        self.until(is_accepted)
        accepted = next(future for _, future in sent if future.done())
        return accepted.result().get_result_async()

    def close(self):
        """End all."""
        for process in (self._bridge, self._copter):
            process.send_signal(signal.SIGKILL)
            process.wait()
        self._told.close()
        self._client.destroy()
        self._node.destroy_node()
        self._executor.shutdown(timeout_sec=2.0)
        rclpy.shutdown(context=self._context)

    def _on_state(self, message):
        self.state = message


@pytest.fixture
def post(ros_domain_id, tmp_path):
    """Give a bridge to kill."""
    made = Post(ros_domain_id, tmp_path)
    yield made
    made.close()


def has(post, order, count=1):
    """Whether the copter was given an order so often."""
    return lambda: post.orders().count(order) >= count


@pytest.mark.parametrize('visited', [0, 3, COUNT])
def test_flight_is_picked_up(post, visited):
    """Killed while climbing, on its way and on the way home: not one order is sent again."""
    post.fly()
    is_up = (VehicleState.TAKING_OFF, VehicleState.FLYING)
    post.until(lambda: post.state.state in is_up and post.state.viewpoints_visited >= visited)
    post.kill()
    before = post.orders()
    post.start()
    post.until(lambda: post.state.plan_id == 'p1' and post.state.viewpoints_visited >= visited)
    result = post.fly()
    post.until(result.done)
    answer = result.result().result
    assert (answer.outcome, answer.viewpoints_visited) == (FlyRoute.Result.COMPLETED, COUNT)
    assert post.orders() == before


@pytest.mark.parametrize(
    'last',
    ['MISSION_COUNT 0', 'COMMAND_LONG 176', 'COMMAND_LONG 400'],
    ids=['uploading', 'switching', 'arming'],
)
def test_flight_that_has_not_begun_begins_again(post, last):
    """Killed before take-off: nothing is armed by finding it, and the route is flown once."""
    post.fly()
    post.until(has(post, last))
    post.kill()
    before = len(post.orders())
    post.start()
    post.until(lambda: post.state.state != VehicleState.UNKNOWN)
    assert post.orders()[before:] == []
    result = post.fly()
    post.until(result.done)
    answer = result.result().result
    assert (answer.outcome, answer.viewpoints_visited) == (FlyRoute.Result.COMPLETED, COUNT)
    assert post.orders().count('COMMAND_LONG 300') == 1


def test_flight_that_ended_unwatched_is_not_flown_again(post):
    """Killed in the air and started after the landing: the goal gets the result."""
    post.fly()
    post.until(lambda: post.state.viewpoints_visited >= COUNT - 1)
    post.kill()
    end = time.monotonic() + (COUNT * 40.0 / 10.0 + 60.0) / RATE
    post.until(lambda: time.monotonic() > end)
    before = post.orders()
    post.start()
    result = post.fly()
    post.until(result.done)
    answer = result.result().result
    assert (answer.outcome, answer.viewpoints_visited) == (FlyRoute.Result.COMPLETED, COUNT)
    assert post.orders() == before
