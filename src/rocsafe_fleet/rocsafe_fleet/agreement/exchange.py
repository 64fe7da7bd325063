# SPDX-License-Identifier: Apache-2.0
"""Spreads the ledger of an agent: news at once, and what others lack when they show it.

Each packet has the digest of the ledger. Who sees another digest tells its version vector with
its next packet, and who has more answers after a while that grows with its rank among those who
are heard, unless somebody else has answered before.
"""

from rocsafe_fleet.ledger.ledger import Delta, Ledger, Vector, Writer
from rocsafe_fleet.ledger.packet import MOST_BYTES, Packet

HEAD_BYTES = 40
"""Most bytes of a packet besides heartbeats and deltas."""
BEAT_BYTES = 8
SLOT_S = 0.03
"""Answers of agents with neighbouring ranks are so far apart, seconds."""


class Exchange:
    """What one agent has to send of its ledger.

    Parameters
    ----------
    ledger
        Of the agent.
    count
        Number of agents.

    Attributes
    ----------
    asks
        Whether the next packet is to have the version vector.
    """

    def __init__(self, ledger: Ledger, count: int) -> None:
        self._ledger = ledger
        self._room = MOST_BYTES - HEAD_BYTES - BEAT_BYTES * count
        self.asks = False
        self._told = 0
        self._lacking: dict[Writer, int] | None = None
        self._answer_s = 0.0

    @property
    def has_news(self) -> bool:
        """Whether the agent wrote something that it did not send yet."""
        return self._ledger.vector.get(self._ledger.writer, 0) > self._told

    def repeat(self, version: int) -> None:
        """Send the own entries from this version on again."""
        self._told = min(self._told, version - 1)

    def take(self, packet: Packet, rank: int, now_s: float) -> bool:
        """Take a packet of another agent; return whether the ledger has changed."""
        has_changed = False
        for delta in packet.deltas:
            has_changed |= self._ledger.merge(delta)
            self._note(delta)
        if packet.digest == self._ledger.digest:
            return has_changed
        self.asks = True
        if packet.vector and self._has_more_than(packet.vector):
            known = self._lacking
            if known is None:
                self._lacking, self._answer_s = dict(packet.vector), now_s + SLOT_S * rank
            else:
                both = known.keys() | packet.vector.keys()
                self._lacking = {w: min(known.get(w, 0), packet.vector.get(w, 0)) for w in both}
        return has_changed

    def is_due(self, now_s: float) -> bool:
        """Return whether an answer is due."""
        return self._lacking is not None and now_s >= self._answer_s

    def deltas(self, now_s: float) -> tuple[Delta, ...]:
        """Return what to send now: own news, and answers that are due."""
        writer, ledger = self._ledger.writer, self._ledger
        if self.is_due(now_s) and self._lacking is not None:
            lacking, self._lacking = self._lacking, None
        else:
            lacking = dict(ledger.latest)
        if self.has_news:
            lacking[writer] = min(self._told, lacking.get(writer, 0))
            self._told = ledger.vector[writer]
        return tuple(ledger.deltas(lacking, self._room))

    def vector(self) -> Vector:
        """Return the version vector if it is wanted, else nothing."""
        wanted, self.asks = self.asks, False
        return dict(self._ledger.vector) if wanted else {}

    def _note(self, delta: Delta) -> None:
        """Note that somebody has sent what others lack."""
        if self._lacking is None:
            return
        upto = max([delta.upto, *(entry.version for entry in delta.entries)])
        if delta.base <= self._lacking.get(delta.writer, 0) < upto:
            self._lacking[delta.writer] = upto
        if not self._has_more_than(self._lacking):
            self._lacking = None

    def _has_more_than(self, vector: Vector) -> bool:
        return any(version > vector.get(w, 0) for w, version in self._ledger.latest.items())
