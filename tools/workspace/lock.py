# SPDX-License-Identifier: Apache-2.0
"""Lock that allows one set-up at a time in a checkout."""

import fcntl
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from workspace.console import say
from workspace.errors import SetupError

WAIT_LIMIT_S = 1800.0
POLL_S = 0.2


@contextmanager
def exclusive(path: Path) -> Iterator[None]:
    """Hold the lock file `path`; the system releases it when the process ends.

    Raises
    ------
    SetupError
        If another process holds it for longer than `WAIT_LIMIT_S`.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open('a+') as file:
        _acquire(file.fileno(), path)
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield


def _acquire(descriptor: int, path: Path) -> None:
    end = time.monotonic() + WAIT_LIMIT_S
    told = False
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = path.read_text() or 'unknown'
            if time.monotonic() > end:
                raise SetupError(
                    f'process {holder} has held {path} for more than {WAIT_LIMIT_S:.0f} s'
                ) from None
            if not told:
                say(f'waiting for process {holder}, which is at work in this folder')
                told = True
            time.sleep(POLL_S)
        else:
            return
