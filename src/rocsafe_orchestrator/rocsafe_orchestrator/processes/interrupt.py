# SPDX-License-Identifier: Apache-2.0
"""Signals that stop a run: the first ends it in order, a second at once.

While map and products are being made it takes a third: they are worth a moment.
"""

import signal
from types import FrameType

from rocsafe_orchestrator.errors import EXIT_SIGNAL_BASE

NAMES = {signal.SIGINT: 'Ctrl-C', signal.SIGTERM: 'SIGTERM', signal.SIGHUP: 'closed terminal'}


class Interrupt:
    """Counts SIGINT, SIGTERM and SIGHUP instead of ending on them."""

    def __init__(self) -> None:
        self.count = 0
        self.is_saving = False
        self._is_urgent = False
        self._first: signal.Signals | None = None
        for number in NAMES:
            signal.signal(number, self._note)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self.count += 1
        self._is_urgent = self._is_urgent or self.count > (2 if self.is_saving else 1)
        if self._first is None:
            self._first = signal.Signals(number)

    @property
    def is_urgent(self) -> bool:
        """True after the second signal, while `is_saving` after the third."""
        return self._is_urgent

    @property
    def text(self) -> str:
        """Description of the signal, empty if there was none."""
        return '' if self._first is None else f'interrupted by {NAMES[self._first]}'

    @property
    def exit_code(self) -> int | None:
        """Exit code of a command that this signal ended, None without one."""
        return None if self._first is None else EXIT_SIGNAL_BASE + self._first
