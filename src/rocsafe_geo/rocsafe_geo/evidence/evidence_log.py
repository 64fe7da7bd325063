# SPDX-License-Identifier: Apache-2.0
"""The evidence log of a run: lines that only grow, each with the hash of the line before.

A line is a JSON object with sorted keys. `hash` is the SHA-256 of the line without it, `code` the
version of the code that wrote it. Whoever changes, removes or inserts a line breaks the chain from
there on; whoever removes the last lines is found by the seal, which has the number of lines and
the last hash.

A log that somebody has damaged is left as it is, and goes on in a segment beside it
(``evidence-0002.jsonl``), whose first line says so, with the hash of what it follows.
"""

import errno
import fcntl
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_geo.evidence.code_version import version_text
from rocsafe_geo.storage.durable import write_whole
from rocsafe_geo.storage.json_values import finite

LOG_NAME = 'evidence.jsonl'
NOTHING = '0' * 64
# Kind of the first line of a segment that follows a damaged one.
DAMAGED = 'damaged'


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
        told = {'time_s': self.time_s, 'kind': self.kind, 'by': self.by, 'code': version_text()}
        return {**self.what, **told}


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


def segments_of(path: Path) -> list[Path]:
    """Return the files of a log in their order: `path`, and those that follow damaged ones."""
    found = sorted(path.parent.glob(f'{path.stem}-[0-9][0-9][0-9][0-9]{path.suffix}'))
    return [path, *found] if path.is_file() else found


def segment(path: Path, number: int) -> Path:
    """Return the file of a segment, from 1 on, of the log whose first is `path`."""
    return path if number == 1 else path.with_name(f'{path.stem}-{number:04d}{path.suffix}')


def number_of(path: Path, one: Path) -> int:
    """Return the number of a segment of the log whose first is `path`."""
    return 1 if one == path else int(one.stem.rsplit('-', 1)[1])


def whole_lines(path: Path) -> tuple[list[dict[str, Any]], str]:
    """Return the entries of a segment until its damage, and what that is, empty if none.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    data = path.read_bytes()
    entries: list[dict[str, Any]] = []
    after = (0, NOTHING)
    for line in data.split(b'\n')[:-1]:
        try:
            entries += checked([line], path.name, after)
        except EvidenceError as error:
            return entries, str(error)
        after = (entries[-1]['n'], entries[-1]['hash'])
    return entries, '' if data[-1:] in (b'', b'\n') else f'{path.name}: its end is no line'


def faults_of(path: Path) -> list[str]:
    """Return what is wrong with a log and its segments, one line each; none: all are whole."""
    faults, segments = [], segments_of(path)
    for number, one in enumerate(segments, 1):
        entries, fault = whole_lines(one)
        goes_on = f'; the log goes on in {segments[number].name}' if segments[number:] else ''
        faults += [fault + goes_on] if fault else []
        if one != path:
            before = segment(path, number_of(path, one) - 1)
            faults += _join_faults(before, one, entries)
    return faults


def _join_faults(before: Path, one: Path, entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what is wrong between a segment and the damaged one before it."""
    first = entries[0] if entries else {}
    if first.get('kind') != DAMAGED or first.get('follows') != before.name:
        return [f'{one.name}: does not say what it follows']
    told = f'{before.name}: was damaged when {one.name} began: {first.get("why")}'
    data = before.read_bytes() if before.is_file() else None
    if data is None or hashlib.sha256(data).hexdigest() != first.get('sha256'):
        return [told, f'{before.name}: has been changed since']
    return [told]


def read_log(path: Path) -> list[dict[str, Any]]:
    """Return the entries of a log, none if there is no file.

    Raises
    ------
    EvidenceError
        If one of its segments is damaged.
    """
    entries: list[dict[str, Any]] = []
    for one in segments_of(path):
        entries += checked(one.read_bytes().split(b'\n')[:-1], str(one))
    return entries


class EvidenceLog:
    """The log of one run. Lines are safely on disk when `add` returns.

    Several processes may write one log: each locks it for a line, and first reads what the others
    have added. A line that a process left torn is cut off. A log that is no whole chain any more,
    or is gone, is left as it is: the log goes on in a new segment.

    Raises
    ------
    OSError
        If it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self._first = path
        self._number = 0
        self._descriptor = -1
        self._open_newest()

    @property
    def damage(self) -> str:
        """Why the log has gone on in a new segment, empty if it has not."""
        return self._damage

    def add(self, events: Sequence[Event]) -> None:
        """Add a line for each event, all of them or none.

        Raises
        ------
        OSError
            If it cannot be written; the log is then unchanged.
        """
        while not self._is_added(events):
            self._open_newest()

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

    def _open_newest(self) -> None:
        """Open the newest segment; what is wrong with it is told when a line is added."""
        if self._descriptor >= 0:
            self.close()
        there = [number_of(self._first, one) for one in segments_of(self._first)]
        self._number = max([1, *there])
        self._path = segment(self._first, self._number)
        self._descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        self._length, self._last, self._damage = 0, (0, NOTHING), ''
        with self._locked(), suppress(EvidenceError):
            entries = self._catch_up()
            if self._number > 1 and entries:
                self._damage = f'{entries[0].get("why")}; it goes on in {self._path.name}'

    def _is_added(self, events: Sequence[Event]) -> bool:
        """Add lines; if False there is a next segment, and nothing was added."""
        following = segment(self._first, self._number + 1)
        with self._locked():
            if following.exists():
                return False
            if fault := self._fault():
                self._begin(following, fault, events[0].time_s)
                return False
            number, before = self._last
            lines = b''
            for event in events:
                entry = chained(number + 1, before, event.to_plain())
                number, before = entry['n'], entry['hash']
                lines += line_of(entry) + b'\n'
            self._append(lines)
            self._last = (number, before)
            return True

    def _fault(self) -> str:
        """Read what others have added, and return what is wrong, empty if nothing is."""
        try:
            if os.fstat(self._descriptor).st_ino != self._path.stat().st_ino:
                return f'{self._path.name}: another file has its name'
            self._catch_up()
        except FileNotFoundError:
            return f'{self._path.name}: is gone'
        except EvidenceError as error:
            return str(error)
        return ''

    def _begin(self, following: Path, fault: str, time_s: float) -> None:
        """Write a new segment, whose line says what it follows and why."""
        size = os.fstat(self._descriptor).st_size
        what = {
            'follows': self._path.name,
            'why': fault,
            'bytes': size,
            'sha256': hashlib.sha256(os.pread(self._descriptor, size, 0)).hexdigest(),
        }
        event = Event(time_s=time_s, kind=DAMAGED, by='evidence log', what=what)
        write_whole(following, line_of(chained(1, NOTHING, event.to_plain())) + b'\n')

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

    def _catch_up(self) -> list[dict[str, Any]]:
        """Read the lines of others, and return their entries; raises `EvidenceError`."""
        size = os.fstat(self._descriptor).st_size
        if size < self._length:
            raise EvidenceError(f'{self._path.name}: lines have been removed')
        data = os.pread(self._descriptor, size - self._length, self._length)
        whole = data[: data.rfind(b'\n') + 1]
        if len(whole) < len(data):
            os.ftruncate(self._descriptor, self._length + len(whole))
        entries = checked(whole.split(b'\n')[:-1], self._path.name, self._last)
        self._length += len(whole)
        if entries:
            self._last = (entries[-1]['n'], entries[-1]['hash'])
        return entries
