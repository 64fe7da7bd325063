# SPDX-License-Identifier: Apache-2.0
"""All texts that the page shows stand in its catalogue: its own, the server's, the mission's."""

import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from test.sim.flights import AIRFRAME, HOME, ROUTE, START_NS

import rocsafe_console
from rocsafe_console.runs.faults import faults_of
from rocsafe_ros.lease.control_lease import Lease, LeaseKeeper, LeaseRefusedError
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario_file import read_scenario
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle

sys.path.insert(0, str(Path(__file__).parents[2] / 'tools'))
import console_texts

PACKAGE = Path(rocsafe_console.__file__).parent
CATALOGUE = PACKAGE / 'static' / 'texts.js'
# Commands of a terminal, what they read, and the start of the server: no page shows it.
OF_TERMINALS = (
    'console_command.py', 'users_command.py', 'seal_command.py', 'verify_command.py',
    'serve_node.py', 'people/users.py', 'runs/base_map.py', 'runs/raster_map.py',
    'outward/cursor_on_target.py', 'outward/event_target.py', 'outward/features.py',
    'web/door.py', 'web/event_sender.py', 'web/server.py',
)  # fmt: skip


def refusals_in_python() -> dict[str, str]:
    """Return the texts of the server that the page shows, with a module of each."""
    found = {}
    for path in sorted(PACKAGE.rglob('*.py')):
        name = path.relative_to(PACKAGE).as_posix()
        if name not in OF_TERMINALS:
            tree = ast.parse(path.read_text(encoding='utf-8'))
            found.update(dict.fromkeys(console_texts.templates_of(tree), name))
    return found


def catalogue() -> list[str]:
    """Return the texts of the server in the catalogue of the page."""
    text = CATALOGUE.read_text(encoding='utf-8')
    (inside,) = re.findall(r'\nexport const REFUSALS = {\n(.*?)\n};', text, re.DOTALL)
    return [
        next(iter(json.loads(f'{{{line.removesuffix(",")}}}'))) for line in inside.splitlines()
    ]


def test_every_refusal_of_the_server_is_in_the_catalogue():
    """And nothing else is: who translates the catalogue has translated the page."""
    found = refusals_in_python()
    written = catalogue()
    assert len(set(written)) == len(written)
    missing = {text: name for text, name in found.items() if text not in written}
    assert not missing, '\n'.join(json.dumps(text) for text in missing)
    assert not set(written) - found.keys()


def test_what_a_mission_says_is_in_the_catalogue():
    """``python tools/console_texts.py`` would change nothing."""
    text = console_texts.CATALOGUE.read_text(encoding='utf-8')
    assert console_texts.written(console_texts.translated(text)) == text


# Each text comes in capitals if it is translated.
TRANSLATES = """
import {{ addTexts, told, REFUSALS }} from '{0}/texts.js';
import {{ MISSION_TEXTS }} from '{0}/mission_texts.js';
const entry = (key) => [key, key.toUpperCase()];
const big = (texts) => Object.fromEntries(Object.keys(texts).map(entry));
const before = JSON.parse(process.argv[1]);
const same = before.every((text) => told(text) === text);
addTexts(big(REFUSALS));
addTexts(big(MISSION_TEXTS));
console.log(JSON.stringify([same, before.map(told)]));
"""


def said(tmp_path: Path) -> list[str]:
    """Return what vehicles, leases and checks of scenarios say, as the page gets it."""
    texts = [
        'mission flies; rav1: silent, it gets no orders',
        '1 source, placed within 0.1 m (95 %)',
        'process rav1 was ended by SIGKILL',
    ]
    vehicle = SimulatedVehicle(AIRFRAME, HOME)
    vehicle.step(START_NS)
    vehicle.fly_route(ROUTE)
    vehicle.step(START_NS + 60_000_000_000)
    vehicle.land()
    keeper = LeaseKeeper('rav1', Lease(server='a'), 0.0)
    for refused in (vehicle.hold, vehicle.resume, lambda: keeper.require('7', 0.0)):
        with pytest.raises((CommandRefusedError, LeaseRefusedError)) as caught:
            refused()
        texts.append(f'rav1: {caught.value}')
    path = tmp_path / 'yard.yaml'
    path.write_text('name: yard\nregion:\n  polygon: [[0, 0]]\nvehicles: []\nspeed: 3\n')
    with pytest.raises(ScenarioError) as caught:
        read_scenario(path)
    output = '\n'.join(f'rocsafe: {line}' for line in str(caught.value).splitlines())
    texts += [fault.text for fault in faults_of(output, path.read_text())]
    return texts


@pytest.mark.skipif(shutil.which('node') is None, reason='no node on this machine')
def test_what_a_mission_says_can_be_translated(tmp_path):
    """Whole, with what others say inside of it; and without a translation nothing changes."""
    texts = said(tmp_path)
    assert len(texts) >= 8
    words = ['node', '--input-type=module', '-e', TRANSLATES.format(CATALOGUE.parent)]
    done = subprocess.run([*words, json.dumps(texts)], capture_output=True, text=True, check=True)
    is_same, told = json.loads(done.stdout)
    assert is_same
    left = [text for text in told if re.search(r'[a-z]{3,} [a-z]{2,}', text)]
    assert not left


SHOWN = re.compile(r"""(?:text|placeholder|title|alt|'aria-label'): (['`])((?:\\.|(?!\1).)*)\1""")


@pytest.mark.parametrize('path', sorted(PACKAGE.glob('static/*.js')), ids=lambda path: path.name)
def test_no_script_has_words_of_its_own(path):
    """What an element shows comes from the catalogue, but for names, numbers and signs."""
    if path == CATALOGUE:
        return
    for _, text in SHOWN.findall(path.read_text(encoding='utf-8')):
        words = re.sub(r'\$\{(?:[^{}]|\{[^{}]*\})*\}?', '', text)
        assert not re.search(r'[A-Za-z]{2,} ?[A-Za-z]', words), text
