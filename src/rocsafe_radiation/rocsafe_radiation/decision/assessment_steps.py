# SPDX-License-Identifier: Apache-2.0
"""When a question about all readings can be answered: while they still come in, not at once."""

# The readings of vehicles that have come to rest are all in after so long without a new one.
QUIET_NS = 1_000_000_000
# Vehicles that measure on, on the ground, are never quiet: then the third asking counts.
MOST_ASKINGS = 3


class Inquiry:
    """One question at a time, asked again until it is answered."""

    def __init__(self) -> None:
        self._newest_ns: int | None = None
        self._askings = 0
        self._wanted: int | None = None

    def news(self, now_ns: int) -> None:
        """Note that a reading has come, at a time of any steady clock."""
        self._newest_ns = now_ns

    def is_answerable(self, now_ns: int, reading_count: int, evaluated_count: int) -> bool:
        """Return whether the question can be answered now; ask again if not.

        Parameters
        ----------
        now_ns
            Time of the same clock.
        reading_count
            Readings that there are.
        evaluated_count
            How many of them what is known comes from.
        """
        if self._wanted is None:
            self._askings += 1
            is_quiet = self._newest_ns is None or now_ns - self._newest_ns >= QUIET_NS
            if not is_quiet and self._askings < MOST_ASKINGS:
                return False
            self._wanted = reading_count
        if evaluated_count < self._wanted:
            return False
        self._wanted = None
        self._askings = 0
        return True
