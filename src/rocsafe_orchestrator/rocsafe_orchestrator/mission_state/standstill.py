# SPDX-License-Identifier: Apache-2.0
"""Detection of a quantity that does not increase."""


class Standstill:
    """Time for which a number has not increased."""

    def __init__(self) -> None:
        self._value: float | None = None
        self._since_s = 0.0

    def restart(self, now_s: float) -> None:
        """Restart the count at `now_s`."""
        self._since_s = now_s

    def standing_s(self, value: float, now_s: float) -> float:
        """Note `value` at `now_s` and return the seconds since it last increased."""
        if self._value is None or value > self._value:
            self._value, self._since_s = value, now_s
        return now_s - self._since_s
