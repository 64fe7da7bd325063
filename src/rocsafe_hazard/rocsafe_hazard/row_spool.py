# SPDX-License-Identifier: Apache-2.0
"""Rows in a CSV file, so that a node that is started again has what it had.

A row that a crash has cut off is left out when the file is read.
"""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO


class SpoolError(Exception):
    """The file cannot be read or written."""


class RowSpool:
    """Keeps rows in a file of a directory; with an empty name of the directory, keeps none.

    Parameters
    ----------
    directory
        Where the file is.
    file_name
        Name of the file.
    columns
        Names of the columns, the first line of the file.
    """

    def __init__(self, directory: str, file_name: str, columns: Sequence[str]) -> None:
        self._path = Path(directory) / file_name if directory else None
        self._columns = tuple(columns)
        self._stream: IO[str] | None = None

    def restored(self) -> Iterator[dict[str, str]]:
        """Yield the rows that were kept before.

        Raises
        ------
        SpoolError
            If there is a file that cannot be read.
        """
        if self._path is None or not self._path.exists():
            return
        try:
            with self._path.open(encoding='utf-8', newline='') as stream:
                # A row that was cut off has no end of line.
                lines = [line for line in stream if line.endswith('\n')]
        except (OSError, UnicodeDecodeError) as error:
            raise SpoolError(f'{self._path}: cannot be read: {error}') from error
        yield from csv.DictReader(lines)

    def keep(self, row: Sequence[object]) -> None:
        """Append a row, in the order of the columns.

        Raises
        ------
        SpoolError
            If it cannot be written.
        """
        if self._path is None:
            return
        try:
            if self._stream is None:
                self._stream = self._opened(self._path)
            csv.writer(self._stream, lineterminator='\n').writerow(row)
            self._stream.flush()
        except OSError as error:
            raise SpoolError(f'{self._path}: cannot be written: {error}') from error

    def _opened(self, path: Path) -> IO[str]:
        path.parent.mkdir(parents=True, exist_ok=True)
        content = path.read_bytes() if path.exists() else b''
        stream = path.open('a', encoding='utf-8', newline='')
        if not content:
            csv.writer(stream, lineterminator='\n').writerow(self._columns)
        elif not content.endswith(b'\n'):
            stream.write('\n')
        return stream
