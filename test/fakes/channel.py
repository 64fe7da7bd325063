# SPDX-License-Identifier: Apache-2.0
"""A link between two machines that loses, repeats, delays and reorders what it is told to."""

import heapq
from dataclasses import dataclass
from enum import Enum


class Fault(Enum):
    """What may happen to one message."""

    LOST = 'lost'
    TWICE = 'twice'
    LATE = 'late'
    VERY_LATE = 'very late'


DELAY_S = 0.01
LATE_S = {Fault.LATE: 0.5, Fault.VERY_LATE: 2.3}


class Channel:
    """Carries things to their receivers in simulated time.

    Parameters
    ----------
    fault_of : called with the number of a message, from 0; returns its fault or None.
    """

    def __init__(self, fault_of):
        self._fault_of = fault_of
        self._waiting = []
        self._count = 0

    def send(self, receiver, thing, now_s):
        """Put something on its way to `receiver`."""
        fault = self._fault_of(self._count)
        self._count += 1
        if fault is Fault.LOST:
            return
        self._put(now_s + LATE_S.get(fault, DELAY_S), receiver, thing)
        if fault is Fault.TWICE:
            self._put(now_s + 3.0 * DELAY_S, receiver, thing)

    def arrived(self, now_s):
        """Return (receiver, thing) of all that has arrived until `now_s`, in order."""
        found = []
        while self._waiting and self._waiting[0].at_s <= now_s + 1e-9:
            carried = heapq.heappop(self._waiting)
            found.append((carried.receiver, carried.thing))
        return found

    def next_s(self):
        """Return when the next thing arrives, None if nothing is under way."""
        return self._waiting[0].at_s if self._waiting else None

    def _put(self, at_s, receiver, thing):
        heapq.heappush(self._waiting, Carried(at_s, self._count, receiver, thing))


@dataclass
class Carried:
    """Something under way."""

    at_s: float
    number: int
    receiver: object = None
    thing: object = None

    def __lt__(self, other):
        return (self.at_s, self.number) < (other.at_s, other.number)
