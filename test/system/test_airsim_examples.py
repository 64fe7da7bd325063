# SPDX-License-Identifier: Apache-2.0
"""AirSim's own examples, unmodified, from take-off to the pictures that they save.

They are not part of this project: ROCSAFE_AIRSIM_EXAMPLES names the folder `PythonClient` of a
clone of Cosys-AirSim (or AirSim), ROCSAFE_AIRSIM_PYTHON a Python with cosysairsim,
opencv-python-headless and numpy below 2.3 (the examples use what later ones have no more).

There are no examples named gps and set_fly in these repositories: state, which prints the fix,
and box, which flies by velocities, take their place.
"""

import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
import cv2
from test.system.airsim_server import airsim_server

PYTHON = os.environ.get('ROCSAFE_AIRSIM_PYTHON', '')
EXAMPLES = os.environ.get('ROCSAFE_AIRSIM_EXAMPLES', '')
SCENARIO = Path('config/scenarios/derailment_engine.yaml')
RUNNER = Path(__file__).with_name('airsim_example.py')
SPEED, LIMIT_S = 6.0, 300.0

pytestmark = [
    pytest.mark.system,
    pytest.mark.all,
    pytest.mark.skipif(
        not (PYTHON and EXAMPLES),
        reason='ROCSAFE_AIRSIM_PYTHON and ROCSAFE_AIRSIM_EXAMPLES name no client and no examples',
    ),
]


def shows_ground(path: Path, *, width: int = 640, height: int = 480) -> bool:
    """Return whether a file is a picture of this size that is not of one colour."""
    picture = cv2.imread(str(path))
    return picture is not None and picture.shape == (height, width, 3) and picture.std() > 2.0


def depths_of(path: Path) -> np.ndarray:
    """Return the values of a PFM file."""
    *_, data = path.read_bytes().split(b'\n', 3)
    return np.frombuffer(data, '<f4')


def hello_drone(folder: Path, text: str) -> bool:
    """Depth from 10 m above, and photographs of the ground."""
    saved = folder / 'airsim_drone'
    depths = depths_of(saved / '1.pfm')
    is_depth = len(depths) == 640 * 480 and 8.0 < np.median(depths) < 12.0
    return is_depth and all(shows_ground(saved / f'{n}.png') for n in (2, 3)) and 'imu' in text


def multi_agent_drone(folder: Path, _text: str) -> bool:
    """A photograph of each of two vehicles, which stand at different places."""
    first, second = (folder / 'airsim_drone' / f'{n}.png' for n in (1, 3))
    is_same = np.array_equal(cv2.imread(str(first)), cv2.imread(str(second)))
    return shows_ground(first) and shows_ground(second) and not is_same


def segmentation(_folder: Path, text: str) -> bool:
    """All instances have one id in the end: one colour in all pixels."""
    return 'Done: True' in text and len(re.findall(r'array\(\[307200\]\)', text)) == 3


def point_cloud(folder: Path, _text: str) -> bool:
    """A line a pixel."""
    lines = (folder / 'cloud.asc').read_text().splitlines()
    return len(lines) == 640 * 480 and all(len(line.split()) == 6 for line in lines[::10_000])


def orbit(folder: Path, text: str) -> bool:
    """A whole turn, and three photographs on it."""
    pictures = [folder / f'photo_{n}.png' for n in range(3)]
    return 'completed 1 orbits' in text or all(map(shows_ground, pictures))


def says(*words: str):
    """Return a check that these words are printed."""
    return lambda _folder, text: all(word in text for word in words)


CASES = {
    'multirotor/hello_drone': ((), hello_drone),
    'multirotor/multi_agent_drone': ((), multi_agent_drone),
    'multirotor/survey': (('--size', '20'), says('starting survey', 'disarming')),
    'multirotor/path': ((), says('flying on path', 'done.')),
    'multirotor/orbit': (('--iterations', '1', '--snapshots', '3'), orbit),
    'computer_vision/segmentation': ((), segmentation),
    'multirotor/point_cloud': ((), point_cloud),
    'multirotor/takeoff': (('20',), says('come down quickly', 'landing...', 'done.')),
    'multirotor/land': ((), says('Connected!')),
    'multirotor/state': ((), says("'latitude': 53.2", 'drone is ready!')),
    'multirotor/box': ((), says('yaw=0')),
    'multirotor/pause_continue_drone': ((), says('Finished cycle')),
}


@pytest.fixture(scope='module')
def port(tmp_path_factory, ros_domain_id) -> Iterator[int]:
    """Serve the vehicles of the derailment."""
    out = tmp_path_factory.mktemp('airsim')
    with airsim_server(SCENARIO, out, ros_domain_id, SPEED) as number:
        yield number


@pytest.mark.parametrize('name', CASES)
def test_an_example_runs_to_its_end(port, tmp_path, name):
    """With a result that makes sense."""
    arguments, is_sensible = CASES[name]
    script = Path(EXAMPLES) / f'{name}.py'
    done = subprocess.run(
        [PYTHON, str(RUNNER), str(port), str(script), *arguments],
        cwd=tmp_path, env={**os.environ, 'TMPDIR': str(tmp_path)}, input='\n' * 20,
        capture_output=True, text=True, timeout=LIMIT_S, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert is_sensible(tmp_path, done.stdout), done.stdout
