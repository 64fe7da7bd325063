# SPDX-License-Identifier: Apache-2.0
"""Unfinished uploads of a repository: files named by the SHA-256 that they will have."""

import hashlib
import os
import shutil
from pathlib import Path
from typing import BinaryIO
from uuid import uuid4

from rocsafe_geo.storage.durable import sync_file

MOST_UPLOAD_BYTES = 256 * 2**20
MOST_UPLOADS = 256
FORGOTTEN_AFTER_S = 86_400.0
"""An upload that has not grown for so long is removed when room for others is needed."""

RESERVE_BYTES = 2**20
CHUNK_BYTES = 64 * 1024
PART_SUFFIX = '.part'


class UploadRefusedError(Exception):
    """A piece is not taken.

    Attributes
    ----------
    status
        Of the HTTP answer.
    """

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


class Uploads:
    """The unfinished uploads in a folder, which is made if it does not exist.

    Pieces that a former process left half received are removed.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(exist_ok=True)
        for left in folder.glob(f'*{PART_SUFFIX}'):
            left.unlink(missing_ok=True)

    def path(self, sha256: str) -> Path:
        """Return the file of an upload."""
        return self._folder / sha256

    def size(self, sha256: str) -> int:
        """Return the number of bytes of an upload that are there."""
        path = self.path(sha256)
        return path.stat().st_size if path.exists() else 0

    def received(self, source: BinaryIO, length: int) -> tuple[Path, bytes]:
        """Read a piece to a file of its own; return the file and the digest of the piece.

        Raises
        ------
        UploadRefusedError
            If the disk is full, or the piece ends early.
        """
        if shutil.disk_usage(self._folder).free < length + RESERVE_BYTES:
            raise UploadRefusedError(507, 'disk is full')
        path = self._folder / f'{uuid4().hex}{PART_SUFFIX}'
        try:
            return path, _copied(source, path, length)
        except BaseException:
            path.unlink(missing_ok=True)
            raise

    def append(self, sha256: str, offset: int, piece: Path) -> int:
        """Add a piece to an upload; return the new size. The caller holds the lock.

        Raises
        ------
        UploadRefusedError
            If the upload has another size, would be too large, or is one too many.
        """
        path, size = self.path(sha256), self.size(sha256)
        if offset != size:
            raise UploadRefusedError(409, f'offset is {size}')
        grown = size + piece.stat().st_size
        if grown > MOST_UPLOAD_BYTES:
            raise UploadRefusedError(413, f'{grown} bytes exceed {MOST_UPLOAD_BYTES}')
        if not path.exists():
            self._make_room(piece.stat().st_mtime)
        with piece.open('rb') as source, path.open('ab') as file:
            shutil.copyfileobj(source, file, CHUNK_BYTES)
        sync_file(path)
        return grown

    def remove(self, sha256: str) -> None:
        """Remove an upload."""
        self.path(sha256).unlink(missing_ok=True)

    def _make_room(self, now_s: float) -> None:
        """Remove forgotten uploads if there are too many; refuse another if that does not help."""
        found = [
            entry for entry in os.scandir(self._folder) if not entry.name.endswith(PART_SUFFIX)
        ]
        if len(found) < MOST_UPLOADS:
            return
        oldest_s = now_s - FORGOTTEN_AFTER_S
        forgotten = [entry for entry in found if entry.stat().st_mtime < oldest_s]
        for entry in forgotten:
            Path(entry.path).unlink(missing_ok=True)
        if len(found) - len(forgotten) >= MOST_UPLOADS:
            raise UploadRefusedError(503, f'{MOST_UPLOADS} uploads are unfinished')


def _copied(source: BinaryIO, path: Path, length: int) -> bytes:
    """Copy `length` bytes to a file and return their digest."""
    digest, left = hashlib.sha256(), length
    with path.open('wb') as file:
        while left:
            chunk = source.read(min(CHUNK_BYTES, left))
            if not chunk:
                raise UploadRefusedError(400, f'{left} of {length} bytes are missing')
            digest.update(chunk)
            file.write(chunk)
            left -= len(chunk)
    return digest.digest()
