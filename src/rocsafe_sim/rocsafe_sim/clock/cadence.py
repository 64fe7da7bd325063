# SPDX-License-Identifier: Apache-2.0
"""When something periodic is due in simulated time."""

from rocsafe_geo.time_units import NS_PER_S


class Cadence:
    """Due at the first step at or after each multiple of a period.

    Multiples are counted from time zero, not from the start of the process: where the step
    divides the period, speed and restarts change nothing.
    """

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._last_ns: int | None = None

    def is_due(self, time_ns: int) -> bool:
        """Return whether a multiple lies after the last time asked for, `time_ns` included.

        At the first time asked for: whether that is a multiple itself.
        """
        before_ns = time_ns - 1 if self._last_ns is None else self._last_ns
        self._last_ns = time_ns
        return time_ns // self._period_ns > before_ns // self._period_ns


def period_ns(rate_hz: float) -> int:
    """Return the simulated time between two events of a rate, nanoseconds."""
    return round(NS_PER_S / rate_hz)


def floor_to(time_ns: int, period_ns: int) -> int:
    """Return the latest multiple of `period_ns` that is not after `time_ns`."""
    return time_ns - time_ns % period_ns
