# SPDX-License-Identifier: Apache-2.0
"""When something was heard: what is old never looks new, also after a restart.

A message that DDS keeps for late subscribers arrives at once after a restart, however old it is.
Its stamp is a time of the mission, which may stand still or pass a hundred times as fast as that
on the wall. So the times of the wall at which the mission's clock was heard are kept, and a stamp
is as old as the newest mark of the clock that it had not passed. The marks of the first second
tell no time of the wall: they may have been kept, several of them. The clock is known to run from
the first one after that.
"""

import math
from bisect import bisect_left
from collections import deque

MARKS_KEPT = 120
# What is kept comes at once; the mission's state comes twice a second.
SETTLED_S = 0.9
STALE_S = 3.0
# A dose comes once a second of the mission: it is old after so long.
DOSE_STALE_S = 10.0


class MissionClock:
    """Tells at which time of the wall a stamp of the mission was made, or earlier."""

    def __init__(self) -> None:
        self._stamps_s: deque[float] = deque(maxlen=MARKS_KEPT)
        self._walls_s: deque[float] = deque(maxlen=MARKS_KEPT)
        self._begun_s = math.inf

    @property
    def newest_s(self) -> float:
        """Newest stamp of the clock, seconds; NaN before the first."""
        return self._stamps_s[-1] if self._stamps_s else math.nan

    def mark(self, stamp_s: float, wall_s: float) -> None:
        """Note that the mission's clock was `stamp_s` at `wall_s`, both seconds.

        A clock that goes backwards is that of another mission: earlier marks are forgotten.
        """
        if self._stamps_s and stamp_s < self._stamps_s[-1]:
            self._stamps_s.clear()
            self._walls_s.clear()
        if not self._stamps_s or stamp_s > self._stamps_s[-1]:
            if not self._stamps_s:
                self._begun_s = wall_s
            self._walls_s.append(self.heard_s(wall_s))
            self._stamps_s.append(stamp_s)

    def wall_of(self, stamp_s: float, now_s: float) -> float:
        """Return when `stamp_s` was made at the latest, seconds; -infinity: nobody knows.

        Parameters
        ----------
        stamp_s
            Time of the mission, seconds.
        now_s
            Time of the wall at which it was received, seconds.
        """
        place = bisect_left(self._stamps_s, stamp_s)
        if place == len(self._stamps_s):
            is_running = bool(self._stamps_s) and math.isfinite(self._walls_s[-1])
            return now_s if is_running else -math.inf
        return min(now_s, self._walls_s[place])

    def heard_s(self, wall_s: float) -> float:
        """Return when a word that came at `wall_s` was said at the latest, seconds.

        It is -infinity while what comes may have been kept.
        """
        return wall_s if wall_s - self._begun_s >= SETTLED_S else -math.inf
