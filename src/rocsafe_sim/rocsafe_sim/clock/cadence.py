# SPDX-License-Identifier: Apache-2.0
"""Periodic events in simulated time."""

from rocsafe_geo.time_units import NS_PER_S


class Cadence:
    """An event that is due at the first step at or after each multiple of a period.

    Multiples are counted from time zero, not from the start of the process. If the step divides
    the period, neither speed nor a restart changes the times.
    """

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._last_ns: int | None = None

    def is_due(self, time_ns: int) -> bool:
        """Return whether a multiple lies after the time of the last call, up to `time_ns`.

        In the first call: whether `time_ns` is a multiple.
        """
        before_ns = time_ns - 1 if self._last_ns is None else self._last_ns
        self._last_ns = time_ns
        return time_ns // self._period_ns > before_ns // self._period_ns


def period_ns(rate_hz: float) -> int:
    """Return the period of a rate, nanoseconds."""
    return round(NS_PER_S / rate_hz)


def floor_to(time_ns: int, period_ns: int) -> int:
    """Return the latest multiple of `period_ns` that is not after `time_ns`."""
    return time_ns - time_ns % period_ns
