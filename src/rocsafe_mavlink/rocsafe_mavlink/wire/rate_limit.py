# SPDX-License-Identifier: Apache-2.0
"""A token bucket: permits that refill with time."""


class RateLimit:
    """Allows `per_s` things a second on average, and as many at once.

    Parameters
    ----------
    per_s
        Permits a second.
    now_s
        Time at the start, seconds of any steady clock.
    """

    def __init__(self, per_s: float, now_s: float = 0.0) -> None:
        self._per_s = per_s
        self._left = per_s
        self._then_s = now_s

    def take(self, now_s: float, count: int = 1) -> bool:
        """Take `count` permits if there are so many; return whether there were."""
        passed_s = max(0.0, now_s - self._then_s)
        self._then_s = max(self._then_s, now_s)
        self._left = min(self._per_s, self._left + passed_s * self._per_s)
        if self._left < count:
            return False
        self._left -= count
        return True
