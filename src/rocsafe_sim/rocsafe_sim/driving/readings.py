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
    """

    def __init__(self, period_s: float) -> None:
        self._period_ns = round(period_s * NS_PER_S)
        self._waiting: list[tuple[int, float]] = []
        self._newest_ns = 0

    def add(self, stamp_ns: int, value: float) -> None:
        """Take a reading; one that is not newer than the last is ignored."""
        if stamp_ns > self._newest_ns:
            self._newest_ns = stamp_ns
            self._waiting.append((stamp_ns, value))

    def has_all(self, time_ns: int) -> bool:
        """Return whether all readings that are due at a time have come."""
        return not self._period_ns or self._newest_ns >= time_ns - self._period_ns

    def due(self, time_ns: int) -> list[tuple[int, float]]:
        """Return and drop the readings that are due at a time: stamp and value each."""
        limit_ns = time_ns - self._period_ns
        due = [reading for reading in self._waiting if reading[0] <= limit_ns]
        self._waiting = [reading for reading in self._waiting if reading[0] > limit_ns]
        return due
