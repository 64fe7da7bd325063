# SPDX-License-Identifier: Apache-2.0
"""Signals that stop a command, by one rule from its first moment to its last.

Before a mission has processes the first signal ends the command in order, and says so; further
ones change nothing. From then on signals are counted: the first ends the mission, with map and
report of what there is, the second changes nothing, and the third ends it at once. Whatever comes,
the run says how it ended.
"""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from rocsafe_orchestrator.errors import EXIT_SIGNAL_BASE

NAMES = {signal.SIGINT: 'Ctrl-C', signal.SIGTERM: 'SIGTERM', signal.SIGHUP: 'closed terminal'}
# So many signals end a mission at once.
AT_ONCE = 3


class Interrupted(KeyboardInterrupt):
    """A signal ended a command that flies nothing; its text is one line.

    Attributes
    ----------
    exit_code
        Exit code of the command.
    """

    def __init__(self, number: int) -> None:
        super().__init__(_text(signal.Signals(number)))
        self.exit_code = EXIT_SIGNAL_BASE + number


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Raise `Interrupted` at the first signal in the block; from then on they are ignored.

    Neither what is cleaned up nor the end of the process is cut short. Forks of the process end
    by signals as if there were no handler.
    """
    owner = os.getpid()

    def end(number: int, _frame: FrameType | None) -> None:
        if os.getpid() != owner:
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        for one in NAMES:
            signal.signal(one, signal.SIG_IGN)
        raise Interrupted(number)

    before = {number: signal.getsignal(number) for number in NAMES}
    _handle(end)
    try:
        yield
    except Interrupted:
        raise
    except BaseException:
        _restore(before)
        raise
    _restore(before)


class Interrupt:
    """Counts SIGINT, SIGTERM and SIGHUP instead of ending on them.

    A terminal that is closed counts once: it is told several times.

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
        self._has_hung_up = False
        self._first: signal.Signals | None = None
        _handle(self._note)

    def withdraw(self) -> None:
        """Forget the interrupts: they were handled, and the run goes on."""
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
            if self._has_hung_up:
                return
            self._has_hung_up = True
            self.on_hangup()
        self.count += 1
        if self._first is None:
            self._first = signal.Signals(number)

    @property
    def is_urgent(self) -> bool:
        """True after the third signal; never while guarded."""
        return self.count >= AT_ONCE and not self.is_guarded

    @property
    def text(self) -> str:
        """Description of the signal, empty if there was none."""
        return '' if self._first is None else _text(self._first)

    @property
    def exit_code(self) -> int | None:
        """Exit code of a command that this signal ended, None without one."""
        return None if self._first is None else EXIT_SIGNAL_BASE + self._first


def _restore(handlers: dict[signal.Signals, Any]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)


def _text(number: signal.Signals) -> str:
    return f'interrupted by {NAMES[number]}'


def _handle(handler: Callable[[int, FrameType | None], None]) -> None:
    """Let a handler take all signals but a hangup that is to be ignored, as by `nohup`."""
    for number in NAMES:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, handler)
