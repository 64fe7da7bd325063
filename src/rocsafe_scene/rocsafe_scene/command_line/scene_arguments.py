# SPDX-License-Identifier: Apache-2.0
"""Exit codes that the commands about scenes share."""

import sys
from collections.abc import Callable

from rocsafe_scene.errors import ViewError

EXIT_MISTAKE = 2


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
