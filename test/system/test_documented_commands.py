# SPDX-License-Identifier: Apache-2.0
"""Every command that stands on a line of its own in a document works as it is written."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import textwrap
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import rasterio
from rasterio.transform import from_origin

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]
LIMIT_S = 280.0
# Time that a command which serves until it is interrupted needs to be at work.
SERVING_S = 12.0
PASSWORD = 'correct horse battery\n' * 2
_COMMAND = re.compile(r'^    ((?:rocsafe|ros2|python) .*|RUN=.*)$', re.M)
_FILE = re.compile(r'`([\w.]+)`[^`]*```\w+\n(.*?)^```', re.M | re.S)
_LISTED = re.compile(r'`([\w.]+)`, [^`]*:\n\n((?:    .*\n)+)')
# What a reader puts in the place of a capital word, in the folder `place`.
_MEANT = {
    r'(?<=rocsafe locate-release )(?:RUN\b|runs/derailment-[^/\s]+)': 'flown_gas',
    r'runs/derailment-\S+|runs/(?:RUN|NAME)\b|(?<!\$)(?<!\{)\bRUN\b(?!=)': 'flown',
    r'\bSCENARIO\b': 'my.yaml',
    r'\bPHOTOS\b|\bphotographs/': 'photographs',
    r'\bSTORE\b': 'store',
    r'\bBEFORE AFTER\b': 'flown/images flown_again/images',
    r'\bDIR\b': 'products',
}
_SERVES = re.compile(
    r'rocsafe (?:console|repository|airsim|mavlink_view|scene show)'
    r'|rocsafe run \S+ --(?:console|speed 1\b)'
    r'|ros2 run|ros2 topic (?:hz|echo (?!--once)|pub -r)'
)
# What the document says does not fit into its budget: left out, or refused.
_TOO_LITTLE = re.compile(r'--dose-budget 10\b')
# Commands that another test runs, since they need what this machine or this folder has not.
_ELSEWHERE = {
    r'sitl\.yaml': 'test/mavlink/test_any_autopilot.py, with an autopilot',
    r'rocsafe join|SCENARIO +# on base': 'test/system/test_hosts.py, on three hosts',
    r'--resume': 'test/system/test_agents_mission.py, after a kill',
    r'agents/readings\.csv': 'test/system/test_agents_mission.py, which flies agents',
    r'scenarios/evidence\.yaml': 'test/system/test_drive_mission.py',
    r'rocsafe/share/': 'test/setup/test_distribution.py, from wheels',
    r'rocsafe_example_cpp': 'test/system/test_cpp_example.py, where rclcpp is',
    r'benchmarks/mapping\.py': 'needs sets of photographs of others',
    r'train_source_search': 'test/setup/test_examples.py',
    r'rocsafe clear rav1': 'test/orchestrator, after a contaminated flight',
}
_NEEDS_MISSION = re.compile(
    r'ros2 (?:topic (?!pub(?! --once))|service call)|rocsafe (?:mavlink_view|scene show)'
)


def commands_of(document: Path) -> list[str]:
    """Return the commands of a document as they are for `place`, without remarks and synopses."""
    found = []
    for one in _COMMAND.findall(re.sub(r'\\\n *', ' ', document.read_text())):
        if ' [' in one or any(re.search(pattern, one) for pattern in _ELSEWHERE):
            continue
        text = re.split(r'\s{3,}(?!--)|\s#', one)[0]
        for pattern, meant in _MEANT.items():
            text = re.sub(pattern, meant, text)
        found.append(text)
    return found


@pytest.fixture(scope='module')
def place(tmp_path_factory) -> Path:
    """A folder with all that the commands of the documents are given."""
    folder = tmp_path_factory.mktemp('place')
    for name in ('config', 'examples'):
        (folder / name).symlink_to(ROOT / name)
    ring = [[-9.0620, 53.2797], [-9.0605, 53.2797], [-9.0605, 53.2806], [-9.0620, 53.2806]]
    ring.append(ring[0])
    (folder / 'field.geojson').write_text(
        f'{{"type": "Feature", "properties": {{}}, "geometry": '
        f'{{"type": "Polygon", "coordinates": [{ring}]}}}}'
    )
    crane = [[-9.06330, 53.28000], [-9.06325, 53.28000], [-9.06325, 53.28003], [-9.06330, 53.28]]
    for name, corners in (('farm', ring), ('site', ring), ('crane', crane)):
        text = ' '.join(f'{x},{y}' for x, y in corners)
        (folder / f'{name}.kml').write_text(
            '<kml xmlns="http://www.opengis.net/kml/2.2"><Placemark><Polygon><outerBoundaryIs>'
            f'<LinearRing><coordinates>{text}</coordinates></LinearRing></outerBoundaryIs>'
            '</Polygon></Placemark></kml>'
        )
    shutil.copy(ROOT / 'config/scenarios/derailment.yaml', folder / 'my.yaml')
    _make_heights(folder / 'dem.tif')
    subprocess.run(
        ['openssl', 'req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-subj', '/CN=hq.local',
         '-addext', 'subjectAltName=DNS:hq.local',
         '-keyout', folder / 'k.pem', '-out', folder / 'c.pem'],
        check=True, capture_output=True,
    )  # fmt: skip
    (folder / 'k.pem').chmod(0o600)
    flights = {
        'flown': 'my.yaml --seed 1',
        'flown_again': 'my.yaml --seed 2',
        'flown_gas': 'config/scenarios/derailment_chlorine.yaml',
    }
    for name, flight in flights.items():
        _run(f'rocsafe run {flight} --out {name}_runs', folder)
        (folder / name).symlink_to(next((folder / f'{name}_runs').glob('*-*')))
    shutil.copytree(folder / 'flown/images', folder / 'photographs')
    shutil.copy(folder / 'flown/readings.csv', folder)
    return folder


def _make_heights(path: Path) -> None:
    """Write level ground around the derailment, 66 m above the ellipsoid."""
    corner = from_origin(-9.070, 53.285, 1e-4, 1e-4)
    with rasterio.open(path, 'w', driver='GTiff', width=140, height=100, count=1,
                       dtype='float32', crs='EPSG:4326', transform=corner) as file:  # fmt: skip
        file.write(np.full((1, 100, 140), 66.0, 'float32'))


def _started(command: str, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        ['bash', '-c', f'exec {command}'], cwd=folder, stdin=subprocess.PIPE, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
    )  # fmt: skip


def _run(command: str, folder: Path) -> None:
    """Run a command to its end; one that serves until it is interrupted, for a while."""
    serves = bool(_SERVES.match(command))
    process = _started(command, folder)
    try:
        output, _ = process.communicate(PASSWORD, timeout=SERVING_S if serves else LIMIT_S)
    except subprocess.TimeoutExpired:
        output = _interrupted(process)
        assert serves, f'{command} has not ended:\n{output[-2000:]}'
    _judge(command, process.returncode, output)


def _interrupted(process: subprocess.Popen[str]) -> str:
    """End a command as Ctrl-C does, and return what it printed."""
    os.killpg(process.pid, signal.SIGINT)
    return process.communicate(timeout=60.0)[0]


def _judge(command: str, code: int, output: str) -> None:
    allowed = {0, 130, -signal.SIGINT} if _SERVES.match(command) else {0}
    # `ros2`, the real one, too, answers an interruption with its number.
    allowed |= {signal.SIGINT} if command.startswith('ros2 topic') else set()
    allowed |= {1} if _TOO_LITTLE.search(command) else set()
    assert code in allowed, f'{command}: {code}\n{output[-2000:]}'
    assert 'Traceback' not in output, f'{command}:\n{output[-2000:]}'


@contextmanager
def _mission(folder: Path, scenario: str) -> Iterator[None]:
    """Fly a mission in real time, as a reader has in another shell."""
    with (folder / 'mission.txt').open('w') as output:
        process = subprocess.Popen(
            ['rocsafe', 'run', scenario, '--speed', '1', '--out', 'slow_runs'],
            cwd=folder, stdout=output, stderr=output, start_new_session=True,
        )  # fmt: skip
        try:
            end = time.monotonic() + 60.0
            while 'flying' not in (folder / 'mission.txt').read_text():
                assert process.poll() is None
                assert time.monotonic() < end
                time.sleep(0.5)
            yield
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(LIMIT_S)


@pytest.mark.all
@pytest.mark.system
@pytest.mark.timeout(1500)
@pytest.mark.parametrize(
    'document', [one for one in DOCUMENTS if commands_of(one)], ids=lambda path: path.stem
)
def test_every_command_of_a_document_works(document, place, own_domain):
    """In a folder with the scenarios of the repository and the files that the document shows."""
    text = document.read_text()
    for name, body in [*_FILE.findall(text), *_LISTED.findall(text)]:
        (place / name).write_text(textwrap.dedent(body))
    commands = commands_of(document)
    in_flight = [one for one in commands if _NEEDS_MISSION.match(one)]
    variables = ''
    for command in commands:
        if command.startswith('RUN='):
            variables = f'{command}; '
        elif command not in in_flight:
            _run(f'bash -c {shlex.quote(variables + command)}' if variables else command, place)
    if in_flight:
        gas = any('/hazard/' in one for one in in_flight)
        scenario = 'derailment_chlorine' if gas else 'derailment'
        with _mission(place, f'config/scenarios/{scenario}.yaml'):
            serving = [(one, _started(one, place)) for one in in_flight if _SERVES.match(one)]
            time.sleep(SERVING_S if serving else 0.0)
            for command in in_flight:
                if not _SERVES.match(command):
                    _run(command, place)
            for command, process in serving:
                output = _interrupted(process)
                _judge(command, process.returncode, output)
