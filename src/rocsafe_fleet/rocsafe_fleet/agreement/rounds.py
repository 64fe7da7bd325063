# SPDX-License-Identifier: Apache-2.0
"""Rounds of the search after the survey: which come, and when one is to be chosen."""

from rocsafe_fleet.agreement.knowledge import Knowledge


class Rounds:
    """Tells the coordinator when to choose the places of a round.

    Parameters
    ----------
    knowledge
        What is known of rounds.
    most
        Most rounds that follow the survey.
    patience_s
        Time within which the readings of the others are taken to come, seconds.

    Attributes
    ----------
    sought
        Number of the round whose places are to be chosen now; 0: none.
    """

    def __init__(self, knowledge: Knowledge, most: int, patience_s: float) -> None:
        self._knowledge = knowledge
        self._most = most
        self._patience_s = patience_s
        self.sought = 0
        self._since_s: float | None = None

    @property
    def _last(self) -> int:
        """Number of the last round; 0: none has begun."""
        return max((key[2] for key in self._knowledge.rounds), default=0)

    @property
    def are_over(self) -> bool:
        """Whether no further round follows: all were flown, or the last has no places."""
        last = self._last
        chosen = self._knowledge.rounds.items()
        return last >= self._most or any(
            not one.places for (_, _, number), one in chosen if number == last
        )

    def stop(self) -> None:
        """Seek no places."""
        self.sought, self._since_s = 0, None

    def look(self, now_s: float, *, is_time: bool) -> None:
        """Seek places of the next round once it has been time for them for long enough."""
        if not is_time:
            self.stop()
        elif self._since_s is None:
            self._since_s = now_s
        elif now_s - self._since_s >= self._patience_s:
            self.sought = self._last + 1
