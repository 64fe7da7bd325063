# SPDX-License-Identifier: Apache-2.0
"""The rows of a campaign on disk, each safe before its worker is given the next run."""

import fcntl
import json
import os
import time
from pathlib import Path
from types import TracebackType

from rocsafe_campaign.errors import CampaignError
from rocsafe_campaign.results.row import Row

FILE = 'rows.jsonl'
_POLL_S = 0.1


def part_name(worker: int) -> str:
    """Return the name of the file in which a worker keeps its rows until they are collected."""
    return f'rows-{worker:03d}.jsonl'


class Journal:
    """An append-only file of rows, one JSON object a line.

    A line that was being written when the process was killed is cut off: its run is done again.

    Parameters
    ----------
    folder
        Folder of the campaign; made if it does not exist.
    name
        Name of the file.
    patience_s
        Longest wait for another process that writes to it.

    Attributes
    ----------
    rows
        The rows on disk by key.

    Raises
    ------
    CampaignError
        If another process writes to it, or the file is not a journal.
    """

    def __init__(self, folder: Path, name: str = FILE, patience_s: float = 0.0) -> None:
        self._path = folder / name
        self.rows: dict[str, Row] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open('a+b')
            self._lock(patience_s)
        except BlockingIOError as error:
            raise CampaignError(f'{folder}: another campaign writes there') from error
        except OSError as error:
            raise CampaignError(f'{folder}: {error.strerror}') from error
        self._read()

    def _lock(self, patience_s: float) -> None:
        until_s = time.monotonic() + patience_s
        while True:
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                if time.monotonic() >= until_s:
                    self._file.close()
                    raise
                time.sleep(_POLL_S)
            else:
                return

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
        line = json.dumps(row.to_plain())
        try:
            self._file.write(line.encode() + b'\n')
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise CampaignError(f'{self._path}: {error.strerror}') from error
        # As it is read back, so that the table of an interrupted campaign has the same bytes.
        self.rows[row.key] = Row.of_plain(json.loads(line))

    def collect(self, patience_s: float) -> None:
        """Take over the rows that workers wrote, of which some may outlive their command.

        Parameters
        ----------
        patience_s
            Longest wait for the end of the run of such a worker.
        """
        for path in sorted(self._path.parent.glob('rows-*.jsonl')):
            with Journal(path.parent, path.name, patience_s) as part:
                for key, row in part.rows.items():
                    if key not in self.rows:
                        self.add(row)
                path.unlink()

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
