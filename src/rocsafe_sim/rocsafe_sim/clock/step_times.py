# SPDX-License-Identifier: Apache-2.0
"""Time of the last step of a vehicle, in a file that outlives its process."""

import os
import struct
from pathlib import Path

# Without lock-step a vehicle may miss so much, nanoseconds.
LONGEST_GAP_NS = 5_000_000_000
_LAYOUT = struct.Struct('<qq')


class StepTimes:
    """Knows for how long a vehicle was not stepped: its process stood still or was away.

    In lock-step time waits for everybody. Who misses a single step was no longer waited for, and
    others may have taken over its work.

    Parameters
    ----------
    path
        File of the times; None: they are kept in memory. It is not flushed to the disk: it must
        outlive the process, not the machine.
    is_lockstep
        Whether time waits for the vehicle.

    Attributes
    ----------
    last_ns
        Time of the last step, nanoseconds; None before the first.
    """

    def __init__(self, path: Path | None = None, *, is_lockstep: bool = False) -> None:
        self.last_ns: int | None = None
        self._shortest_ns = 0
        self._is_lockstep = is_lockstep
        self._file = None if path is None else os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        if self._file is not None:
            kept = os.pread(self._file, _LAYOUT.size, 0)
            if len(kept) == _LAYOUT.size:
                self.last_ns, self._shortest_ns = _LAYOUT.unpack(kept)

    def missed_ns(self, time_ns: int) -> int:
        """Return for how long the vehicle was cut off before a step; 0: it was not."""
        if self.last_ns is None:
            return 0
        gap_ns = time_ns - self.last_ns
        longest_ns = self._shortest_ns or gap_ns
        return gap_ns if gap_ns > (longest_ns if self._is_lockstep else LONGEST_GAP_NS) else 0

    def note(self, time_ns: int) -> None:
        """Note a step that is done."""
        gap_ns = 0 if self.last_ns is None else time_ns - self.last_ns
        if gap_ns > 0:
            self._shortest_ns = min(self._shortest_ns or gap_ns, gap_ns)
        self.last_ns = time_ns
        if self._file is not None:
            os.pwrite(self._file, _LAYOUT.pack(time_ns, self._shortest_ns), 0)
