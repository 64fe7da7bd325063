# SPDX-License-Identifier: Apache-2.0
"""A person confirms the plan by which real vehicles take off, or the task by which one drives."""

from dataclasses import dataclass
from typing import Protocol

from rocsafe_orchestrator.mission_commands.progress import Display
from rocsafe_orchestrator.mission_commands.terminal import Terminal

# A plan must be confirmed within this time.
CONFIRM_S = 120.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """What is confirmed: a word for it, the file that tells it, and what happens by it."""

    what: str
    file: str
    text: str


PLAN = Subject(what='plan', file='plan.json', text='real vehicles take off')
DRIVE = Subject(what='drive', file='ground/route.json', text='a real ground vehicle drives')


class Waiting(Protocol):
    """Knows what waits: its hash, empty if nothing does."""

    unconfirmed: str

    def confirm(self) -> None:
        """Go on with it."""

    def reject(self, text: str) -> None:
        """Refuse it, with the reason."""


class Confirmation:
    """Asks at the terminal, unless it was confirmed on the command line.

    Parameters
    ----------
    waiting
        Knows what waits.
    confirmed
        Hashes of what is confirmed already.
    subject
        What it is.
    """

    def __init__(
        self,
        waiting: Waiting,
        terminal: Terminal,
        display: Display,
        confirmed: frozenset[str],
        subject: Subject = PLAN,
    ) -> None:
        self._plans = waiting
        self.subject = subject
        self._terminal, self._display = terminal, display
        self._confirmed = confirmed
        self._asked_s: float | None = None

    def watch(self, now_s: float) -> str:
        """Return the hash of what is confirmed now and is done; empty: nothing is."""
        what, file = self.subject.what, self.subject.file
        digest = self._plans.unconfirmed
        if not digest:
            return ''
        if digest in self._confirmed or (self._asked_s and self._terminal.typed() == 'y'):
            self._asked_s = None
            self._plans.confirm()
            return digest
        if not self._terminal.is_there:
            self._plans.reject(
                f'{what} {digest} of real vehicles is not confirmed: look at {file}, then run '
                f'again with --confirm {digest}, or in a terminal'
            )
        elif self._asked_s is None:
            self._asked_s = now_s
            self._display.say(
                f'{self.subject.text} by {what} {digest}, see {file}: y and Enter confirms it'
            )
        elif now_s - self._asked_s > CONFIRM_S:
            self._asked_s = None
            self._plans.reject(f'{what} {digest} was not confirmed within {CONFIRM_S:.0f} s')
        return ''
