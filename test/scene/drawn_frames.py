# SPDX-License-Identifier: Apache-2.0
"""A small scene drawn by whatever the environment says, in a process of its own.

What draws is chosen once a process, so a test that wants another starts one.
"""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from test.scene.scenes import THINGS, small_environment

from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical

LENS = PinholeCamera(math.radians(60.0), 240, 180)
EYE = np.array([-22.0, -26.0, 14.0])
MOVING = {
    'name': 'car', 'make': 'ambulance', 'at': (0.0, 0.0),
    'path': ({'time_s': 0.0, 'at': (-14.0, 12.0)}, {'time_s': 10.0, 'at': (14.0, 12.0)}),
}  # fmt: skip
FIELDS = ('image', 'depth_m', 'numbers', 'classes', 'normals')


def scene():
    """Return what is drawn."""
    return small_environment(*THINGS, MOVING)


def poses():
    """Return where from, by name."""
    from rocsafe_scene.graphics.lens import looking

    return {
        'nadir': (np.array([0.5, -1.0, 32.0]), rotation_enu_from_optical(0.3, 0.05, -0.03)),
        'oblique': (EYE, looking(np.array([0.0, -1.0, 1.0]) - EYE)),
        'up': (EYE, looking(np.array([1.0, 0.5, 0.4]))),
    }


def drawn(folder: Path, **environment: str) -> tuple[dict, str]:
    """Return the frames drawn by another process, by pose, field and time; and its log."""
    path = folder / 'frames.npz'
    # Python has a package `test` of its own.
    tests = str(Path(__file__).parents[1])
    words = f'import test; test.__path__.insert(0, {tests!r}); '
    words += f'from test.scene.drawn_frames import main; main({str(path)!r})'
    done = subprocess.run(
        [sys.executable, '-c', words],
        env={**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path)), **environment},
        capture_output=True, text=True, timeout=180.0, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    with np.load(path) as content:
        frames = {name: content[name] for name in content.files}
    return {**frames, **json.loads(done.stdout.splitlines()[-1])}, done.stderr


def main(path: str) -> None:
    """Draw, write, and say what drew."""
    from rocsafe_scene.engine.oversampled_camera import open_renderer

    environment = scene()
    renderer = open_renderer(environment, environment.description)
    eye = renderer.camera(LENS)
    found = {}
    for time_s in (0, 5, 0):
        renderer.set_time(float(time_s))
        for name, pose in poses().items():
            frame = eye.expose(*pose)
            again = f'{name}-{time_s}-{FIELDS[0]}' in found
            for field in FIELDS:
                key = f'{name}-{time_s}-{field}' + ('-again' if again else '')
                found[key] = getattr(frame, field)
    np.savez(path, **found)
    pipe = renderer.pipe
    sys.stdout.write(json.dumps({'renderer': pipe.renderer, 'degraded': pipe.is_degraded}))
