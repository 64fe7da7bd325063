# SPDX-License-Identifier: Apache-2.0
"""The terminal of a run: its input, and its end."""

import os
import select
from pathlib import Path


class Terminal:
    """Reads lines without waiting. Once closed, output goes to `log`.

    Parameters
    ----------
    log
        File for what is printed after the terminal was closed.
    """

    def __init__(self, log: Path) -> None:
        self._log = log
        self.is_there = os.isatty(0) and os.isatty(1)

    def typed(self) -> str:
        """Return the first letter of a line that was typed; empty: none."""
        if not self.is_there or not select.select([0], [], [], 0.0)[0]:
            return ''
        try:
            line = os.read(0, 1024).decode(errors='replace')
        except OSError:
            line = ''
        if not line:
            self.is_there = False
        return line.strip()[:1].lower()

    def close(self) -> None:
        """Do without it: a closed terminal refuses output, and reads as an end of file."""
        self.is_there = False
        output = os.open(self._log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        nothing = os.open(os.devnull, os.O_RDONLY)
        for source, number in ((nothing, 0), (output, 1), (output, 2)):
            os.dup2(source, number)
        os.close(output)
        os.close(nothing)
