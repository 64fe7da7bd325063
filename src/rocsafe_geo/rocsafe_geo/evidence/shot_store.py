# SPDX-License-Identifier: Apache-2.0
"""Photographs that a vehicle keeps until it gets a receipt for them."""

from collections.abc import Iterator
from pathlib import Path

from rocsafe_geo.evidence.shot import Shot, shot_of, shot_record
from rocsafe_geo.storage.durable import write_whole

# A photograph without a receipt is sent again after this much wall time,
RESEND_S = 1.0
# but no more than so many at once, to limit the load when the receiver returns.
RESEND_BURST = 20
# The photographs of a small camera in a day.
DEFAULT_MOST_BYTES = 8 * 2**30


class SpoolError(OSError):
    """A photograph cannot be kept, or one that was kept cannot be read back."""


class ShotStore:
    """Photographs without a receipt, in memory and, if a folder is given, on disk.

    A photograph is on disk as ``<shot_id>.jpg`` and, written after it, ``<shot_id>.json``. One
    without the other was left by a killed process and does not count.

    The size of the spool is limited. If a new photograph does not fit, those that were sent
    longest ago are deleted. A photograph that was never sent is never deleted.

    Parameters
    ----------
    folder
        Folder of the spool; None: memory only.
    most_bytes
        Largest size of all images, bytes.
    """

    def __init__(self, folder: Path | None = None, most_bytes: int = DEFAULT_MOST_BYTES) -> None:
        if most_bytes < 1:
            raise ValueError(f'most_bytes = {most_bytes} must be at least 1')
        self._folder = folder
        self._most_bytes = most_bytes
        self._pending: dict[str, Shot] = {}
        self._sent_s: dict[str, float] = {}
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            self._pending = {shot.shot_id: shot for shot in _stored_shots(folder)}

    def __len__(self) -> int:
        """Return how many photographs wait for a receipt."""
        return len(self._pending)

    @property
    def newest_sequence(self) -> int:
        """Highest number of a photograph that is kept; -1: there is none."""
        return max((shot.sequence for shot in self._pending.values()), default=-1)

    def add(self, shot: Shot) -> None:
        """Keep `shot`. Once this returns, it survives a kill and a loss of power.

        Raises
        ------
        SpoolError
            If the spool is full of photographs that were never sent, or cannot be written.
        """
        self._make_room(len(shot.jpeg))
        if self._folder is not None:
            try:
                write_whole(self._folder / f'{shot.shot_id}.jpg', shot.jpeg)
                write_whole(self._folder / f'{shot.shot_id}.json', shot_record(shot))
            except OSError as error:
                raise SpoolError(f'{self._folder}: cannot keep {shot.shot_id}: {error}') from error
        self._pending[shot.shot_id] = shot

    def take_receipt(self, shot_id: str, sha256: str) -> bool:
        """Delete a photograph that has a receipt; return whether it was the one kept here.

        A receipt for other bytes, or for a photograph that is not kept, has no effect.
        """
        shot = self._pending.get(shot_id)
        if shot is None or shot.sha256 != sha256:
            return False
        self._forget(shot_id)
        return True

    def mark_sent(self, shot_id: str, wall_s: float) -> None:
        """Note that a photograph was sent at a wall time."""
        if shot_id in self._pending:
            self._sent_s[shot_id] = wall_s

    def overdue(self, wall_s: float) -> list[Shot]:
        """Return the photographs to be sent (again) at a wall time, oldest first."""
        due = [
            shot
            for shot_id, shot in self._pending.items()
            if wall_s - self._sent_s.get(shot_id, -RESEND_S) >= RESEND_S
        ]
        return due[:RESEND_BURST]

    def _make_room(self, size: int) -> None:
        used = sum(len(shot.jpeg) for shot in self._pending.values())
        for _, shot_id in sorted((sent_s, shot_id) for shot_id, sent_s in self._sent_s.items()):
            if used + size <= self._most_bytes:
                return
            used -= len(self._pending[shot_id].jpeg)
            self._forget(shot_id)
        if used + size > self._most_bytes:
            raise SpoolError(
                f'spool is full: {used} bytes of photographs that were never sent and {size} more '
                f'exceed {self._most_bytes}'
            )

    def _forget(self, shot_id: str) -> None:
        del self._pending[shot_id]
        self._sent_s.pop(shot_id, None)
        if self._folder is not None:
            (self._folder / f'{shot_id}.json').unlink(missing_ok=True)
            (self._folder / f'{shot_id}.jpg').unlink(missing_ok=True)


def _stored_shots(folder: Path) -> Iterator[Shot]:
    for path in sorted(folder.glob('*-*.json')):
        try:
            yield shot_of(path.read_bytes(), path.with_suffix('.jpg').read_bytes())
        except (OSError, ValueError) as error:
            raise SpoolError(f'{path}: {error}') from error
