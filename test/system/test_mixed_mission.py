# SPDX-License-Identifier: Apache-2.0
"""A mission that a drone with a link and a simulated one fly together."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from test.mavlink.airspace import free_port

from rocsafe_orchestrator.products.photographs import read_photographs

pytestmark = pytest.mark.system

HERE = Path(__file__).parent
DEADLINE_S = 150.0
HOME = ('47.39786', '8.54570')


class Field:
    """A fake copter in a process of its own, and a scenario with it."""

    def __init__(self, rocsafe, domain_id, folder, *, is_drone_there=True, rate=3.0):
        self._rocsafe = rocsafe
        self._environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(domain_id),
            'COLUMNS': '120',
        }
        self.folder = folder
        images = folder / 'images'
        images.mkdir()
        noise = np.random.default_rng(1).integers(0, 255, (240, 320, 3), dtype=np.uint8)
        cv2.imwrite(str(folder / 'frame.jpg'), cv2.GaussianBlur(noise, (9, 9), 0))
        port = free_port()
        text = (HERE / 'mixed.yaml').read_text(encoding='utf-8')
        text = text.replace('LINK', f'"udp://127.0.0.1:{port}"').replace('IMAGES', str(images))
        self.scenario = folder / 'mixed.yaml'
        self.scenario.write_text(text, encoding='utf-8')
        script = HERE.parent / 'fakes' / 'fake_process.py'
        paths = os.pathsep.join(path for path in sys.path if path)
        self.copter = subprocess.Popen(
            [
                *(sys.executable, script, '--to', f'127.0.0.1:{port}', '--images', images),
                *('--rate', str(rate), '--home', *HOME),
            ],
            env={**self._environment, 'PYTHONPATH': paths},
            stdout=subprocess.DEVNULL,
        )
        if not is_drone_there:
            self.close()

    def fail_after(self, time_s):
        """Let the battery of the simulated drone fail at this time."""
        text = self.scenario.read_text(encoding='utf-8')
        text = text.replace('  - name: rav2\n', f'  - name: rav2\n    fails_after_s: {time_s}\n')
        self.scenario.write_text(text, encoding='utf-8')

    def rocsafe(self, *arguments):
        """Run the command and return how it ended."""
        return subprocess.run(
            [self._rocsafe, *arguments],
            env=self._environment,
            capture_output=True,
            text=True,
            timeout=DEADLINE_S,
            check=False,
        )

    def confirmation(self):
        """Ask for the flight, and return the options that confirm its plan."""
        asked = self.rocsafe('run', self.scenario, '--out', self.folder / 'asked')
        assert asked.returncode == 1, asked.stdout + asked.stderr
        found = re.search('run again with --confirm ([0-9a-f]{8})', ' '.join(asked.stdout.split()))
        assert found, asked.stdout
        return '--confirm', found.group(1)

    def close(self):
        """End the copter."""
        self.copter.kill()
        self.copter.wait()


@pytest.fixture
def field(rocsafe, ros_domain_id, tmp_path):
    """Give a scenario with a drone that is there."""
    made = Field(rocsafe, ros_domain_id, tmp_path)
    yield made
    made.close()


@pytest.mark.all
def test_real_and_simulated_fly_one_mission(field):
    """Looked at before, flown by the clock, photographed by both, reported as one."""
    looked = field.rocsafe('preflight', field.scenario)
    assert looked.returncode == 0, looked.stdout + looked.stderr
    assert 'link-loss action' in looked.stdout
    assert 'all may fly' in looked.stdout
    runs = field.folder / 'runs'
    flown = field.rocsafe('run', field.scenario, '--out', runs, *field.confirmation())
    assert flown.returncode == 0, flown.stdout + flown.stderr
    (run,) = runs.glob('mixed-*')
    plan = json.loads((run / 'plan.json').read_text(encoding='utf-8'))
    counts = {route['vehicle']: len(route['viewpoints']) for route in plan['routes']}
    assert min(counts.values()) >= 1
    lines = (run / 'images' / 'manifest.jsonl').read_text(encoding='utf-8').splitlines()
    stored = [json.loads(line)['shot_id'] for line in lines]
    for name, count in counts.items():
        assert len([shot for shot in stored if shot.startswith(name)]) == count
    assert (run / 'report.html').is_file()
    readings = (run / 'readings.csv').read_text(encoding='utf-8')
    assert 'rav1' in readings
    assert 'rav2' in readings


@pytest.mark.all
def test_real_drone_takes_over_from_a_simulated_one(field):
    """The battery of the simulated one fails: the real one holds, then flies the rest."""
    field.fail_after(2.0)
    runs = field.folder / 'runs'
    flown = field.rocsafe('run', field.scenario, '--out', runs, *field.confirmation())
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert 'the battery failed' in flown.stdout
    (run,) = runs.glob('mixed-*')
    plan = json.loads((run / 'plan.json').read_text(encoding='utf-8'))
    count = sum(len(route['viewpoints']) for route in plan['routes'])
    assert len({shot.viewpoint_id for shot in read_photographs(run / 'images')}) == count


@pytest.mark.all
def test_real_drone_flies_on_when_a_simulated_one_leaves_it_nothing(
    rocsafe, ros_domain_id, tmp_path
):
    """All is photographed when it holds for the lost one: it is told to go on, home."""
    field = Field(rocsafe, ros_domain_id, tmp_path, rate=0.5)
    try:
        field.fail_after(28.0)
        runs = field.folder / 'runs'
        flown = field.rocsafe('run', field.scenario, '--out', runs, *field.confirmation())
        (run,) = runs.glob('mixed-*')
        told = (run / 'evidence.jsonl').read_text(encoding='utf-8')
        assert flown.returncode == 0, flown.stdout + flown.stderr
        assert 'go on after the hold' in told
    finally:
        field.close()


def test_drone_that_is_not_there_must_not_fly(rocsafe, ros_domain_id, tmp_path):
    """One line with the check that failed; nothing is started."""
    field = Field(rocsafe, ros_domain_id, tmp_path, is_drone_there=False)
    looked = field.rocsafe('preflight', field.scenario, '--wait', '1')
    assert looked.returncode == 1
    assert 'never heard' in looked.stdout
