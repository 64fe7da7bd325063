# SPDX-License-Identifier: Apache-2.0
"""A radio in simulated time: loss, bursts of loss, delay, duplicates, bandwidth, cuts.

Losses of each pair of stations are independent, or follow the chain of Gilbert (1960) and Elliott
(1963): a link is good or bad, and loses nothing or everything.
"""

import heapq
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.limits import require_between, require_not_negative

LONGEST_QUEUE_S = 5.0
"""A station drops what it could not send within this time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioOptions:
    """How bad a radio is.

    Attributes
    ----------
    loss
        Part of the packets that is lost, independently, 0 to 1.
    burst
        Probabilities a packet that a good link becomes bad, and a bad one good; (0, 1): never.
    delay_s, jitter_s
        Least delay, and most that is added to it, uniformly distributed.
    duplicates
        Part of the packets that arrives twice.
    bits_per_s
        That a station can send; 0: no limit.
    header_bytes
        Sent with each packet besides its content, e.g. 28 of IPv4 and UDP.
    """

    loss: float = 0.0
    burst: tuple[float, float] = (0.0, 1.0)
    delay_s: float = 0.02
    jitter_s: float = 0.03
    duplicates: float = 0.0
    bits_per_s: float = 0.0
    header_bytes: int = 28

    def __post_init__(self) -> None:
        for name, value in (
            ('loss', self.loss), ('burst', self.burst[0]), ('burst', self.burst[1]),
            ('duplicates', self.duplicates),
        ):  # fmt: skip
            require_between(name, value, 0.0, 1.0)
        for name in ('delay_s', 'jitter_s', 'bits_per_s'):
            require_not_negative(name, getattr(self, name))


class SimulatedRadio:
    """Carries packets from each station to all others that it is not cut off from.

    Parameters
    ----------
    count
        Number of stations, numbered from 0.

    Attributes
    ----------
    payload_bytes, packets
        That each station handed to the radio.
    """

    def __init__(self, count: int, options: RadioOptions, random: np.random.Generator) -> None:
        self.payload_bytes = [0] * count
        self.packets = [0] * count
        self._count = count
        self._options = options
        self._random = random
        self._flying: list[tuple[float, int, int, bytes]] = []
        self._sent = 0
        self._free_s = [0.0] * count
        self._group = [0] * count
        self._is_bad: dict[tuple[int, int], bool] = {}

    def cut(self, groups: Iterable[Iterable[int]]) -> None:
        """Let stations hear only those of their group; a station without a group hears none."""
        self._group = [-1 - station for station in range(self._count)]
        for number, group in enumerate(groups):
            for station in group:
                self._group[station] = number

    def heal(self) -> None:
        """Let all hear each other again."""
        self._group = [0] * self._count

    def send(self, sender: int, data: bytes, now_s: float) -> None:
        """Send a packet to all others."""
        options = self._options
        self.payload_bytes[sender] += len(data)
        self.packets[sender] += 1
        begin_s = max(now_s, self._free_s[sender])
        if begin_s - now_s > LONGEST_QUEUE_S:
            return
        bits = 8 * (len(data) + options.header_bytes)
        self._free_s[sender] = begin_s + (bits / options.bits_per_s if options.bits_per_s else 0.0)
        for receiver in range(self._count):
            if receiver != sender and not self._loses(sender, receiver):
                copies = 1 + (self._random.random() < options.duplicates)
                for _ in range(copies):
                    delay_s = options.delay_s + self._random.random() * options.jitter_s
                    self._sent += 1
                    flight = (self._free_s[sender] + delay_s, self._sent, receiver, data)
                    heapq.heappush(self._flying, flight)

    def due(self, now_s: float) -> list[tuple[int, bytes]]:
        """Return who receives what until now."""
        found = []
        while self._flying and self._flying[0][0] <= now_s:
            _, _, receiver, data = heapq.heappop(self._flying)
            found.append((receiver, data))
        return found

    def _loses(self, sender: int, receiver: int) -> bool:
        if self._group[sender] != self._group[receiver]:
            return True
        to_bad, to_good = self._options.burst
        is_bad = self._is_bad.get((sender, receiver), False)
        changes = self._random.random() < (to_good if is_bad else to_bad)
        is_bad = self._is_bad[sender, receiver] = is_bad != changes
        return is_bad or self._random.random() < self._options.loss
