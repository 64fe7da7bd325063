# SPDX-License-Identifier: Apache-2.0
"""The bridge against a copter that was written apart from the project and misbehaves on request.

`ROCSAFE_TRIALS` names the folder of `hostile_copter.py`; without it these tests are skipped.
"""

import contextlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from test.mavlink.airspace import free_port
from test.mavlink.operator_post import Ground, survey

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.srv import Resume

COPTER = Path(os.environ.get('ROCSAFE_TRIALS', '')) / 'hostile_copter.py'
pytestmark = pytest.mark.skipif(
    not COPTER.is_file(), reason='ROCSAFE_TRIALS names no folder with hostile_copter.py'
)
DEADLINE_S = 120.0


class HostileAir:
    """A hostile copter as a process; it flies by itself."""

    def __init__(self, log, *arguments):
        port = free_port()
        self.link = f'udp://127.0.0.1:{port}'
        self.copters = {1: None}
        self._log = log
        with log.open('w') as output:
            self._process = subprocess.Popen(
                [sys.executable, COPTER, '--port', str(port), *arguments], stdout=output
            )

    def step(self):
        """Do nothing: it flies by itself."""

    def calm(self, _rate=1.0):
        """Change nothing."""
        return contextlib.nullcontext()

    def lines(self):
        """Return what it wrote, in order, without the times."""
        return [line[8:].strip() for line in self._log.read_text().splitlines()]

    def commanded_after(self, line):
        """Return the commands that came after the first line with `line`, but rates."""
        lines = self.lines()
        start = next(number for number, found in enumerate(lines) if line in found)
        return [found for found in lines[start:] if re.match(r'CMD \d', found)]

    def close(self):
        """End it."""
        self._process.kill()
        self._process.wait()


@pytest.fixture
def start(ros, tmp_path):
    """Give a function that starts a hostile copter with a bridge to it."""
    made = []

    def begin(*arguments):
        air = HostileAir(tmp_path / 'copter.log', *arguments)
        made.append(Ground(ros, air, tmp_path / 'state'))
        return made[-1]

    yield begin
    for ground in made:
        ground.close()
        ground.air.close()


def test_route_is_flown(start):
    """It drops a tenth of all messages, asks by the old request and sends all twice."""
    ground = start('--drop', '0.1', '--old-request', '--dup')
    result = ground.ended(ground.fly(), DEADLINE_S)
    assert (result.outcome, result.viewpoints_visited) == (FlyRoute.Result.COMPLETED, 4)


def test_failsafe_during_a_new_route_is_not_countermanded(start):
    """Link and battery failsafe come in the middle of the second upload: it returns and lands."""
    ground = start('--failsafe-on-upload', '2')
    first = ground.in_air(survey(12), DEADLINE_S)
    second = ground.fly('p2', survey(8, height_m=20.0), replace=True)
    answer = ground.ended(second, DEADLINE_S)
    assert answer.outcome == FlyRoute.Result.REJECTED
    assert ground.ended(first, DEADLINE_S).outcome != FlyRoute.Result.COMPLETED
    ground.listen_for(10.0)
    assert ground.air.commanded_after('-> 6 by') == []


def test_start_is_not_repeated_against_the_pilot(start):
    """The answer to MISSION_START is lost and the pilot switches to LOITER."""
    ground = start('--takeover', 'launch', '--drop-ack', '300')
    ground.fly()
    ground.until(lambda: any('PILOT' in line for line in ground.air.lines()), DEADLINE_S)
    ground.listen_for(10.0)
    assert ground.air.commanded_after('PILOT') == []


def test_mission_that_reads_back_wrong_is_not_resumed(start):
    """One item of the second route is stored 300 m high; it loses its link, too, and returns."""
    ground = start('--corrupt-item', '4', '--corrupt-from-upload', '2')
    ground.in_air(survey(12), DEADLINE_S)
    second = ground.fly('p2', survey(8, height_m=20.0), replace=True)
    answer = ground.ended(second, DEADLINE_S)
    assert answer.outcome == FlyRoute.Result.REJECTED
    assert not ground.call('rav1/resume', Resume).success
    assert ground.air.commanded_after('-> 6 by') == []
