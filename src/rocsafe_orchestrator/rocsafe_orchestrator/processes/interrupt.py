# SPDX-License-Identifier: Apache-2.0
"""Signals that stop a run: the first ends it in order, a second at once.

While map and products are being made it takes a third: they are worth a moment.
"""

import signal
from collections.abc import Callable
from types import FrameType

from rocsafe_orchestrator.errors import EXIT_SIGNAL_BASE

NAMES = {signal.SIGINT: 'Ctrl-C', signal.SIGTERM: 'SIGTERM', signal.SIGHUP: 'closed terminal'}


class Interrupt:
    """Counts SIGINT, SIGTERM and SIGHUP instead of ending on them.

    Attributes
    ----------
    on_hangup
        Called at once when the terminal is closed: it refuses output from then on.
    is_guarded
        Whether nothing is urgent: real vehicles are in the air.
    """

    def __init__(self) -> None:
        self.count = 0
        self.is_guarded = False
        self.is_saving = False
        self.on_hangup: Callable[[], None] = lambda: None
        self._is_urgent = False
        self._first: signal.Signals | None = None
        for number in NAMES:
            signal.signal(number, self._note)

    def withdraw(self) -> None:
        """Forget the interrupts: they were handled, and the run goes on."""
        self.count, self._first, self._is_urgent = 0, None, False

    def end(self, first: signal.Signals) -> None:
        """Take `first` for what has come: the run ends by it now."""
        self.count, self._first, self._is_urgent = 1, first, False

    @property
    def first(self) -> signal.Signals | None:
        """The signal that came first; None: none came."""
        return self._first

    def _note(self, number: int, _frame: FrameType | None) -> None:
        if number == signal.SIGHUP:
            self.on_hangup()
        self.count += 1
        self._is_urgent = self._is_urgent or self.count > (2 if self.is_saving else 1)
        if self._first is None:
            self._first = signal.Signals(number)

    @property
    def is_urgent(self) -> bool:
        """True after the second signal, while `is_saving` after the third; never while guarded."""
        return self._is_urgent and not self.is_guarded

    @property
    def text(self) -> str:
        """Description of the signal, empty if there was none."""
        return '' if self._first is None else f'interrupted by {NAMES[self._first]}'

    @property
    def exit_code(self) -> int | None:
        """Exit code of a command that this signal ended, None without one."""
        return None if self._first is None else EXIT_SIGNAL_BASE + self._first
