# SPDX-License-Identifier: Apache-2.0
"""The example in JavaScript, run by Node.js against the server."""

import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from test.console.stage import TOKEN, Stage, served

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'watch_fleet.mjs'
NODE = shutil.which('node')
DEADLINE_S = 60.0

pytestmark = pytest.mark.skipif(NODE is None, reason='no Node.js here')


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the example; skip where Node.js is too old for it."""
    version = subprocess.run([NODE, '--version'], capture_output=True, text=True, check=True)
    major = int(version.stdout.lstrip('v').partition('.')[0])
    if major < 20:
        pytest.skip(f'Node.js {major} has no WebSocket: 20 or later has')
    flags = ['--experimental-websocket', '--no-warnings'] if major < 22 else []
    return subprocess.run(
        [NODE, *flags, str(EXAMPLE), *arguments],
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
    )


@pytest.fixture
def stage(tmp_path: Path) -> Stage:
    """Return a mission of three vehicles."""
    stage = Stage(tmp_path)
    stage.begin()
    return stage


@pytest.fixture
def address(stage: Stage) -> Iterator[str]:
    """Return where the stage is served."""
    with served(stage) as address:
        yield address


def test_it_sees_all_vehicles_and_holds_them(stage: Stage, address: str) -> None:
    """Places as the picture has them, and the answer of each vehicle to an order."""
    done = run(f'{address}#token={TOKEN}', '2', 'hold')
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    seen = {line['vehicle']: line for line in lines if 'latitude_deg' in line}
    assert sorted(seen) == stage.names
    for name, line in seen.items():
        vehicle = stage.context.live.picture.vehicles[name]
        assert line['latitude_deg'] == pytest.approx(vehicle.latitude_deg, abs=1e-6)
        assert line['longitude_deg'] == pytest.approx(vehicle.longitude_deg, abs=1e-6)
        assert line['state'] == 'flying'
    answers = {line['vehicle']: line['outcome'] for line in lines if 'order' in line}
    assert answers == dict.fromkeys(stage.names, 'done')
    order, names = stage.crew.sent[0]
    assert (order.verb.value, sorted(names)) == ('hold', stage.names)


@pytest.mark.parametrize(
    ('end', 'arguments', 'line'),
    [
        ('', (), 'ADDRESS: must be as the console prints it, with #token=...'),
        ('#token=wrong', (), '/api/token: the token is not right'),
        (f'#token={TOKEN}', ('1', 'dance'), '/api/orders: '),
        ('', ('soon',), 'usage: watch_fleet.mjs ADDRESS [SECONDS] [VERB]'),
    ],
)
def test_a_mistake_gives_one_line(
    stage: Stage, address: str, end: str, arguments: tuple[str, ...], line: str
) -> None:
    """And nothing is sent to a vehicle."""
    done = run(f'{address}{end}', *arguments)
    assert done.returncode == 1
    assert done.stderr.startswith(f'watch_fleet: {line}')
    assert len(done.stderr.splitlines()) == 1
    assert not stage.crew.sent
