# SPDX-License-Identifier: Apache-2.0
"""Numbers the photographs of a real vehicle, also across restarts of the bridge."""

import json
from pathlib import Path

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.evidence.shot_store import ShotStore, SpoolError
from rocsafe_geo.storage.durable import write_whole

_NEXT = 'next.json'


class ShotNumbering:
    """Numbers photographs from 0 without gaps, and keeps each until it has a receipt.

    Attributes
    ----------
    store
        Photographs without a receipt.
    next_sequence
        Number of the next photograph.

    Raises
    ------
    SpoolError
        If the folder is damaged.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._next = None if folder is None else folder / _NEXT
        self.store = ShotStore(folder)
        self.next_sequence = max(self._noted(), self.store.newest_sequence + 1)

    def add(self, shot: Shot) -> None:
        """Keep the photograph that has the next number; from then on it survives a kill.

        Raises
        ------
        SpoolError
            If it cannot be kept; its number is then free for the next one.
        """
        self.store.add(shot)
        self.next_sequence = shot.sequence + 1
        if self._next is not None:
            try:
                write_whole(self._next, json.dumps({'next': self.next_sequence}).encode())
            except OSError as error:
                raise SpoolError(f'{self._next}: {error}') from error

    def _noted(self) -> int:
        """Return the next number as it was last written: the store is empty after all receipts."""
        if self._next is None or not self._next.exists():
            return 0
        try:
            return int(json.loads(self._next.read_bytes())['next'])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise SpoolError(f'{self._next}: not a number of photographs: {error!r}') from error
