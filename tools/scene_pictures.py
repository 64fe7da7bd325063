# SPDX-License-Identifier: Apache-2.0
"""Take the pictures of docs/scenes: of each scene straight down, oblique, its truth, an overview.

    python tools/scene_pictures.py [--only derailment] [--run RUN_DIR]

With the directory of a finished run in the derailment's scene, its overview shows the planned and
flown routes. Each picture is drawn at four times its pixels; about a minute a scene.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2

from rocsafe_scene.command_line import scene_command

ROOT = Path(__file__).resolve().parents[1]
LARGEST_BYTES = 200_000
QUALITIES = (92, 88, 84, 80, 75, 70, 65, 60, 55)
OPENINGS: dict[str, dict[str, list[str]]] = {
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
# With the truth of its pixels beside it.
KNOWN = 'oblique'


@dataclass(frozen=True, slots=True)
class Take:
    """A picture to be taken: of which scene, called what, and how."""

    scene: str
    view: str
    options: list[str]


def main(argv: Sequence[str] | None = None) -> int:
    """Take them; return the first exit code that is not 0."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--only', choices=tuple(OPENINGS), action='append', help='of this scene')
    parser.add_argument('--run', type=Path, metavar='RUN_DIR', help='in the derailment')
    parser.add_argument('--out', type=Path, default=ROOT / 'docs' / 'scenes')
    arguments = parser.parse_args(argv)
    for take in takes(arguments.only or tuple(OPENINGS), arguments.run):
        code = taken(take, arguments.out, scene_command.main)
        if code:
            return code
    return 0


def takes(scenes: Sequence[str], run: Path | None) -> list[Take]:
    """Return what is to be taken of `scenes`."""
    found = []
    for scene in scenes:
        for view, options in OPENINGS[scene].items():
            chosen = list(options)
            if scene == 'derailment' and view == 'overview' and run is not None:
                chosen = ['--overview', str(run)]
            found.append(Take(scene, view, chosen + (['--truth'] if view == KNOWN else [])))
    return found


def taken(take: Take, folder: Path, render: Callable[[list[str]], int]) -> int:
    """Take a picture and make it small; return the exit code."""
    drawn = folder / f'{take.scene}_{take.view}.png'
    scene = ROOT / 'config' / 'scenes' / f'{take.scene}.yaml'
    code = render(['render', str(scene), '--out', str(drawn), '--size', '1280x720', *take.options])
    if code == 0:
        shrink(drawn, drawn.with_suffix('.jpg'))
        truth = drawn.with_name(f'{drawn.stem}-truth.png')
        if truth.exists():
            shrink(truth, folder / f'{take.scene}_truth.jpg')
    return code


def shrink(drawn: Path, kept: Path) -> None:
    """Write a picture as the best JPEG that is small enough, and remove it."""
    image = cv2.imread(str(drawn))
    for quality in QUALITIES:
        _, data = cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, quality])
        if len(data) <= LARGEST_BYTES:
            break
    kept.write_bytes(data.tobytes())
    drawn.unlink()


if __name__ == '__main__':
    sys.exit(main())
