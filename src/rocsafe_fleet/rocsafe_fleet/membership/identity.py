# SPDX-License-Identifier: Apache-2.0
"""Which start of the agent of a vehicle goes on: the latest, as the others hear it.

A start that has lost its folder counts from one again, and two hosts can start an agent of one
vehicle. Who hears of a later start of itself before anybody has answered to its own, begins again
with a higher number (as in SWIM: Das, Gupta, Motivala 2002). Who was answered, or has begun again
before, rests while the later one is heard.
"""

from rocsafe_fleet.ledger.packet import Beat

START_BITS = 16
"""Drawn bits of the number of a start: two starts of one agent that lost their count differ.

They stay when it begins again: two that do so at once differ, too.
"""


class Identity:
    """The number of this start of an agent.

    Parameters
    ----------
    incarnation
        Number of the start, higher than those before as far as is known.
    longest_s
        A later start that is not heard for so long is gone.

    Attributes
    ----------
    incarnation
        The number that holds now.
    """

    def __init__(self, incarnation: int, longest_s: float) -> None:
        self.incarnation = incarnation
        self._longest_s = longest_s
        self._is_known = False
        self._later: Beat = (0, 0)
        self._later_s = 0.0

    def hear(self, told: Beat, own: Beat, now_s: float, *, is_answer: bool) -> None:
        """Take the newest heartbeat of this vehicle's agent that somebody knows of.

        Parameters
        ----------
        own
            The newest heartbeat that was sent.
        is_answer
            Whether another vehicle's agent tells it.
        """
        if is_answer and told[0] == self.incarnation:
            self._is_known = True
        if told > max(own, self._later):
            self._later, self._later_s = told, now_s

    def rests(self, now_s: float) -> bool:
        """Return whether a later start goes on; begin again if none does, or if it is unknown."""
        if self._later[0] < self.incarnation or self._later == (0, 0):
            return False
        if self._is_known and now_s - self._later_s <= self._longest_s:
            return True
        drawn = self.incarnation & (1 << START_BITS) - 1
        self.incarnation = (self._later[0] >> START_BITS) + 1 << START_BITS | drawn
        self._is_known, self._later = True, (0, 0)
        return False
