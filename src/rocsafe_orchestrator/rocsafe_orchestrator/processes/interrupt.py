# SPDX-License-Identifier: Apache-2.0
"""Signals that stop a run: the first ends it in order, the second at once."""

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
        self.on_hangup: Callable[[], None] = lambda: None
        self._first: signal.Signals | None = None
        for number in NAMES:
            signal.signal(number, self._note)

    def withdraw(self) -> None:
        """Forget what came: the operator was heard, and the run goes on."""
        self.count, self._first = 0, None

    def end(self, first: signal.Signals) -> None:
        """Take `first` for what has come: the run ends by it now."""
        self.count, self._first = 1, first

    @property
    def first(self) -> signal.Signals | None:
        """The signal that came first; None: none came."""
        return self._first

    def _note(self, number: int, _frame: FrameType | None) -> None:
        if number == signal.SIGHUP:
            self.on_hangup()
        self.count += 1
        if self._first is None:
            self._first = signal.Signals(number)

    @property
    def is_urgent(self) -> bool:
        """True after the second signal."""
        return self.count > 1 and not self.is_guarded

    @property
    def text(self) -> str:
        """Description of the signal, empty if there was none."""
        return '' if self._first is None else f'interrupted by {NAMES[self._first]}'

    @property
    def exit_code(self) -> int | None:
        """Exit code of a command that this signal ended, None without one."""
        return None if self._first is None else EXIT_SIGNAL_BASE + self._first
