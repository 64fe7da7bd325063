# SPDX-License-Identifier: Apache-2.0
"""The end of the flights of a mission: all have landed, or the agents have nothing left."""

from rocsafe_orchestrator.mission_state.phase_record import PhaseRecord
from rocsafe_orchestrator.mission_state.situation import Situation

# Agents must have nothing left for so long: a loss may give them more.
AGENTS_DONE_S = 3.0
# All vehicles may stand for so long although agents have something left: wall time, as for the
# agents themselves.
AGENTS_IDLE_S = 300.0


class Landing:
    """Tells when no flight is left.

    Parameters
    ----------
    record
        Faults of the mission.
    homecoming_s
        Time within which vehicles in the air must land, seconds of wall time.
    """

    def __init__(self, record: PhaseRecord, homecoming_s: float) -> None:
        self._record = record
        self._homecoming_s = homecoming_s
        self._agents_done_s: float | None = None
        self._idle_s: float | None = None
        self._down_by_s: float | None = None

    def is_agreed(self, now_s: float, situation: Situation) -> bool:
        """Return whether the agents have had nothing left for long enough, or nobody flies it."""
        if situation.aloft or situation.agents_plan or self._idle_s is None:
            self._idle_s = now_s
        if not situation.agents_are_done:
            self._agents_done_s = None
            return self._is_idle(now_s)
        if self._agents_done_s is None:
            self._agents_done_s = now_s
        return now_s - self._agents_done_s >= AGENTS_DONE_S

    def _is_idle(self, now_s: float) -> bool:
        if self._idle_s is None or now_s - self._idle_s < AGENTS_IDLE_S:
            return False
        self._record.fault(
            f'all vehicles stand for {AGENTS_IDLE_S:.0f} s although agents have something to fly'
        )
        return True

    def are_down(self, now_s: float, situation: Situation) -> bool:
        """Return whether every vehicle that reports has landed, or had time enough for it."""
        if self._down_by_s is None:
            self._down_by_s = now_s + self._homecoming_s
        if situation.aloft and now_s < self._down_by_s:
            return False
        if situation.aloft:
            self._record.fault(f'{", ".join(sorted(situation.aloft))}: still in the air')
        self._down_by_s = None
        return True
