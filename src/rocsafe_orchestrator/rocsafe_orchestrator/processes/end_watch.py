# SPDX-License-Identifier: Apache-2.0
"""A deadline for the end of a process whose libraries may wait for ever when they are closed."""

import faulthandler
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TextIO

# Closing takes some hundredths of a second.
CLOSED_S = 20.0
# After this further time the process ends even if its interpreter cannot run any more.
STUCK_S = 10.0


class EndWatch:
    """Ends the process if it does not end by itself in time.

    Fast DDS was seen to wait for ever when a participant was closed, after other processes had
    been killed. What a run has to do is done by then.

    Parameters
    ----------
    finish
        Does what is left to do, and returns the exit code.
    stacks
        File that then tells where each thread waits.
    closed_s, stuck_s
        Deadlines, seconds: for `finish` to be called, and for the process to end without it.
    """

    def __init__(
        self,
        finish: Callable[[], int],
        stacks: Path,
        closed_s: float = CLOSED_S,
        stuck_s: float = STUCK_S,
    ) -> None:
        self._finish = finish
        self._file, self._path = _opened(stacks), stacks
        self._timer = threading.Timer(closed_s, self._end)
        self._timer.daemon = True
        self._timer.start()
        faulthandler.dump_traceback_later(closed_s + stuck_s, exit=True, file=self._file)

    def cancel(self) -> None:
        """Let the process end by itself: its libraries are closed."""
        self._timer.cancel()
        faulthandler.cancel_dump_traceback_later()
        self._file.close()
        self._path.unlink(missing_ok=True)

    def _end(self) -> None:
        faulthandler.dump_traceback(self._file)
        code = 1
        try:
            code = self._finish()
        finally:
            os._exit(code)


def _opened(path: Path) -> TextIO:
    """Open a file for writing; where that fails nothing is kept."""
    try:
        return path.open('w', encoding='utf-8')
    except OSError:
        return Path(os.devnull).open('w', encoding='utf-8')
