# SPDX-License-Identifier: Apache-2.0
"""Pairs of values with equal stamps from two streams."""

from typing import Generic, TypeVar

Left = TypeVar('Left')
Right = TypeVar('Right')
DEFAULT_CAPACITY = 1000


class StampPairing(Generic[Left, Right]):
    """Pairs values of equal stamp, in the order of their stamps, each stamp once.

    Both streams must come in the order of their stamps, with any delay between them; a stamp that
    comes again, as after a restart of its sender, gives no second pair. A value without a partner
    is dropped when a later pair is complete or more than `capacity` values wait.

    Attributes
    ----------
    lost
        Values dropped so far.
    """

    def __init__(self, capacity: int = DEFAULT_CAPACITY) -> None:
        if capacity < 1:
            raise ValueError(f'capacity = {capacity} must be at least 1')
        self.lost = 0
        self._capacity = capacity
        self._lefts: dict[int, Left] = {}
        self._rights: dict[int, Right] = {}
        self._newest_ns: int | None = None

    @property
    def waiting(self) -> int:
        """Number of values that wait for their partner."""
        return len(self._lefts) + len(self._rights)

    def add_left(self, time_ns: int, value: Left) -> tuple[Left, Right] | None:
        """Take `value` of the left stream and return the pair that it completes, if any."""
        if self._is_repeat(time_ns):
            return None
        self._lefts[time_ns] = value
        return self._completed(time_ns)

    def add_right(self, time_ns: int, value: Right) -> tuple[Left, Right] | None:
        """Take `value` of the right stream and return the pair that it completes, if any."""
        if self._is_repeat(time_ns):
            return None
        self._rights[time_ns] = value
        return self._completed(time_ns)

    def _is_repeat(self, time_ns: int) -> bool:
        return self._newest_ns is not None and time_ns <= self._newest_ns

    def _completed(self, time_ns: int) -> tuple[Left, Right] | None:
        if time_ns not in self._lefts or time_ns not in self._rights:
            self._forget_oldest()
            return None
        pair = (self._lefts.pop(time_ns), self._rights.pop(time_ns))
        self._newest_ns = time_ns
        for waiting in (self._lefts, self._rights):
            for stamp in [stamp for stamp in waiting if stamp < time_ns]:
                del waiting[stamp]
                self.lost += 1
        return pair

    def _forget_oldest(self) -> None:
        for waiting in (self._lefts, self._rights):
            while len(waiting) > self._capacity:
                del waiting[min(waiting)]
                self.lost += 1
