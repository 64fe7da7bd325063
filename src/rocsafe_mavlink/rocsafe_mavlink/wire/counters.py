# SPDX-License-Identifier: Apache-2.0
"""Counts of received, sent and dropped messages, with the reason of each drop."""

from collections import Counter
from enum import Enum


class Reason(Enum):
    """Why something was dropped."""

    UNKNOWN_PEER = 'from an address that is not allowed'
    IMPOSTOR = 'in the name of a vehicle, from another address than its own'
    OVERSIZE = 'datagram too large'
    NO_FRAME = 'no message in it'
    FALSE_START = 'damaged, or of an unknown kind'
    UNSIGNED = 'not signed'
    FORGED = 'bad signature'
    REPLAYED = 'signature with an old time stamp'
    TOO_OLD = 'signed by a clock that is behind'
    TOO_MANY_STREAMS = 'too many signed streams'
    RATE = 'more than can be read'
    UNUSED = 'of a kind that nobody reads'
    IMPLAUSIBLE = 'with a value that cannot be true'
    NOT_SENT = 'not sent: too many commands at once'


class Counters:
    """Counts of one link.

    Attributes
    ----------
    received
        Messages passed on.
    sent
        Messages handed to the transport.
    lost
        Messages missing between two sequence numbers of one sender.
    """

    def __init__(self) -> None:
        self.received = 0
        self.sent = 0
        self.lost = 0
        self._dropped: Counter[Reason] = Counter()

    def drop(self, reason: Reason, count: int = 1) -> None:
        """Count something that was dropped."""
        self._dropped[reason] += count

    def dropped(self, reason: Reason) -> int:
        """Return how many were dropped for `reason`."""
        return self._dropped[reason]

    def by_name(self) -> dict[str, int]:
        """Return all counts that are not zero, for people."""
        counts = {'received': self.received, 'sent': self.sent, 'lost': self.lost}
        counts |= {reason.value: count for reason, count in self._dropped.items()}
        return {name: count for name, count in counts.items() if count}
