# SPDX-License-Identifier: Apache-2.0
"""The example in C++: built where rclcpp is, and run against a vehicle's topics."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from std_srvs.srv import Trigger

from rocsafe_interfaces.msg import RadiationReading
from rocsafe_ros.interfaces import topics

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'cpp'
BUILD_S, RUN_S = 300.0, 60.0


def missing() -> str:
    """Return what the example needs and this machine lacks; empty: nothing."""
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    for package in ('rclcpp', 'ament_cmake', 'rocsafe_interfaces'):
        if not any((Path(prefix) / 'share' / package / 'cmake').is_dir() for prefix in prefixes):
            return f'no CMake package {package} in AMENT_PREFIX_PATH: needs ROS 2 with C++'
    return '' if shutil.which('cmake') else 'no cmake here'


pytestmark = [
    pytest.mark.all,
    pytest.mark.system,
    pytest.mark.skipif(bool(missing()), reason=missing()),
]


@pytest.fixture(scope='module')
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the built example."""
    folder = tmp_path_factory.mktemp('cpp')
    for step in (['-S', str(EXAMPLE), '-B', str(folder)], ['--build', str(folder)]):
        done = subprocess.run(
            ['cmake', *step], capture_output=True, text=True, timeout=BUILD_S, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    return folder / 'watch_vehicle'


@pytest.fixture
def watching(program: Path, own_domain: None) -> Iterator[subprocess.Popen[str]]:
    """Return the example as it watches rav1."""
    command = [str(program), '--ros-args', '-r', '__ns:=/rav1', '-p', 'limit_usvh:=50.0']
    started = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    yield started
    started.kill()
    started.wait(RUN_S)


def test_it_holds_the_vehicle_above_the_limit(
    ros: object, watching: subprocess.Popen[str]
) -> None:
    """Readings below the limit are let pass; the first above it is followed by one hold."""
    vehicle = Node('rav', namespace='/rav1', context=ros.context)
    ros.executor.add_node(vehicle)
    calls = []

    def on_hold(_request: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        calls.append(1)
        answer.success = True
        return answer

    vehicle.create_service(Trigger, 'hold', on_hold)
    readings = vehicle.create_publisher(RadiationReading, 'radiation', topics.RADIATION.qos)
    ros.spin_until(lambda: readings.get_subscription_count() > 0, RUN_S)
    readings.publish(RadiationReading(dose_rate_usvh=49.0))

    def has_held() -> bool:
        readings.publish(RadiationReading(dose_rate_usvh=51.0))
        return bool(calls)

    try:
        ros.spin_until(has_held, RUN_S)
        ros.spin_until(lambda: watching.poll() is not None, RUN_S)
    finally:
        vehicle.destroy_node()
    assert watching.returncode == 0
    assert len(calls) == 1
