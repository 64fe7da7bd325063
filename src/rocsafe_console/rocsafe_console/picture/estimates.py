# SPDX-License-Identifier: Apache-2.0
"""What a commander asks of a vehicle and of the dose rate, and no node tells.

All of it is estimated from what was heard, and says so.
"""

import math
from collections import deque
from dataclasses import dataclass

# A trend is told over this time, and where it exceeds this factor.
TREND_S = 30.0
TREND_FACTOR = 1.25
_LEAST_DRAIN = 0.005
_SLOWEST_MPS = 1.0


def way_home_s(distance_m: float, fastest_mps: float) -> float:
    """Return how long a vehicle flies home at the highest speed that it has shown, seconds."""
    return distance_m / max(fastest_mps, _SLOWEST_MPS) if math.isfinite(distance_m) else math.nan


@dataclass(slots=True)
class BatteryDrain:
    """How fast a battery empties, from the charges that were told in one flight."""

    first_s: float = math.nan
    first_fraction: float = math.nan
    last_s: float = math.nan
    last_fraction: float = math.nan

    def note(self, time_s: float, fraction: float) -> None:
        """Note the charge left at a time of the mission; more than before is another battery."""
        if not math.isfinite(fraction):
            return
        if not self.last_fraction >= fraction or time_s < self.last_s:
            self.first_s, self.first_fraction = time_s, fraction
        self.last_s, self.last_fraction = time_s, fraction

    @property
    def left_s(self) -> float:
        """Flight time until it is empty, seconds; NaN before it has lost half a per cent."""
        drained = self.first_fraction - self.last_fraction
        passed_s = self.last_s - self.first_s
        if not drained >= _LEAST_DRAIN or not passed_s > 0.0:
            return math.nan
        return self.last_fraction * passed_s / drained


class Trend:
    """Whether the dose rate at a vehicle rises, falls or stays, over the last half minute."""

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float]] = deque(maxlen=600)

    def note(self, time_s: float, dose_rate_usvh: float) -> None:
        """Note a reading at a time of the mission."""
        self._readings.append((time_s, dose_rate_usvh))
        while self._readings[0][0] < time_s - TREND_S:
            self._readings.popleft()

    @property
    def word(self) -> str:
        """``rising``, ``falling`` or ``steady``; empty with too few readings."""
        rates = [rate for _, rate in self._readings]
        third = len(rates) // 3
        if not third:
            return ''
        before, now = sum(rates[:third]), sum(rates[-third:])
        if now > TREND_FACTOR * before:
            return 'rising'
        return 'falling' if before > TREND_FACTOR * now else 'steady'
