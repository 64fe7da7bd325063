# SPDX-License-Identifier: Apache-2.0
"""When a question about all readings can be answered: while they still come in, not at once."""

# The readings of vehicles that have come to rest are all in after so many looks without a new one.
QUIET_LOOKS = 5
# Vehicles that measure on, on the ground, are never quiet: then the third asking counts.
MOST_ASKINGS = 3


class Inquiry:
    """One question at a time, asked again until it is answered."""

    def __init__(self) -> None:
        self._looks = 0
        self._askings = 0
        self._wanted: int | None = None

    def news(self) -> None:
        """Note that a reading has come."""
        self._looks = 0

    def look(self) -> None:
        """Note that some time has passed."""
        self._looks += 1

    def is_answerable(self, reading_count: int, evaluated_count: int) -> bool:
        """Return whether the question can be answered now; ask again if not.

        Parameters
        ----------
        reading_count: readings that there are.
        evaluated_count: how many of them what is known comes from.
        """
        if self._wanted is None:
            self._askings += 1
            if self._looks < QUIET_LOOKS and self._askings < MOST_ASKINGS:
                return False
            self._wanted = reading_count
        if evaluated_count < self._wanted:
            return False
        self._wanted = None
        self._askings = 0
        return True
