# SPDX-License-Identifier: Apache-2.0
"""The rows of a campaign on disk, each safe before the next run of its worker counts."""

import fcntl
import json
import os
from pathlib import Path
from types import TracebackType

from rocsafe_campaign.errors import CampaignError
from rocsafe_campaign.results.row import Row

FILE = 'rows.jsonl'


class Journal:
    """An append-only file of rows, one JSON object a line.

    A line that was being written when the process was killed is cut off: its run is done again.

    Parameters
    ----------
    folder
        Folder of the campaign; made if it does not exist.

    Attributes
    ----------
    rows
        The rows on disk by key.

    Raises
    ------
    CampaignError
        If another process writes to it, or the file is not a journal.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / FILE
        self.rows: dict[str, Row] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open('a+b')
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise CampaignError(f'{folder}: another campaign writes there') from error
        except OSError as error:
            raise CampaignError(f'{folder}: {error.strerror}') from error
        self._read()

    def __enter__(self) -> 'Journal':
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self._file.close()

    def add(self, row: Row) -> None:
        """Append a row; it is on disk when this returns."""
        self._file.write(json.dumps(row.to_plain()).encode() + b'\n')
        self._file.flush()
        os.fsync(self._file.fileno())
        self.rows[row.key] = row

    def _read(self) -> None:
        self._file.seek(0)
        whole = 0
        for number, line in enumerate(self._file, start=1):
            if not line.endswith(b'\n'):
                break
            try:
                row = Row.of_plain(json.loads(line))
            except (ValueError, KeyError, TypeError) as error:
                raise CampaignError(f'{self._path}: line {number} is no row: {error}') from error
            self.rows[row.key] = row
            whole += len(line)
        self._file.truncate(whole)
        self._file.seek(0, os.SEEK_END)
