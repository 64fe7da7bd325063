# SPDX-License-Identifier: Apache-2.0
"""Signals that stop a run: the first ends it in order, the second at once."""

import signal
from types import FrameType

from rocsafe_orchestrator.errors import EXIT_SIGNAL_BASE

NAMES = {signal.SIGINT: 'Ctrl-C', signal.SIGTERM: 'SIGTERM', signal.SIGHUP: 'closed terminal'}


class Interrupt:
    """Counts SIGINT, SIGTERM and SIGHUP instead of ending on them."""

    def __init__(self) -> None:
        self.count = 0
        self._first: signal.Signals | None = None
        for number in NAMES:
            signal.signal(number, self._note)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self.count += 1
        if self._first is None:
            self._first = signal.Signals(number)

    @property
    def is_urgent(self) -> bool:
        """True after the second signal."""
        return self.count > 1

    @property
    def text(self) -> str:
        """Description of the signal, empty if there was none."""
        return '' if self._first is None else f'interrupted by {NAMES[self._first]}'

    @property
    def exit_code(self) -> int | None:
        """Exit code of a command that this signal ended, None without one."""
        return None if self._first is None else EXIT_SIGNAL_BASE + self._first
