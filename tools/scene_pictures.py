# SPDX-License-Identifier: Apache-2.0
"""Render the images of docs/scenes: nadir, oblique, labels and overview of each scene.

    python tools/scene_pictures.py [--only derailment] [--run RUN_DIR]
    python tools/scene_pictures.py --moving docs/scene.webp

With the directory of a finished run in the derailment, its overview shows the planned and flown
routes. Each image is drawn with four times the pixels; that takes about a minute a scene. The
moving picture of the README is what a camera sees on a flight around the derailment.
"""

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.command_line import scene_command
from rocsafe_scene.engine.oversampled_camera import OversampledCamera, open_scene
from rocsafe_scene.graphics.lens import looking
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_scene.scene.placing import to_world
from rocsafe_scene.scene.scene_file import read_scene

ROOT = Path(__file__).resolve().parents[1]
LARGEST_BYTES = 200_000
QUALITIES = (92, 88, 84, 80, 75, 70, 65, 60, 55)
VIEWS: dict[str, dict[str, list[str]]] = {
    'derailment': {
        'nadir': ['--nadir', '--eye=10,4,32'],
        'oblique': ['--eye=-28,-30,18', '--target=16,8,0'],
        'overview': ['--eye=-70,-120,75', '--target=10,0,0'],
        'farm': ['--eye=-66,4,15', '--target=-92,42,1'],
    },
    'road_tanker_crash': {
        'nadir': ['--nadir', '--eye=14,0,32'],
        'oblique': ['--eye=-14,-34,17', '--target=18,4,0'],
        'overview': ['--eye=-80,-110,70', '--target=5,5,0'],
    },
    'field': {
        'nadir': ['--nadir', '--eye=-203,14,60'],
        'oblique': ['--eye=-225,-10,14', '--target=-200,17,0'],
        'overview': ['--eye=-120,-330,190', '--target=0,-10,0'],
    },
    'empty_range': {
        'nadir': ['--nadir', '--eye=22,24,32'],
        'oblique': ['--eye=-34,-36,11', '--target=10,12,0'],
        'overview': ['--eye=-70,-120,60', '--target=0,0,0'],
    },
}
# The moving picture: places of the camera about what it looks at, metres.
MOVING_SCENE, MOVING_TARGET = 'derailment', (10.0, 4.0, 1.0)
MOVING_RADIUS_M, MOVING_HEIGHT_M = 42.0, (12.0, 26.0)
MOVING_SIZE_PX, MOVING_FRAMES, MOVING_FRAME_MS, MOVING_QUALITY = (560, 350), 48, 140, 50
# The view that also gets an image of its labels and depth.
LABELLED = 'oblique'


@dataclass(frozen=True, slots=True)
class View:
    """One image: its scene, its name and the options of the render command."""

    scene: str
    name: str
    options: list[str]


def main(argv: Sequence[str] | None = None) -> int:
    """Render the images; return the first exit code that is not 0."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--only', choices=tuple(VIEWS), action='append', help='of this scene')
    parser.add_argument('--run', type=Path, metavar='RUN_DIR', help='in the derailment')
    parser.add_argument('--out', type=Path, default=ROOT / 'docs' / 'scenes')
    parser.add_argument('--moving', type=Path, metavar='FILE', help='only the moving picture')
    arguments = parser.parse_args(argv)
    if arguments.moving:
        write_moving(arguments.moving)
        return 0
    for view in views_of(arguments.only or tuple(VIEWS), arguments.run):
        code = render_view(view, arguments.out, scene_command.main)
        if code:
            return code
    return 0


def views_of(scenes: Sequence[str], run: Path | None) -> list[View]:
    """Return the views of `scenes`."""
    found = []
    for scene in scenes:
        for name, options in VIEWS[scene].items():
            chosen = list(options)
            if scene == 'derailment' and name == 'overview' and run is not None:
                chosen = ['--overview', str(run)]
            found.append(View(scene, name, chosen + (['--truth'] if name == LABELLED else [])))
    return found


def render_view(view: View, folder: Path, run: Callable[[list[str]], int]) -> int:
    """Render a view as a small JPEG; return the exit code."""
    drawn = folder / f'{view.scene}_{view.name}.png'
    scene = ROOT / 'config' / 'scenes' / f'{view.scene}.yaml'
    code = run(['render', str(scene), '--out', str(drawn), '--size', '1280x720', *view.options])
    if code == 0:
        shrink(drawn, drawn.with_suffix('.jpg'))
        truth = drawn.with_name(f'{drawn.stem}-truth.png')
        if truth.exists():
            shrink(truth, folder / f'{view.scene}_truth.jpg')
    return code


def write_moving(path: Path) -> None:
    """Write what a camera sees that flies once around a scene, and looks at its middle."""
    description = read_scene(ROOT / f'config/scenes/{MOVING_SCENE}.yaml')
    camera = OversampledCamera(
        open_scene(description, origin=None, cache=default_folder()),
        PinholeCamera(math.radians(60.0), *MOVING_SIZE_PX),
    )
    target = np.array([*to_world(description, [MOVING_TARGET[:2]])[0], MOVING_TARGET[2]])
    low_m, high_m = MOVING_HEIGHT_M
    frames = []
    for turn in np.arange(MOVING_FRAMES) * (2.0 * math.pi / MOVING_FRAMES):
        height_m = low_m + (high_m - low_m) * 0.5 * (1.0 - math.cos(turn))
        side = MOVING_RADIUS_M * np.array([math.sin(turn), -math.cos(turn)])
        eye = np.array([*(target[:2] + side), height_m])
        image = camera.expose(eye, looking(target - eye)).image
        frames.append(Image.fromarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB)))
    frames[0].save(path, save_all=True, append_images=frames[1:], loop=0,
                   duration=MOVING_FRAME_MS, quality=MOVING_QUALITY, method=6)  # fmt: skip


def shrink(drawn: Path, kept: Path) -> None:
    """Write an image as the best JPEG that is small enough, and remove the original."""
    image = cv2.imread(str(drawn))
    for quality in QUALITIES:
        _, data = cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, quality])
        if len(data) <= LARGEST_BYTES:
            break
    kept.write_bytes(data.tobytes())
    drawn.unlink()


if __name__ == '__main__':
    sys.exit(main())
