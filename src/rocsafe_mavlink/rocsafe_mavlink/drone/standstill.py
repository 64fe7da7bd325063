# SPDX-License-Identifier: Apache-2.0
"""Recognition of a process that stood still: stopped, swapped out, or on a machine that slept.

Messages wait in buffers meanwhile, the oldest first, and look new when the process goes on.
"""

import math
import time
from collections.abc import Callable

from rocsafe_mavlink.knowledge.telemetry import STALE_AFTER_S

# After this time everything that was sent before the process went on has arrived, seconds.
SETTLED_S = 3.0
# It goes on while the machine sleeps; elsewhere than on Linux there is no such clock.
_CLOCK = getattr(time, 'CLOCK_BOOTTIME', time.CLOCK_MONOTONIC)


def awake_s() -> float:
    """Return the time since the start of the machine, its sleep included, seconds."""
    return time.clock_gettime(_CLOCK)


class Standstill:
    """Tells when this process stood still, and for how long after that nothing is believed.

    Parameters
    ----------
    clock
        Seconds that pass whatever the process and its machine do.
    """

    def __init__(self, clock: Callable[[], float] = awake_s) -> None:
        self._clock = clock
        # Its first look finds no gap: a start takes its time.
        self._last_s, self._deaf_until_s = math.inf, -math.inf

    def look(self) -> float:
        """Return for how long the process stood still since the last look, seconds; 0: it ran."""
        now_s = self._clock()
        gap_s, self._last_s = now_s - self._last_s, now_s
        if gap_s <= STALE_AFTER_S:
            return 0.0
        self._deaf_until_s = now_s + SETTLED_S
        return gap_s

    def doubt(self) -> str:
        """Return why an order that comes now may be an old one; empty if it cannot be."""
        now_s = self._clock()
        is_old = now_s - self._last_s > STALE_AFTER_S or now_s < self._deaf_until_s
        return 'the bridge stood still, and the order may be old: give it again' if is_old else ''

    @property
    def is_deaf(self) -> bool:
        """Whether what arrives may be from before the process went on."""
        return self._last_s < self._deaf_until_s
