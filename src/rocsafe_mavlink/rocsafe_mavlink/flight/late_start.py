# SPDX-License-Identifier: Apache-2.0
"""When a start that waits is due, kept over restarts of the bridge."""

import json
from contextlib import suppress
from pathlib import Path

from rocsafe_geo.storage.kept_file import KeptFile


class LateStart:
    """Gives a route that comes again after a restart the time at which it was due before.

    Without it the delay would count again, and the vehicle would not keep away from others.

    Parameters
    ----------
    path
        File for it; None: it is kept in memory.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._file = KeptFile(path)
        self._key, self._due_s = '', 0.0
        # Without a file, or with a damaged one, the delay counts anew.
        with suppress(OSError, ValueError, TypeError, KeyError):
            record = json.loads(path.read_text(encoding='utf-8')) if path else {}
            self._key, self._due_s = str(record['key']), float(record['due_s'])

    def due_s(self, key: str, now_s: float, delay_s: float) -> float:
        """Return when the route `key` is due; once this returns, it survives a kill.

        Times are of the machine's clock since its start: one beyond the delay is of an earlier
        start of the machine, and counts for nothing.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        if key != self._key or self._due_s > now_s + delay_s:
            due_s = now_s + delay_s
            self._file.require(_content(key, due_s))
            self._key, self._due_s = key, due_s
        return max(now_s, self._due_s)

    def forget(self) -> None:
        """Let the delay count anew: the start was withdrawn."""
        if self._key:
            self._key, self._due_s = '', 0.0
            self._file.keep(_content('', 0.0))


def _content(key: str, due_s: float) -> bytes:
    return json.dumps({'key': key, 'due_s': due_s}).encode()
