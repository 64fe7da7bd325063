# SPDX-License-Identifier: Apache-2.0
"""``rocsafe dataset``: labelled images of a scene for training."""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from rocsafe_dataset.errors import DatasetError
from rocsafe_dataset.folder.files import DatasetFolder
from rocsafe_dataset.folder.summary import finish
from rocsafe_dataset.options import FORMATS, DatasetOptions
from rocsafe_dataset.worker_pool import claim_folder, open_tasks, run_tasks
from rocsafe_geo.argument import image_size
from rocsafe_scene.command_line.scene_arguments import exit_code_of
from rocsafe_scene.errors import ViewError
from rocsafe_scene.scene.description import SceneDescription
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_scene.scene.scene_file import read_scene
from rocsafe_scene.scene.sunlight import WEATHERS

EXIT_INTERRUPTED = 130
MISTAKES = (ViewError, DatasetError, ValueError)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code."""
    arguments = _parser().parse_args(argv)
    try:
        return exit_code_of(lambda: _make(arguments), MISTAKES)
    except KeyboardInterrupt:
        sys.stderr.write('rocsafe: stopped; run the same command again to go on\n')
        return EXIT_INTERRUPTED


def _make(arguments: argparse.Namespace) -> None:
    description = read_scene(arguments.scene)
    folder = DatasetFolder(path=arguments.out, options=_options(arguments))
    claim_folder(folder, description)
    _photograph(folder, description, arguments.workers)
    counts = finish(folder, description.name)
    sys.stdout.write(
        f'{arguments.out}: {folder.options.count} pictures, {counts.total()} instances of '
        f'{len(counts)} classes\n'
    )


def _photograph(folder: DatasetFolder, description: SceneDescription, workers: int) -> None:
    tasks = open_tasks(folder)
    left = sum(len(numbers) for _, numbers in tasks)
    columns = (TextColumn('{task.description}'), BarColumn(), MofNCompleteColumn(),
               TimeRemainingColumn())  # fmt: skip
    with Progress(*columns, console=Console(stderr=True)) as progress:
        bar = progress.add_task(
            'pictures', total=folder.options.count, completed=folder.options.count - left
        )
        if tasks:
            for done in run_tasks(tasks, folder, description, default_folder(), workers):
                progress.advance(bar, done)


def _options(arguments: argparse.Namespace) -> DatasetOptions:
    return DatasetOptions(
        count=arguments.count,
        seed=arguments.seed,
        size_px=arguments.size,
        fov_deg=arguments.fov,
        height_m=arguments.height,
        nadir_share=arguments.nadir,
        weathers=arguments.weather,
        image_format=arguments.format,
        jpeg_quality=arguments.jpeg_quality,
        oversampling=arguments.quality,
        per_arrangement=arguments.per_arrangement,
        splits=arguments.splits,
        least_pixels=arguments.least_pixels,
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe dataset',
        description='Make labelled pictures of a scene: images, masks, depth, COCO and YOLO.',
        epilog='Stopped, it goes on where it was when the same command is run again.',
    )
    parser.add_argument('scene', type=Path, metavar='SCENE', help='scene file (YAML)')
    parser.add_argument('--count', type=int, required=True, metavar='N', help='number of pictures')
    parser.add_argument(
        '--out', type=Path, required=True, metavar='DIR', help='folder of this dataset alone'
    )
    parser.add_argument(
        '--seed', type=int, default=0, metavar='N', help='seed of the random numbers (default: 0)'
    )
    parser.add_argument(
        '--workers', type=int, default=os.cpu_count() or 1, metavar='N',
        help='processes, about 1.3 GB each (default: one a core)',
    )  # fmt: skip
    _add_camera(parser)
    parser.add_argument(
        '--weather', type=_names, default=tuple(WEATHERS), metavar='A,B',
        help=f'some of {", ".join(WEATHERS)} (default: all)',
    )  # fmt: skip
    parser.add_argument(
        '--per-arrangement', type=int, default=20, metavar='N',
        help='pictures between changes of light and placement (default: 20)',
    )  # fmt: skip
    parser.add_argument(
        '--splits', type=_numbers(3), default=(0.7, 0.15, 0.15), metavar='TRAIN,VAL,TEST',
        help='parts of training, validation and test (default: 0.7,0.15,0.15)',
    )  # fmt: skip
    parser.add_argument('--least-pixels', type=int, default=25, metavar='N',
                        help='smaller instances are not annotated (default: 25)')  # fmt: skip
    return parser


def _add_camera(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--size', type=image_size, default=(640, 480), metavar='WxH',
        help='width and height of a picture, pixels (default: 640x480)',
    )  # fmt: skip
    parser.add_argument(
        '--fov', type=float, default=60.0, metavar='DEG',
        help='field of view across the width, degrees (default: 60)',
    )  # fmt: skip
    parser.add_argument(
        '--height', type=_numbers(2), default=(14.0, 60.0), metavar='MIN,MAX',
        help='heights of the camera above the ground, metres (default: 14,60)',
    )  # fmt: skip
    parser.add_argument('--nadir', type=float, default=0.5, metavar='SHARE',
                        help='share of pictures straight down (default: 0.5)')  # fmt: skip
    parser.add_argument(
        '--format', choices=FORMATS, default='jpg', help='format of the pictures (default: jpg)'
    )
    parser.add_argument(
        '--jpeg-quality', type=int, default=92, metavar='N',
        help='quality of JPEG, 1 to 100 (default: 92)',
    )  # fmt: skip
    parser.add_argument('--quality', type=int, default=1, metavar='N',
                        help='1 to 4: draws N x N as many pixels (default: 1)')  # fmt: skip


def _names(text: str) -> tuple[str, ...]:
    return tuple(part.strip() for part in text.split(','))


def _numbers(count: int) -> Callable[[str], tuple[float, ...]]:
    def read(text: str) -> tuple[float, ...]:
        try:
            values = tuple(float(part) for part in text.split(','))
        except ValueError:
            values = ()
        if len(values) != count:
            raise argparse.ArgumentTypeError(f'{text}: must be {count} numbers with commas')
        return values

    return read


if __name__ == '__main__':
    raise SystemExit(main())
