# SPDX-License-Identifier: Apache-2.0
"""Noticing that something does not move on."""


class Standstill:
    """For how long a number has not grown."""

    def __init__(self) -> None:
        self._value: float | None = None
        self._since_s = 0.0

    def restart(self, now_s: float) -> None:
        """Count from `now_s` again, because there is a reason for the wait."""
        self._since_s = now_s

    def standing_s(self, value: float, now_s: float) -> float:
        """Note `value` at `now_s` and return for how many seconds none was larger."""
        if self._value is None or value > self._value:
            self._value, self._since_s = value, now_s
        return now_s - self._since_s
