# SPDX-License-Identifier: Apache-2.0
"""Values that the supervisor takes and returns: launches, restart policy, events."""

import signal
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class RestartPolicy:
    """How often and how soon a process that ended is started again.

    Attributes
    ----------
    limit
        Restarts in a run; 0: never.
    first_pause_s
        Pause before the first restart; each further pause is twice as long.
    longest_pause_s
        Longest pause.
    """

    limit: int = 5
    first_pause_s: float = 0.25
    longest_pause_s: float = 4.0

    def __post_init__(self) -> None:
        if self.limit < 0:
            raise ValueError(f'limit = {self.limit}: must be at least 0')
        if not 0.0 <= self.first_pause_s <= self.longest_pause_s:
            raise ValueError(
                f'first_pause_s = {self.first_pause_s}: must be within 0 to {self.longest_pause_s}'
            )

    def pause_s(self, restarts: int) -> float:
        """Return the pause before the next restart after `restarts` of them."""
        return float(min(self.first_pause_s * 2.0**restarts, self.longest_pause_s))


NEVER = RestartPolicy(limit=0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Launch:
    """How a process is started.

    Attributes
    ----------
    command
        Executable, as a path, and arguments.
    log
        File to which its output is appended.
    is_task
        Whether it may end with exit code 0; otherwise every end is a failure.
    """

    name: str
    command: tuple[str, ...]
    log: Path
    restart: RestartPolicy = field(default_factory=RestartPolicy)
    is_task: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Exit:
    """How a process ended: `code` is negative for a signal, as in `subprocess`.

    None: not known, the process was started by another supervisor.
    """

    code: int | None

    @property
    def text(self) -> str:
        """Description of the exit."""
        if self.code is None:
            return 'ended'
        if self.code >= 0:
            return f'ended with exit code {self.code}'
        try:
            return f'was ended by {signal.Signals(-self.code).name}'
        except ValueError:
            return f'was ended by signal {-self.code}'


class ProcessEventKind(Enum):
    """What happened to a process."""

    ENDED = 'ended, will be started again'
    RESTARTED = 'restarted'
    GAVE_UP = 'given up'
    DONE = 'done'


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessEvent:
    """An event of the process `name`; `text` describes it."""

    name: str
    kind: ProcessEventKind
    text: str
