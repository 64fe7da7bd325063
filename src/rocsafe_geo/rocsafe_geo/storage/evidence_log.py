# SPDX-License-Identifier: Apache-2.0
"""The evidence log of a run: lines that only grow, each with the hash of the line before.

A line is a JSON object with sorted keys. `hash` is the SHA-256 of the line without it. Whoever
changes, removes or inserts a line breaks the chain from there on; whoever removes the last lines
is found by the seal, which has the number of lines and the last hash.
"""

import errno
import fcntl
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_geo.storage.json_values import finite

LOG_NAME = 'evidence.jsonl'
NOTHING = '0' * 64


class EvidenceError(Exception):
    """The evidence of a run has been changed, or cannot be read."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Something that an evidence log keeps.

    Attributes
    ----------
    time_s
        By the clock on the wall, seconds since 1970.
    kind
        What it is: ``order``, ``outcome``, ``login``, ``decision``, ``alarm``, ...
    by
        User, vehicle or node.
    what
        Further keys.
    """

    time_s: float
    kind: str
    by: str
    what: Mapping[str, Any]

    def to_plain(self) -> dict[str, Any]:
        """Return it fit for JSON."""
        return {**self.what, 'time_s': self.time_s, 'kind': self.kind, 'by': self.by}


def line_of(content: Mapping[str, Any]) -> bytes:
    """Return an object as a line: sorted keys, no spaces, ASCII."""
    return json.dumps(
        finite(dict(content)), sort_keys=True, separators=(',', ':'), allow_nan=False
    ).encode()


def chained(number: int, before: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry with its number, the hash of the line before, and its own."""
    content = {**finite(dict(entry)), 'n': number, 'before': before}
    return {**content, 'hash': hashlib.sha256(line_of(content)).hexdigest()}


def checked(
    lines: Iterable[bytes], name: str = LOG_NAME, after: tuple[int, str] = (0, NOTHING)
) -> list[dict[str, Any]]:
    """Return the entries of a log.

    Parameters
    ----------
    after
        Number and hash of the line before the first one.

    Raises
    ------
    EvidenceError
        Naming the first line that is not as it was written.
    """
    entries: list[dict[str, Any]] = []
    number, before = after
    for line in lines:
        number += 1
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


def read_log(path: Path) -> list[dict[str, Any]]:
    """Return the entries of a log file, none if there is no file; raises `EvidenceError`."""
    return checked(path.read_bytes().split(b'\n')[:-1], str(path)) if path.is_file() else []


class EvidenceLog:
    """The log of one run. Lines are safely on disk when `add` returns.

    Several processes may write one log: each locks it for a line, and first reads what the others
    have added. A line that a process left torn is cut off.

    Raises
    ------
    EvidenceError
        If what is there is no whole chain.
    OSError
        If it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        self._length = 0
        self._last = (0, NOTHING)
        try:
            with self._locked():
                self._catch_up()
        except EvidenceError:
            self.close()
            raise

    def add(self, events: Sequence[Event]) -> None:
        """Add a line for each event, all of them or none.

        Raises
        ------
        EvidenceError
            If somebody has changed the log.
        OSError
            If it cannot be written; the log is then unchanged.
        """
        with self._locked():
            self._catch_up()
            number, before = self._last
            lines = b''
            for event in events:
                entry = chained(number + 1, before, event.to_plain())
                number, before = entry['n'], entry['hash']
                lines += line_of(entry) + b'\n'
            self._append(lines)
            self._last = (number, before)

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

    def _append(self, data: bytes) -> None:
        try:
            written = os.write(self._descriptor, data)
            os.fsync(self._descriptor)
        except OSError as error:
            os.ftruncate(self._descriptor, self._length)
            raise OSError(error.errno, error.strerror, str(self._path)) from error
        if written < len(data):
            os.ftruncate(self._descriptor, self._length)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._path))
        self._length += len(data)

    @contextmanager
    def _locked(self) -> Iterator[None]:
        fcntl.flock(self._descriptor, fcntl.LOCK_EX)
        try:
            yield
        finally:
            fcntl.flock(self._descriptor, fcntl.LOCK_UN)

    def _catch_up(self) -> None:
        """Read the lines of others."""
        size = os.fstat(self._descriptor).st_size
        if size < self._length:
            raise EvidenceError(f'{self._path}: lines have been removed')
        data = os.pread(self._descriptor, size - self._length, self._length)
        whole = data[: data.rfind(b'\n') + 1]
        if len(whole) < len(data):
            os.ftruncate(self._descriptor, self._length + len(whole))
        entries = checked(whole.split(b'\n')[:-1], str(self._path), self._last)
        self._length += len(whole)
        if entries:
            self._last = (entries[-1]['n'], entries[-1]['hash'])
