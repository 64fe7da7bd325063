# SPDX-License-Identifier: Apache-2.0
"""Make the photographs that flat ground shows: each scene from straight above, with boxes.

    python tools/ground_photographs.py [--only derailment] [--out FOLDER]

Run it after a change of a scene or of the engine. It takes about a minute a scene and needs EGL.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rocsafe_scene.flat_ground.ground_photograph import FOLDER, write_photograph
from rocsafe_scene.flat_ground.photographing import PhotographOptions, photographed
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_scene.scene.scene_file import read_scene

SCENES = Path(__file__).resolve().parents[1] / 'config' / 'scenes'
# The extent that missions over the scene need, at the resolution of their photographs: 6 cm from
# 32 m above the derailment, 14 cm from 60 m above the field.
OPTIONS = {
    'derailment': PhotographOptions(tiles=(9, 8), texel_m=0.06),
    'field': PhotographOptions(tiles=(11, 8), texel_m=0.16),
}
JPEG_QUALITY = 68


def main(argv: Sequence[str] | None = None) -> int:
    """Make them; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--only', choices=tuple(OPTIONS), action='append', help='of this scene')
    parser.add_argument('--out', type=Path, default=FOLDER, metavar='FOLDER')
    arguments = parser.parse_args(argv)
    for scene in arguments.only or tuple(OPTIONS):
        description = read_scene(SCENES / f'{scene}.yaml')
        photograph, boxes = photographed(description, OPTIONS[scene], default_folder())
        path = arguments.out / f'{scene}.jpg'
        write_photograph(path, photograph, boxes, JPEG_QUALITY)
        sys.stdout.write(f'{path}: {path.stat().st_size / 1e6:.1f} MB, {len(boxes)} boxes\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
