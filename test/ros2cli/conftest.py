# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests of the ros2 command."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from test.conftest import reserved_domain

DEADLINE_S = 60.0


@pytest.fixture(scope='session')
def ros_domain_id(default_domain: int | None) -> Iterator[int]:
    """Reserve a domain for this folder: its robot poses as a vehicle to the session's end."""
    if default_domain is None:
        pytest.skip('no ROS 2 here: source it or run make setup')
    with reserved_domain() as number:
        yield number


@pytest.fixture(scope='session')
def robot(ros_domain_id: int) -> Iterator[Any]:
    """Spin a node that has one of everything."""
    pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    from .ros2_cli_robot import Robot

    machine = Robot(ros_domain_id)
    yield machine
    machine.close()


@pytest.fixture(scope='session')
def participant(ros_domain_id: int, robot: Any) -> Iterator[Any]:
    """Hold a context that has met the robot; a hidden node keeps it on the graph."""
    rclpy = pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    from rclpy.context import Context

    context = Context()
    rclpy.init(context=context, domain_id=ros_domain_id)
    anchor = rclpy.create_node('_anchor', context=context, enable_rosout=False)
    end = time.monotonic() + DEADLINE_S
    while not robot.is_known_to(anchor):
        assert time.monotonic() < end, 'the robot is not found'
        time.sleep(0.02)
    yield context
    anchor.destroy_node()
    rclpy.shutdown(context=context)


@pytest.fixture
def ros2(
    own_domain: None,
    participant: Any,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> Callable[..., tuple[int, str, str]]:
    """Run the command in this process; returns exit status, output and errors.

    Its nodes join one participant, so that discovery is paid once and not by every test.
    """
    from rocsafe_ros2cli import command_node
    from rocsafe_ros2cli.cli import main

    monkeypatch.setattr(command_node, 'open_context', lambda: participant)
    monkeypatch.setattr(command_node, 'close_context', lambda _context: None)

    def run(*words: str) -> tuple[int, str, str]:
        try:
            status = main(words)
        except SystemExit as end:  # argparse
            status = int(end.code or 0)
        return status, *capsys.readouterr()

    return run


@pytest.fixture
def ros2_process(own_domain: None) -> Iterator[Callable[..., 'subprocess.Popen[str]']]:
    """Start the command in a process of its own; those left over are killed after the test."""
    started: list[subprocess.Popen[str]] = []

    def start(*words: str, **options: Any) -> 'subprocess.Popen[str]':
        path = os.pathsep.join(entry for entry in sys.path if entry)
        environment = {**os.environ, 'PYTHONPATH': path, **options.pop('environment', {})}
        process = subprocess.Popen(
            [sys.executable, '-m', 'rocsafe_ros2cli', *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
            **options,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate(timeout=DEADLINE_S)
