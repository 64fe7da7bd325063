# SPDX-License-Identifier: Apache-2.0
"""The image store: keeps each photograph on disk, exactly once, also after a crash.

A photograph is a JPEG file with Exif and, beside it, a JSON file with its record. It counts as
stored when its line stands in the manifest; the line is written last, after both files are safe
on disk, and the vehicle hears of it only then. After a crash, the next collector that opens the
store completes or removes what is unfinished.
"""

import fcntl
import hashlib
import io
import json
import os
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from PIL import Image

from rocsafe_geo.storage.durable import (
    PART_SUFFIX,
    AppendOnlyFile,
    discard_part,
    finish_part,
    sync_directory,
    write_part,
    write_whole,
)
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.exif import with_exif
from rocsafe_mapping.photographs.shot import ShotRecord, plain_of_record
from rocsafe_mapping.store.catalogue import (
    IMAGE_SUFFIX,
    LOCK,
    MANIFEST,
    REJECTED,
    SIDECAR_SUFFIX,
    ManifestEntry,
    Notice,
    entry_of_files,
    entry_of_line,
)

# Room for the map and the report of a mission.
DEFAULT_RESERVE_BYTES = 64 * 2**20


class Status(Enum):
    """Result of storing a photograph."""

    STORED = 'stored'
    DUPLICATE = 'duplicate'
    REJECTED = 'rejected'


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """The store's answer to a photograph.

    Attributes
    ----------
    status
        What became of it.
    sha256
        Of the image as received, lower-case hexadecimal.
    path
        Of the stored image, absolute; None if rejected.
    reason
        Why it was rejected, else empty.
    """

    status: Status
    sha256: str
    path: Path | None = None
    reason: str = ''


