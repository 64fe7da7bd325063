# SPDX-License-Identifier: Apache-2.0
"""Readings of a vehicle's own sensors, used at times that do not depend on the machine.

A reading takes effect one period after its stamp: then it is there in every run.
"""

from rocsafe_geo.time_units import NS_PER_S


class ReadingQueue:
    """Readings that have come and are not used yet.

    Parameters
    ----------
    period_s
        Time between two readings, seconds; 0: there is no detector.
    is_awaited
        Whether the first reading is waited for: not of a sensor that must warm up.
    """

    def __init__(self, period_s: float, *, is_awaited: bool = True) -> None:
        self._is_awaited = is_awaited
        self._period_ns = round(period_s * NS_PER_S)
        self._waiting: list[tuple[int, float]] = []
        self._newest_ns = 0

    def add(self, stamp_ns: int, value: float) -> None:
        """Take a reading; one that is not newer than the last is ignored."""
        if stamp_ns > self._newest_ns:
            self._newest_ns, self._is_awaited = stamp_ns, True
            self._waiting.append((stamp_ns, value))

    def has_all(self, time_ns: int) -> bool:
        """Return whether all readings that are due at a time have come."""
        is_waiting = self._is_awaited and self._period_ns > 0
        return not is_waiting or self._newest_ns >= time_ns - self._period_ns

    def give_up(self) -> None:
        """Wait for no reading until the next one comes."""
        self._is_awaited = False

    def due(self, time_ns: int) -> list[tuple[int, float]]:
        """Return and drop the readings that are due at a time: stamp and value each."""
        limit_ns = time_ns - self._period_ns
        due = [reading for reading in self._waiting if reading[0] <= limit_ns]
        self._waiting = [reading for reading in self._waiting if reading[0] > limit_ns]
        return due
