# SPDX-License-Identifier: Apache-2.0
"""A bucket of permits that refills with time."""


class RateLimit:
    """Allows `per_s` things a second on average, and as many at once.

    Parameters
    ----------
    per_s: permits a second.
    now_s: time at the start, seconds of any steady clock.
    """

    def __init__(self, per_s: float, now_s: float = 0.0) -> None:
        self._per_s = per_s
        self._left = per_s
        self._then_s = now_s

    def take(self, now_s: float, count: int = 1) -> bool:
        """Take `count` permits if they are there; return whether they were."""
        passed_s = max(0.0, now_s - self._then_s)
        self._then_s = max(self._then_s, now_s)
        self._left = min(self._per_s, self._left + passed_s * self._per_s)
        if self._left < count:
            return False
        self._left -= count
        return True