class ImageStore:
    """The one writer of a store.

    Parameters
    ----------
    directory
        Where the store is or shall be.
    notice
        Is told, in one line each, what was found unfinished on opening.
    reserve_bytes
        Space that a photograph must leave on the disk; a clear refusal comes before the disk is
        full.

    Raises
    ------
    StoreError
        If the directory cannot be used or another process writes to it.
    """

    def __init__(
        self,
        directory: Path,
        notice: Notice = lambda _text: None,
        reserve_bytes: int = DEFAULT_RESERVE_BYTES,
    ) -> None:
        self._directory = directory.absolute()
        self._reserve_bytes = reserve_bytes
        self._notice = notice
        try:
            (self._directory / REJECTED).mkdir(parents=True, exist_ok=True)
            self._lock = _locked(self._directory / LOCK)
            self._manifest = AppendOnlyFile(self._directory / MANIFEST)
            self._entries = self._intact_entries()
            self._put_in_order()
        except OSError as error:
            raise StoreError(f'cannot use image store {self._directory}: {error}') from error

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def directory(self) -> Path:
        """Where the store is."""
        return self._directory

    def put(self, record: ShotRecord, image: bytes, *, is_tagged: bool = False) -> Answer:
        """Store `image`, unless it is stored already, and say what became of it.

        With `is_tagged` the image has Exif of its own, and is stored byte by byte as it is.

        Raises
        ------
        StoreError
            If the disk fails or is full; nothing has changed, the caller may try again.
        """
        sha256 = hashlib.sha256(image).hexdigest()
        if sha256 != record.sha256:
            return _rejection(sha256, f'sha256 is {sha256}, the record says {record.sha256}')
        known = self._entries.get(record.shot_id)
        if known is not None and known.received_sha256 != sha256:
            return self.reject(image, f'{record.shot_id} is stored already with another image')
        path = self._image_path(record.shot_id)
        if known is not None:
            return Answer(status=Status.DUPLICATE, sha256=sha256, path=path)
        try:
            _require_decodable(image)
            stored = image if is_tagged else with_exif(image, record)
        except ValueError as error:
            return self.reject(image, str(error))
        try:
            self._require_space(len(stored))
            self._write(record, stored)
        except OSError as error:
            raise StoreError(f'cannot store {record.shot_id} at {path}: {error}') from error
        return Answer(status=Status.STORED, sha256=sha256, path=path)

    def reject(self, image: bytes, reason: str) -> Answer:
        """Keep `image`, which can never be stored, apart for inspection.

        Raises
        ------
        StoreError
            If the disk fails or is full.
        """
        sha256 = hashlib.sha256(image).hexdigest()
        path = self._directory / REJECTED / sha256
        try:
            if not path.exists():
                write_whole(path, image)
        except OSError as error:
            raise StoreError(f'cannot keep rejected image at {path}: {error}') from error
        return _rejection(sha256, reason)

    def close(self) -> None:
        """Let another process write to the store."""
        self._manifest.close()
        os.close(self._lock)

    def _write(self, record: ShotRecord, stored: bytes) -> None:
        entry = ManifestEntry(
            shot_id=record.shot_id,
            received_sha256=record.sha256,
            stored_sha256=hashlib.sha256(stored).hexdigest(),
            stored_bytes=len(stored),
        )
        plain = plain_of_record(record) | {
            'stored_sha256': entry.stored_sha256,
            'stored_bytes': entry.stored_bytes,
        }
        image_path = self._image_path(record.shot_id)
        sidecar_path = image_path.with_suffix(SIDECAR_SUFFIX)
        try:
            write_part(sidecar_path, json.dumps(plain, indent=1).encode() + b'\n')
            write_part(image_path, stored)
        except OSError:
            # A full disk has no room for it.
            discard_part(sidecar_path)
            raise
        finish_part(sidecar_path)
        finish_part(image_path)
        sync_directory(self._directory)
        self._add(entry)

    def _require_space(self, size: int) -> None:
        """Raise StoreError unless `size` bytes leave the reserve of the disk alone."""
        disk = os.statvfs(self._directory)
        free = disk.f_bavail * disk.f_frsize
        if free - size < self._reserve_bytes:
            raise StoreError(
                f'disk of {self._directory} is as good as full: {free // 2**20} MiB are free, '
                f'{self._reserve_bytes // 2**20} MiB are kept in reserve'
            )

    def _add(self, entry: ManifestEntry) -> None:
        self._manifest.append(entry.line())
        self._entries[entry.shot_id] = entry

    def _image_path(self, shot_id: str) -> Path:
        return self._directory / (shot_id + IMAGE_SUFFIX)

    def _intact_entries(self) -> dict[str, ManifestEntry]:
        """Return the manifest's entries whose files are there."""
        entries = {}
        for number, line in enumerate(self._manifest.lines(), start=1):
            entry = entry_of_line(line)
            if entry is None:
                self._notice(f'{MANIFEST} line {number} is damaged')
            elif not self._has_files(entry):
                self._notice(f'a file of {entry.shot_id} is missing or damaged')
            else:
                entries[entry.shot_id] = entry
        return entries

    def _has_files(self, entry: ManifestEntry) -> bool:
        image = self._image_path(entry.shot_id)
        has_record = image.with_suffix(SIDECAR_SUFFIX).exists()
        return has_record and image.exists() and image.stat().st_size == entry.stored_bytes

    def _put_in_order(self) -> None:
        """Remove half-written files; adopt photographs that lack nothing but their line."""
        for part in self._directory.glob('*' + PART_SUFFIX):
            part.unlink()
        for sidecar in sorted(self._directory.glob('*' + SIDECAR_SUFFIX)):
            if sidecar.stem not in self._entries:
                entry = entry_of_files(sidecar, self._image_path(sidecar.stem))
                if entry is not None:
                    self._add(entry)
                    self._notice(f'{entry.shot_id} was complete but for its line in {MANIFEST}')


def _rejection(sha256: str, reason: str) -> Answer:
    return Answer(status=Status.REJECTED, sha256=sha256, reason=reason)


def _locked(path: Path) -> int:
    """Return the descriptor of `path`, locked until it is closed or the process ends."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(descriptor)
        raise StoreError(f'image store {path.parent} is in use by another process') from error
    return descriptor


def _require_decodable(jpeg: bytes) -> None:
    """Raise ValueError unless every pixel of `jpeg` can be decoded."""
    try:
        with Image.open(io.BytesIO(jpeg), formats=['JPEG']) as image:
            image.load()
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise ValueError(f'image cannot be decoded: {error}') from error
