# SPDX-License-Identifier: Apache-2.0
"""What the participants of simulated time report: who holds it up, and who is left out of it."""

import math
from collections.abc import Iterable

# A participant is late if it has not done the newest step for this time, seconds of wall time. All
# participants repeat their reports sooner.
LATE_S = 1.5


class StepReports:
    """Newest step of each participant; `now_s` is wall time, seconds of any monotonic clock."""

    def __init__(self) -> None:
        self._steps: dict[str, int] = {}
        self._newest_s = 0.0
        self._left_s: dict[str, float] = {}

    def forget(self) -> None:
        """Forget the steps: reports were not heard for a while."""
        self._steps.clear()

    def done(self, participant: str, step_ns: int, now_s: float) -> None:
        """Note that a participant has done a step."""
        if step_ns > max(self._steps.values(), default=-1):
            self._newest_s = now_s
        self._steps[participant] = step_ns

    def left_out(self, participant: str, now_s: float) -> None:
        """Note that time goes on without a participant."""
        self._left_s[participant] = now_s

    def late(self, participants: Iterable[str], now_s: float) -> tuple[str, ...]:
        """Return who has not done the newest step for too long; all have: the world."""
        if now_s - self._newest_s < LATE_S:
            return ()
        newest = max(self._steps.values(), default=0)
        behind = tuple(name for name in participants if self._steps.get(name, -1) < newest)
        return behind or ('world',)

    def is_left_out(self, participant: str, heard_s: float) -> bool:
        """Return whether time goes on without one that was last heard at `heard_s`."""
        return self._left_s.get(participant, -math.inf) >= heard_s
