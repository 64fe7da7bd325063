# SPDX-License-Identifier: Apache-2.0
"""A mission of simulated drones and a real ground vehicle: it drives by what they have found."""

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

# A mission with a real vehicle runs as on the wall: 160 s without its drive, 250 s with it.
DEADLINE_S = 400.0
pytestmark = [pytest.mark.system, pytest.mark.all, pytest.mark.timeout(2.0 * DEADLINE_S)]

HERE = Path(__file__).parent
HOME = ('53.27985', '-9.06385')
LINK = """  link: "udp://127.0.0.1:{port}"
  drone: {{geoid_separation_m: 57.0, image_folder: {images}}}
"""


class Rovers:
    """A fake rover in a process of its own, and a scenario with it."""

    def __init__(self, rocsafe, domain_id, folder):
        self._rocsafe = rocsafe
        self._environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain_id), 'COLUMNS': '120'}
        self.folder = folder
        images = folder / 'images'
        images.mkdir()
        noise = np.random.default_rng(1).integers(0, 255, (240, 320, 3), dtype=np.uint8)
        cv2.imwrite(str(folder / 'frame.jpg'), cv2.GaussianBlur(noise, (9, 9), 0))
        port = free_port()
        text = (HERE / 'drive.yaml').read_text(encoding='utf-8')
        self.scenario = folder / 'rover.yaml'
        self.scenario.write_text(text + LINK.format(port=port, images=images), encoding='utf-8')
        paths = os.pathsep.join(path for path in sys.path if path)
        self.rover = subprocess.Popen(
            [
                *(sys.executable, HERE.parent / 'fakes' / 'fake_process.py', '--rover'),
                *('--to', f'127.0.0.1:{port}', '--images', images, '--home', *HOME),
            ],
            env={**self._environment, 'PYTHONPATH': paths},
            stdout=subprocess.DEVNULL,
        )

    def run(self, *arguments):
        """Run the mission and return how it ended."""
        return subprocess.run(
            [self._rocsafe, 'run', self.scenario, '--out', self.folder / 'runs', *arguments],
            env=self._environment, capture_output=True, text=True, timeout=DEADLINE_S, check=False,
        )  # fmt: skip

    def close(self):
        """End the rover."""
        self.rover.kill()
        self.rover.wait()


@pytest.fixture
def rovers(rocsafe, ros_domain_id, tmp_path):
    """Give a scenario with a rover that is there."""
    made = Rovers(rocsafe, ros_domain_id, tmp_path)
    yield made
    made.close()


def test_rover_drives_to_what_the_drones_found(rovers):
    """Not before a person has confirmed its task; then to the evidence, and home."""
    asked = rovers.run()
    assert asked.returncode == 1, asked.stdout + asked.stderr
    found = re.search('run again with --confirm ([0-9a-f]{8})', ' '.join(asked.stdout.split()))
    assert found, asked.stdout
    driven = rovers.run('--confirm', found.group(1))
    assert driven.returncode == 0, driven.stdout + driven.stderr
    (_, run) = sorted(rovers.folder.glob('runs/drive-*'))
    summary = json.loads((run / 'summary.json').read_text())
    assert summary['outcome'] == 'complete'
    lines = (run / 'images' / 'manifest.jsonl').read_text(encoding='utf-8').splitlines()
    shots = [json.loads(line)['shot_id'] for line in lines]
    assert sum(shot.startswith('rgv1-') for shot in shots) == 2
    assert 'rgv1' in (run / 'readings.csv').read_text(encoding='utf-8')
    assert 'Real drive: rgv1.' in (run / 'report.html').read_text(encoding='utf-8')
