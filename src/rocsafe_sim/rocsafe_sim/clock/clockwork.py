# SPDX-License-Identifier: Apache-2.0
"""Simulated time in lock-step: decides when to publish which time.

Wall time is an argument, seconds of any monotonic clock.
"""

from collections.abc import Iterable
from dataclasses import dataclass

# Without an answer the time is published again after this much wall time.
RESEND_S = 0.5
# A participant that has not answered for this long is reported.
COMPLAIN_S = 2.0
# After its start the world listens this long for participants at a later step, which repeat their
# reports every RESEND_S.
LISTEN_S = 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Pace:
    """Start, step and speed of time.

    Attributes
    ----------
    start_ns
        First time, nanoseconds.
    step_ns
        Step between two times, nanoseconds.
    speed
        Simulated seconds per wall second; 0: as fast as possible.
    """

    start_ns: int
    step_ns: int
    speed: float


class Clockwork:
    """Publishes the next time when all participants have done the last one.

    Parameters
    ----------
    pace
        Start, step and speed.
    participants
        Names of those who must finish a step before the next one.
    wall_s
        Wall time of the start, seconds.
    is_running
        Whether time runs from the start; otherwise `run` starts it.
    pauses_when_idle
        Whether to pause after a step in which all were idle, once one was busy.
    pauses_on_news
        Whether to pause after a step in which a participant has news, so that what answers to
        them takes effect at that time in every run.
    """

    def __init__(
        self,
        pace: Pace,
        participants: Iterable[str],
        wall_s: float,
        *,
        is_running: bool = True,
        pauses_when_idle: bool = False,
        pauses_on_news: bool = False,
    ) -> None:
        self._pace = pace
        self._names = frozenset(participants)
        self._left: frozenset[str] = frozenset()
        self._time_ns = pace.start_ns
        self._idle: dict[str, bool] = {}
        self._begin_s = wall_s + LISTEN_S
        self._published_s: float | None = None
        self._first_published_s = wall_s
        self._next_s = wall_s
        self._was_busy = False
        self._is_adopted = False
        self._pauses_when_idle = pauses_when_idle
        self._pauses_on_news = pauses_on_news
        self._had_news: set[str] = set()
        self.is_running = is_running

    @property
    def time_ns(self) -> int:
        """Current time, nanoseconds."""
        return self._time_ns

    @property
    def is_done(self) -> bool:
        """Whether all participants have finished the current time."""
        return self._published_s is not None and len(self._idle) == len(self._names)

    def take(self, name: str, step_ns: int, *, is_idle: bool, has_news: bool = False) -> None:
        """Take the report of a participant; unknown names and past steps are ignored.

        One that had left and reports the present step takes part again. A report of a later step
        was meant for a world process that has been restarted since. Its time is adopted, and time
        runs on if the participant is busy.
        """
        if name in self._left and step_ns == self._time_ns:
            self._left -= {name}
            self._names |= {name}
        if name not in self._names:
            return
        if step_ns > self._time_ns:
            self._adopt(step_ns)
        if step_ns == self._time_ns:
            self._idle[name] = is_idle
            self._was_busy = self._was_busy or not is_idle
            self.is_running = self.is_running or (self._is_adopted and not is_idle)
            if has_news and self._pauses_on_news and name not in self._had_news:
                self._had_news.add(name)
                self.is_running = False

    def dismiss(self, name: str) -> None:
        """Stop waiting for a participant that has left, until it reports the present step."""
        self._left |= self._names & {name}
        self._names -= {name}
        self._idle.pop(name, None)

    def due(self, wall_s: float) -> int | None:
        """Return the time to be published now, None if it is not time yet."""
        if self._published_s is None:
            # Time begins once participants had time to discover each other: no first reading is
            # lost.
            is_heard = len(self._idle) > 0
            may_begin = self.is_running and wall_s >= self._begin_s
            return self._publish(wall_s) if is_heard or may_begin else None
        if self.is_done:
            return self._advance(wall_s)
        return self._publish(wall_s) if wall_s - self._published_s >= RESEND_S else None

    def missing(self, wall_s: float) -> list[str]:
        """Return the participants that have not answered for `COMPLAIN_S` or longer."""
        if (
            self.is_done
            or self._published_s is None
            or wall_s - self._first_published_s < COMPLAIN_S
        ):
            return []
        return sorted(self._names - self._idle.keys())

    def run(self, *, is_running: bool) -> None:
        """Let time run, or pause it after the current step."""
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
            # After a delay of more than a step the following steps are not hurried.
            is_late = wall_s >= self._next_s + step_s
            self._next_s = (wall_s if is_late else self._next_s) + step_s
        self._time_ns += self._pace.step_ns
        self._idle = {}
        self._had_news.clear()
        self._is_adopted = False
        self._first_published_s = wall_s
        return self._publish(wall_s)

    def _publish(self, wall_s: float) -> int:
        if self._published_s is None:
            self._first_published_s = wall_s
        self._published_s = wall_s
        return self._time_ns
