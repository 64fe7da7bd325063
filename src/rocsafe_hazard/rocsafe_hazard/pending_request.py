# SPDX-License-Identifier: Apache-2.0
"""When a request for an assessment of all readings can be answered."""

# After so long without a new reading, all readings of vehicles at rest have come.
QUIET_NS = 1_000_000_000
# Vehicles may go on measuring on the ground: the third call of a request is then the last.
MOST_ASKINGS = 3


class PendingRequest:
    """One request at a time, repeated until it can be answered."""

    def __init__(self) -> None:
        self._newest_ns: int | None = None
        self._askings = 0
        self._wanted: int | None = None

    def news(self, now_ns: int) -> None:
        """Note that a reading has come, at the time `now_ns` of any steady clock."""
        self._newest_ns = now_ns

    def is_answerable(self, now_ns: int, reading_count: int, evaluated_count: int) -> bool:
        """Return whether the request can be answered now; call again if not.

        Parameters
        ----------
        now_ns
            Time of the same clock.
        reading_count
            Number of readings so far.
        evaluated_count
            Number of readings that the newest assessment is made from.
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
