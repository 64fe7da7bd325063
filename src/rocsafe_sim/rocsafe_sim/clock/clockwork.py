# SPDX-License-Identifier: Apache-2.0
"""Simulated time in lock-step: when which time is to be published.

Pure: wall time comes in as an argument, seconds of any clock that only runs forward.
"""

from collections.abc import Iterable
from dataclasses import dataclass

# Without an answer the time is published again after this much wall time.
RESEND_S = 0.5
# Who has not answered for this long is named.
COMPLAIN_S = 2.0
# A world that starts listens so long for participants that are further on: they repeat
# themselves every RESEND_S.
LISTEN_S = 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Pace:
    """How time runs.

    Attributes
    ----------
    start_ns : first time.
    step_ns : between two times.
    speed : simulated seconds a wall second; 0 is as fast as possible.
    """

    start_ns: int
    step_ns: int
    speed: float


class Clockwork:
    """Decides on each time to be published.

    Parameters
    ----------
    pace : how time runs.
    participants : who must have done a step before the next.
    wall_s : wall time now.
    is_running : whether time begins by itself, else `run` lets it.
    pauses_when_idle : pause after a step that left everybody idle, once somebody was busy.
    """

    def __init__(
        self,
        pace: Pace,
        participants: Iterable[str],
        wall_s: float,
        *,
        is_running: bool = True,
        pauses_when_idle: bool = False,
    ) -> None:
        self._pace = pace
        self._names = frozenset(participants)
        self._time_ns = pace.start_ns
        self._idle: dict[str, bool] = {}
        self._begin_s = wall_s + LISTEN_S
        self._published_s: float | None = None
        self._first_published_s = wall_s
        self._next_s = wall_s
        self._was_busy = False
        self._is_adopted = False
        self._pauses_when_idle = pauses_when_idle
        self.is_running = is_running

    @property
    def time_ns(self) -> int:
        """The time being done, or done already while paused."""
        return self._time_ns

    @property
    def is_done(self) -> bool:
        """Whether everybody has done the current time."""
        return self._published_s is not None and len(self._idle) == len(self._names)

    def take(self, name: str, step_ns: int, *, is_idle: bool) -> None:
        """Take a participant's report; strangers and steps gone by do not count.

        A report from the future is one to a world that was here before: its time is adopted, and
        time runs on if somebody is busy.
        """
        if name not in self._names:
            return
        if step_ns > self._time_ns:
            self._adopt(step_ns)
        if step_ns == self._time_ns:
            self._idle[name] = is_idle
            self._was_busy = self._was_busy or not is_idle
            self.is_running = self.is_running or (self._is_adopted and not is_idle)

    def dismiss(self, name: str) -> None:
        """Wait for a participant no more: it will not come back."""
        self._names -= {name}
        self._idle.pop(name, None)

    def due(self, wall_s: float) -> int | None:
        """Return the time to be published now, None if it is not time yet."""
        if self._published_s is None:
            # Whoever is there when time begins has heard of everybody: no first reading is lost.
            is_heard = len(self._idle) > 0
            may_begin = self.is_running and wall_s >= self._begin_s
            return self._publish(wall_s) if is_heard or may_begin else None
        if self.is_done:
            return self._advance(wall_s)
        return self._publish(wall_s) if wall_s - self._published_s >= RESEND_S else None

    def missing(self, wall_s: float) -> list[str]:
        """Return who has kept everybody waiting for `COMPLAIN_S` or longer."""
        if (
            self.is_done
            or self._published_s is None
            or wall_s - self._first_published_s < COMPLAIN_S
        ):
            return []
        return sorted(self._names - self._idle.keys())

    def run(self, *, is_running: bool) -> None:
        """Let time run or pause it after the current step."""
        self.is_running = is_running
        self._was_busy = False

    def _adopt(self, step_ns: int) -> None:
        self._time_ns = step_ns
        self._idle = {}
        self._published_s = None
        self._is_adopted = True

    def _advance(self, wall_s: float) -> int | None:
        if self._pauses_when_idle and self._was_busy and all(self._idle.values()):
            self.run(is_running=False)
        if not self.is_running or wall_s < self._next_s:
            return None
        if self._pace.speed > 0.0:
            step_s = self._pace.step_ns * 1e-9 / self._pace.speed
            # A step that is late by more than a step does not make the next ones hurry.
            is_late = wall_s >= self._next_s + step_s
            self._next_s = (wall_s if is_late else self._next_s) + step_s
        self._time_ns += self._pace.step_ns
        self._idle = {}
        self._is_adopted = False
        self._first_published_s = wall_s
        return self._publish(wall_s)

    def _publish(self, wall_s: float) -> int:
        if self._published_s is None:
            self._first_published_s = wall_s
        self._published_s = wall_s
        return self._time_ns
