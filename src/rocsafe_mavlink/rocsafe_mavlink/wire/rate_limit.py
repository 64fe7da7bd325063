# SPDX-License-Identifier: Apache-2.0
"""A token bucket: permits that refill with time."""


class RateLimit:
    """Allows `per_s` things a second on average, and as many at once.

    Parameters
    ----------
    per_s
        Permits a second.
    """

    def __init__(self, per_s: float) -> None:
        self._per_s = per_s
        self._left = per_s
        self._then_s = 0.0

    def take(self, now_s: float, count: int = 1) -> bool:
        """Take `count` permits at `now_s` of a steady clock; return False if there are fewer."""
        passed_s = max(0.0, now_s - self._then_s)
        self._then_s = max(self._then_s, now_s)
        self._left = min(self._per_s, self._left + passed_s * self._per_s)
        if self._left < count:
            return False
        self._left -= count
        return True
