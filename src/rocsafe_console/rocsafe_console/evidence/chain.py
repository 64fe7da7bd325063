# SPDX-License-Identifier: Apache-2.0
"""The evidence log of a run: lines that only grow, each with the hash of the line before.

A line is a JSON object with sorted keys. `hash` is the SHA-256 of the line without it. Whoever
changes, removes or inserts a line breaks the chain from there on; whoever removes the last lines
is found by the seal, which has the number of lines and the last hash.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rocsafe_console.errors import EvidenceError
from rocsafe_geo.storage.durable import AppendOnlyFile
from rocsafe_geo.storage.json_values import finite

LOG_NAME = 'evidence.jsonl'
NOTHING = '0' * 64


def line_of(content: Mapping[str, Any]) -> bytes:
    """Return an object as a line: sorted keys, no spaces, ASCII."""
    return json.dumps(
        finite(dict(content)), sort_keys=True, separators=(',', ':'), allow_nan=False
    ).encode()


def chained(number: int, before: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry with its number, the hash of the line before, and its own."""
    content = {**finite(dict(entry)), 'n': number, 'before': before}
    return {**content, 'hash': hashlib.sha256(line_of(content)).hexdigest()}


def checked(lines: Iterable[bytes], name: str = LOG_NAME) -> list[dict[str, Any]]:
    """Return the entries of a log.

    Raises
    ------
    EvidenceError
        Naming the first line that is not as it was written.
    """
    entries: list[dict[str, Any]] = []
    before = NOTHING
    for number, line in enumerate(lines, start=1):
        try:
            entry = json.loads(line)
            content = {key: value for key, value in entry.items() if key != 'hash'}
            right = hashlib.sha256(line_of(content)).hexdigest()
            is_right = line_of(entry) == line and entry['hash'] == right
            is_next = (entry['n'], entry['before']) == (number, before)
        except (ValueError, KeyError, AttributeError, TypeError):
            is_right = is_next = False
        if not is_right or not is_next:
            what = 'has been changed' if not is_right else 'does not follow the line before'
            raise EvidenceError(f'{name}, line {number}: {what}')
        before = entry['hash']
        entries.append(entry)
    return entries


class EvidenceLog:
    """The log of one run. A line is safely on disk when `add` returns.

    Raises
    ------
    EvidenceError
        If what is there is no whole chain.
    OSError
        If it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self._file = AppendOnlyFile(path)
        try:
            entries = checked(self._file.lines(), str(path))
        except EvidenceError:
            self._file.close()
            raise
        self._number = len(entries)
        self._last = entries[-1]['hash'] if entries else NOTHING

    @property
    def last(self) -> tuple[int, str]:
        """Number of lines, and the hash of the last one."""
        return self._number, self._last

    def add(self, time_s: float, kind: str, by: str, **what: Any) -> dict[str, Any]:
        """Add a line and return it.

        Parameters
        ----------
        time_s
            By the clock on the wall, seconds since 1970.
        kind
            What it is: ``order``, ``outcome``, ``login``, ``decision``, ``alarm``, ...
        by
            User or node.
        what
            Further keys.

        Raises
        ------
        OSError
            If it cannot be written; the log is then unchanged.
        """
        entry = chained(
            self._number + 1, self._last, {**what, 'time_s': time_s, 'kind': kind, 'by': by}
        )
        self._file.append(line_of(entry))
        self._number, self._last = entry['n'], entry['hash']
        return entry

    def close(self) -> None:
        """Close the file."""
        self._file.close()
