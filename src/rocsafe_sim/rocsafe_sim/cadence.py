# SPDX-License-Identifier: Apache-2.0
"""When something periodic is due in simulated time."""


def is_due(time_ns: int, period_ns: int) -> bool:
    """Return whether `time_ns` is a multiple of `period_ns`.

    Multiples are counted from time zero, not from the start of the process: speed and restarts
    change nothing.
    """
    return time_ns % period_ns == 0


def floor_to(time_ns: int, period_ns: int) -> int:
    """Return the latest multiple of `period_ns` that is not after `time_ns`."""
    return time_ns - time_ns % period_ns
