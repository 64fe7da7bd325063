# SPDX-License-Identifier: Apache-2.0
"""When a start that waits is due, kept over restarts of the bridge."""

import json
from contextlib import suppress
from pathlib import Path

from rocsafe_geo.storage.durable import write_whole


class LateStart:
    """Gives a route that comes again after a restart the time at which it was due before.

    Without it the delay would count again, and other vehicles are kept away from by it.

    Parameters
    ----------
    path
        File for it; None: it is kept in memory.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._key, self._due_s = '', 0.0
        # Without a file, or with a damaged one, the delay counts anew.
        with suppress(OSError, ValueError, TypeError, KeyError):
            record = json.loads(path.read_text(encoding='utf-8')) if path else {}
            self._key, self._due_s = str(record['key']), float(record['due_s'])

    def due_s(self, key: str, now_s: float, delay_s: float) -> float:
        """Return when the route `key` is due; once this returns, it survives a kill.

        Times are of the machine's clock since its start: one beyond the delay is of an earlier
        start of the machine, and counts for nothing.
        """
        if key != self._key or self._due_s > now_s + delay_s:
            self._note(key, now_s + delay_s)
        return max(now_s, self._due_s)

    def forget(self) -> None:
        """Let the delay count anew: the start was withdrawn."""
        self._note('', 0.0)

    def _note(self, key: str, due_s: float) -> None:
        if (key, due_s) == (self._key, self._due_s):
            return
        self._key, self._due_s = key, due_s
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self._path, json.dumps({'key': key, 'due_s': due_s}).encode())
