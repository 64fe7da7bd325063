# SPDX-License-Identifier: Apache-2.0
"""Files that are complete or absent, even after a loss of power."""

import os
from pathlib import Path

PART_SUFFIX = '.part'


def part_of(path: Path) -> Path:
    """Return the path to which the content of `path` is written before it is complete."""
    return path.with_name(path.name + PART_SUFFIX)


def write_part(path: Path, data: bytes) -> None:
    """Write `data` to disk beside `path`; `finish_part` gives it its name.

    Raises
    ------
    OSError
        If it cannot be written; nothing is left behind.
    """
    try:
        with part_of(path).open('wb') as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
    except OSError:
        discard_part(path)
        raise


def finish_part(path: Path) -> None:
    """Give the part of `path` its name; safe on disk after `sync_directory`."""
    part_of(path).replace(path)


def discard_part(path: Path) -> None:
    """Remove what `write_part` wrote, if anything."""
    part_of(path).unlink(missing_ok=True)


def write_whole(path: Path, data: bytes) -> None:
    """Write `data` to `path`, which always holds either its old content or all of `data`.

    Raises
    ------
    OSError
        If it cannot be written; `path` is then unchanged.
    """
    write_part(path, data)
    finish_part(path)
    sync_directory(path.parent)


def replace_whole(path: Path, data: bytes) -> None:
    """Write `data` to `path` as `write_whole`, but much faster: a loss of power may undo it."""
    part_of(path).write_bytes(data)
    finish_part(path)


def sync_file(path: Path) -> None:
    """Bring what was written to `path` safely to disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_directory(directory: Path) -> None:
    """Bring the names in `directory` safely to disk."""
    sync_file(directory)


class AppendOnlyFile:
    """A file of lines that grows by whole lines only.

    Raises
    ------
    OSError
        If it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        self._length = self._cut_torn_line()

    def lines(self) -> list[bytes]:
        """Return all lines, without their ends."""
        return os.pread(self._descriptor, self._length, 0).split(b'\n')[:-1]

    def append(self, line: bytes) -> None:
        """Add `line` and its end; it is safely on disk on return.

        Raises
        ------
        OSError
            If it cannot be written; the file is then unchanged.
        ValueError
            If `line` contains a line end.
        """
        if b'\n' in line:
            raise ValueError('a line must not contain a line end')
        data = line + b'\n'
        try:
            _write_all(self._descriptor, data)
            os.fsync(self._descriptor)
        except OSError:
            os.ftruncate(self._descriptor, self._length)
            raise
        self._length += len(data)

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

    def _cut_torn_line(self) -> int:
        """Remove a last line without its end, as a killed writer leaves it; return the length."""
        size = os.fstat(self._descriptor).st_size
        content = os.pread(self._descriptor, size, 0)
        length = content.rfind(b'\n') + 1
        if length < size:
            os.ftruncate(self._descriptor, length)
        return length


def _write_all(descriptor: int, data: bytes) -> None:
    while data:
        data = data[os.write(descriptor, data) :]
