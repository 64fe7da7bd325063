# SPDX-License-Identifier: Apache-2.0
"""Being asked to stop: once to end in order, twice to end at once."""

import signal
from types import FrameType

from rocsafe_orchestrator.errors import EXIT_SIGNAL_BASE

NAMES = {signal.SIGINT: 'Ctrl-C', signal.SIGTERM: 'SIGTERM', signal.SIGHUP: 'closed terminal'}


class Interrupt:
    """Counts SIGINT, SIGTERM and SIGHUP from its creation on, instead of dying of them."""

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
        """True once the user has asked twice."""
        return self.count > 1

    @property
    def text(self) -> str:
        """What interrupted, for people; empty if nothing did."""
        return '' if self._first is None else f'interrupted by {NAMES[self._first]}'

    @property
    def exit_code(self) -> int | None:
        """The shell's exit code of a command that this signal ended; None without one."""
        return None if self._first is None else EXIT_SIGNAL_BASE + self._first
