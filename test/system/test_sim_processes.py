# SPDX-License-Identifier: Apache-2.0
"""World and vehicle as processes: killed without warning, they lose and change nothing."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

rclpy = pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.action import ActionClient  # noqa: E402
from rclpy.node import Node  # noqa: E402
from std_srvs.srv import SetBool  # noqa: E402

from rocsafe_geo.frame import LocalFrame  # noqa: E402
from rocsafe_geo.position import GeoPosition  # noqa: E402
from rocsafe_interfaces.action import FlyRoute  # noqa: E402
from rocsafe_interfaces.msg import GeoPoint, Route, ShotReceipt, Viewpoint  # noqa: E402
from rocsafe_interfaces.srv import Lease  # noqa: E402
from rocsafe_ros.conversions import ns_of_stamp  # noqa: E402
from rocsafe_ros.interfaces import topics  # noqa: E402

pytestmark = pytest.mark.system

FRAME = LocalFrame(GeoPosition(53.28, -9.06, 0.0))
DEADLINE_S = 60.0
RETRY_S = 2.0


class Processes:
    """World and one vehicle, started and killed at will; stopped at the end."""

    def __init__(self, domain_id: int, spool: Path) -> None:
        self._environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(domain_id),
            'PYTHONPATH': os.pathsep.join(sys.path),
        }
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        home = FRAME.position_of((-20.0, 5.0, 0.0))
        self._arguments = {
            'world': (
                *('-p', 'participants:=[rav1]', '-p', 'autostart:=false'),
                *('-p', 'start_time_s:=1700000000.0'),
            ),
            'rav': (
                *('-r', '__ns:=/rav1', '-p', f'spool_directory:={spool}', '-p', 'scene:=field'),
                *('-p', f'home_latitude_deg:={home.latitude_deg!r}'),
                *('-p', f'home_longitude_deg:={home.longitude_deg!r}'),
                *('-p', 'origin_latitude_deg:=53.28', '-p', 'origin_longitude_deg:=-9.06'),
            ),
        }

    def start(self, name: str, *more: str) -> None:
        """Start `world` or `rav`, with more arguments for ROS."""
        command = [sys.executable, '-m', f'rocsafe_sim.{name}_node', '--ros-args']
        self._running[name] = subprocess.Popen(
            [*command, *self._arguments[name], *more], env=self._environment
        )

    def kill(self, name: str) -> None:
        """End a process as a crash would."""
        self._running[name].kill()
        self._running[name].wait(timeout=DEADLINE_S)

    def stop(self) -> list[int]:
        """End all as Ctrl-C would and return their exit codes."""
        for process in self._running.values():
            process.send_signal(signal.SIGINT)
        try:
            return [process.wait(timeout=DEADLINE_S) for process in self._running.values()]
        finally:
            for process in self._running.values():
                process.kill()


@pytest.fixture
def processes(ros_domain_id: int, tmp_path: Path) -> Iterator[Processes]:
    """Return processes that are ended after the test."""
    made = Processes(ros_domain_id, tmp_path / 'spool')
    yield made
    made.stop()


def patience(condition: Callable[[], bool], longest_s: float) -> Callable[[], bool]:
    """Return a condition that also holds after `longest_s`."""
    end = time.monotonic() + longest_s
    return lambda: condition() or time.monotonic() > end


class Ground:
    """Listens to the vehicle, stores its photographs, sends its route."""

    def __init__(self, ros: Any) -> None:
        self._ros = ros
        self.node = Node('ground', context=ros.context)
        ros.executor.add_node(self.node)
        self.shots: dict[str, tuple[str, int]] = {}
        self.fixes: dict[int, tuple[float, float, float]] = {}
        self._receipts = topics.create_publisher(self.node, topics.RECEIPTS)
        topics.create_subscription(self.node, topics.SHOT, self._on_shot, 'rav1')
        topics.create_subscription(self.node, topics.FIX, self._on_fix, 'rav1')
        self._action = ActionClient(self.node, FlyRoute, 'rav1/fly_route')
        self._run = self.node.create_client(SetBool, 'world/run')
        self._lease = self.node.create_client(Lease, 'rav1/lease')

    def _on_shot(self, shot: Any) -> None:
        self.shots[shot.shot_id] = (shot.sha256, ns_of_stamp(shot.header.stamp))
        self._receipts.publish(
            ShotReceipt(vehicle=shot.vehicle, shot_id=shot.shot_id, sha256=shot.sha256)
        )

    def _on_fix(self, fix: Any) -> None:
        place = (fix.latitude, fix.longitude, fix.altitude)
        stamp = ns_of_stamp(fix.header.stamp)
        assert self.fixes.setdefault(stamp, place) == place, 'a fix was repeated differently'

    def wait(self, future: Any) -> Any:
        """Return the result of a future."""
        self._ros.spin_until(future.done, DEADLINE_S)
        return future.result()

    def send_route(self) -> Any:
        """Send the route until it is accepted and return a future of its result.

        A killed server seems to be there for as long as its DDS lease: what is sent to it is lost.
        """
        end = time.monotonic() + DEADLINE_S
        while time.monotonic() < end:
            goal = FlyRoute.Goal(route=_route(), plan_id='plan', lease=self.take_lease())
            accepted = self._action.send_goal_async(goal)
            self._ros.spin_until(patience(accepted.done, RETRY_S), DEADLINE_S)
            if accepted.done():
                return accepted.result().get_result_async()
        raise AssertionError('the route was never accepted')

    def take_lease(self) -> str:
        """Take the lease, which survives a kill, and return what orders carry."""
        request = Lease.Request(holder='ground', duration_s=3600.0)
        end = time.monotonic() + DEADLINE_S
        while time.monotonic() < end:
            answer = self._lease.call_async(request)
            self._ros.spin_until(patience(answer.done, RETRY_S), DEADLINE_S)
            if answer.done():
                assert answer.result().control.epoch == 1, answer.result()
                return str(answer.result().control.lease)
        raise AssertionError('the lease was never granted')

    def run_world(self) -> None:
        """Let time run."""
        self._ros.spin_until(self._run.service_is_ready, DEADLINE_S)
        assert self.wait(self._run.call_async(SetBool.Request(data=True))).success

    def spin_until_shots(self, count: int) -> None:
        """Wait until so many photographs are here."""
        self._ros.spin_until(lambda: len(self.shots) >= count, DEADLINE_S)


def _point(east: float, north: float, up: float) -> GeoPoint:
    place = FRAME.position_of((east, north, up))
    return GeoPoint(
        latitude=place.latitude_deg, longitude=place.longitude_deg, altitude=place.altitude_m
    )


def _route() -> Route:
    return Route(
        vehicle='rav1',
        home=_point(-20.0, 5.0, 0.0),
        viewpoints=[
            Viewpoint(
                id=number,
                position=_point(18.0 * number, 0.0, 32.0),
                height_agl_m=32.0,
                yaw_rad=0.1,
            )
            for number in range(4)
        ],
    )


def _fly(ros: Any, processes: Processes, killed: str, speed: float) -> Ground:
    """Fly the route, killing and starting again what is named after the first photograph."""
    ground = Ground(ros)
    processes.start('world', '-p', f'speed:={speed}')
    processes.start('rav')
    result = ground.send_route()
    ground.run_world()
    ground.spin_until_shots(1)
    if killed == 'world':
        processes.kill('world')
        processes.start('world', '-p', f'speed:={speed}')
    elif killed == 'rav':
        processes.kill('rav')
        processes.start('rav')
        result = ground.send_route()
    outcome = ground.wait(result).result
    assert (outcome.outcome, outcome.error_msg) == (FlyRoute.Result.COMPLETED, '')
    assert outcome.viewpoints_visited == 4
    ground.spin_until_shots(4)
    assert processes.stop() == [0, 0]
    ground.node.destroy_node()
    return ground


_FIRST: dict[str, tuple[str, int]] = {}
_FIXES: dict[int, tuple[float, float, float]] = {}


@pytest.mark.parametrize(
    ('speed', 'killed'),
    [
        (0.0, 'nobody'),
        (25.0, 'rav'),
        pytest.param(25.0, 'world', marks=pytest.mark.all),
        pytest.param(25.0, 'nobody', marks=pytest.mark.all),
        pytest.param(0.0, 'rav', marks=pytest.mark.all),
        pytest.param(0.0, 'world', marks=pytest.mark.all),
    ],
)
def test_flight_is_the_same_whoever_is_killed(
    ros: Any, processes: Processes, killed: str, speed: float
) -> None:
    """At any speed, and whatever is killed, the same photographs and fixes come, bit by bit."""
    ground = _fly(ros, processes, killed, speed)
    assert sorted(ground.shots) == [f'rav1-{number:05d}' for number in range(4)]
    _FIRST.update(_FIRST or ground.shots)
    assert ground.shots == _FIRST
    for stamp, place in ground.fixes.items():
        assert _FIXES.setdefault(stamp, place) == place
