# SPDX-License-Identifier: Apache-2.0
"""The bridge against a copter of other habits, written apart from the other stand-ins."""

import contextlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from test.mavlink.airspace import free_port
from test.mavlink.operator_post import Ground, survey

from rocsafe_interfaces.action import FlyRoute
from rocsafe_ros.interfaces import topics

COPTER = Path(__file__).with_name('second_copter.py')
DEADLINE_S = 120.0
ARM = 'CMD 400 1.0'


class SecondAir:
    """The copter as a process; it flies by itself."""

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

    def close(self):
        """End it."""
        self._process.kill()
        self._process.wait()


@pytest.fixture
def start(ros, tmp_path):
    """Give a function that starts the copter with a bridge to it."""
    made = []

    def begin(*arguments):
        air = SecondAir(tmp_path / 'copter.log', *arguments)
        made.append(Ground(ros, air, tmp_path / 'state'))
        return made[-1]

    yield begin
    for ground in made:
        ground.close()
        ground.air.close()


@pytest.mark.parametrize(
    'habit',
    [
        [],
        pytest.param(['--late-ack', '1.5', '--echo'], marks=pytest.mark.all),
        pytest.param(['--foreign-answers'], marks=pytest.mark.all),
        pytest.param(['--twin'], marks=pytest.mark.all),
        pytest.param(['--junk'], marks=pytest.mark.all),
        pytest.param(['--shape-shift'], marks=pytest.mark.all),
    ],
    ids=lambda habit: ' '.join(habit) or 'well-behaved',
)
def test_route_is_flown_to_its_end(start, habit):
    """Late, repeated and foreign answers, and a second one of its number."""
    ground = start(*habit)
    result = ground.ended(ground.fly(), DEADLINE_S)
    told = (result.outcome, result.viewpoints_visited)
    assert told == (FlyRoute.Result.COMPLETED, 4), result.error_msg
    # A mission is stored once, and its start is not repeated in the air.
    lines = ground.air.lines()
    assert sum(line.startswith('STORED') and line.endswith('kind 0') for line in lines) == 1
    assert lines.count('ARMED False') == 1
    assert sum(line.startswith('CMD 300') for line in lines) == 1


@pytest.mark.all
@pytest.mark.parametrize(
    ('habit', 'words'),
    [
        (['--reject-first'], 'temporarily|rejected|refused'),
        (['--miscount', '2'], 'read|mission|item'),
        (['--accept-early'], 'read|mission|item'),
        (['--deaf-after-offer'], 'upload|mission|item'),
        (['--kind', '1'], 'type|kind|copter|multicopter'),
        (['--maker', '0'], 'autopilot'),
        (['--maker', '3', '--kind', '10'], 'drive_route'),
    ],
    ids=lambda habit: ' '.join(habit) if isinstance(habit, list) else '',
)
def test_nothing_unverified_and_nothing_unknown_is_flown(start, habit, words):
    """The flight ends by words, and the motors never start."""
    ground = start(*habit)
    result = ground.ended(ground.fly(), DEADLINE_S)
    assert result.outcome == FlyRoute.Result.REJECTED
    assert re.search(words, result.error_msg), result.error_msg
    assert not any(line.startswith(ARM) for line in ground.air.lines())


@pytest.mark.all
@pytest.mark.parametrize(
    ('habit', 'words'),
    [
        (['--for-ever', '400'], 'no answer to command 400'),
        (['--restart-armed'], 'started again|motors were stopped'),
        (['--swap', 'before'], 'another station has changed it|is not that of its plan'),
    ],
    ids=lambda habit: ' '.join(habit) if isinstance(habit, list) else '',
)
def test_start_that_goes_wrong_ends_on_the_ground(start, habit, words):
    """Nothing takes off after a restart, for ever in progress, or with another mission."""
    ground = start(*habit)
    result = ground.ended(ground.fly(), DEADLINE_S)
    assert result.outcome == FlyRoute.Result.REJECTED
    assert re.search(words, result.error_msg), result.error_msg
    ground.listen_for(5.0)
    lines = ground.air.lines()
    assert not any(line.startswith('CMD 300') for line in lines)
    assert 'ARMED True' not in lines or lines[-1] != 'ARMED True'


@pytest.mark.all
def test_mode_that_nobody_knows_is_the_pilots(start):
    """Another firmware has other numbers: no command follows."""
    ground = start('--odd-mode-at', '3')
    states = ground.listen(topics.STATE)
    ground.fly(route=survey(12))
    ground.until(lambda: 'MODE 77' in ground.air.lines(), DEADLINE_S)
    ground.listen_for(10.0)
    lines = ground.air.lines()
    after = lines[lines.index('MODE 77') :]
    assert [line for line in after if line.startswith('CMD')] == []
    assert '77' in states[-1].text
    assert states[-1].taken_by == 'pilot'
