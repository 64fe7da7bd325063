# SPDX-License-Identifier: Apache-2.0
"""Arguments and exit codes that the commands about scenes share."""

import argparse
import sys
from collections.abc import Callable

from rocsafe_scene.errors import ViewError

EXIT_MISTAKE = 2
SMALLEST_SIDE_PX, LARGEST_SIDE_PX = 16, 8192


def exit_code_of(
    work: Callable[[], None], mistakes: tuple[type[Exception], ...] = (ViewError,)
) -> int:
    """Run the work of a command, print a mistake in one line, and return the exit code.

    Errors of the classes `mistakes` are mistakes of the user; others pass through.
    """
    try:
        work()
    except mistakes as error:
        for line in str(error).splitlines():
            sys.stderr.write(f'rocsafe: {line}\n')
        return EXIT_MISTAKE
    except ModuleNotFoundError as error:
        sys.stderr.write(f'rocsafe: Python module {error.name} is missing: run `make setup`\n')
        return EXIT_MISTAKE
    return 0


def image_size(text: str) -> tuple[int, int]:
    """Return width and height, pixels.

    Raises
    ------
    ArgumentTypeError
        Naming the text and what it must be.
    """
    try:
        width, height = (int(part) for part in text.lower().split('x'))
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text}: must be WxH, for instance 1280x800') from None
    if not all(SMALLEST_SIDE_PX <= side <= LARGEST_SIDE_PX for side in (width, height)):
        raise argparse.ArgumentTypeError(
            f'{text}: sides must be within {SMALLEST_SIDE_PX} to {LARGEST_SIDE_PX} px'
        )
    return width, height
