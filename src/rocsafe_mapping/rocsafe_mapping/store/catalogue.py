# SPDX-License-Identifier: Apache-2.0
"""The layout of an image store on disk, and reading it.

``<shot_id>.jpg`` is a photograph with Exif, ``<shot_id>.json`` its record. ``manifest.jsonl`` has
one line for each stored photograph and only grows. ``rejected/`` keeps images that could not be
stored, named by their SHA-256. These names stand here and nowhere else.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path

from rocsafe_geo.storage.value_file import values_of
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.shot import ShotRecord, record_of_plain

MANIFEST = 'manifest.jsonl'
REJECTED = 'rejected'
LOCK = '.lock'
IMAGE_SUFFIX = '.jpg'
SIDECAR_SUFFIX = '.json'
Notice = Callable[[str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class ManifestEntry:
    """A line of the manifest.

    Attributes
    ----------
    shot_id
        Of the photograph; its files are named after it.
    received_sha256
        Of the image as the vehicle sent it.
    stored_sha256, stored_bytes
        Of the file, which has Exif added.
    """

    shot_id: str
    received_sha256: str
    stored_sha256: str
    stored_bytes: int

    def line(self) -> bytes:
        """Return the line, without its end."""
        return json.dumps(
            {
                'shot_id': self.shot_id,
                'image': self.shot_id + IMAGE_SUFFIX,
                'record': self.shot_id + SIDECAR_SUFFIX,
                'received_sha256': self.received_sha256,
                'stored_sha256': self.stored_sha256,
                'stored_bytes': self.stored_bytes,
            }
        ).encode()


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredShot:
    """A photograph of the store: its record and where its image is.

    Attributes
    ----------
    record, path
        Of the photograph.
    sha256, size_bytes
        Of the stored file; empty and 0 where only the file has them.
    """

    record: ShotRecord
    path: Path
    sha256: str = ''
    size_bytes: int = 0

    def read_image(self) -> bytes:
        """Return the JPEG file.

        Raises
        ------
        StoreError
            If it cannot be read.
        """
        try:
            return self.path.read_bytes()
        except OSError as error:
            raise StoreError(f'cannot read image {self.path}: {error.strerror}') from error


def read_store(directory: Path, notice: Notice) -> tuple[StoredShot, ...]:
    """Return the stored photographs in the order in which they were stored; may be called anytime.

    One whose record cannot be read is left out, and `notice` is told in one line.

    Raises
    ------
    StoreError
        If the manifest cannot be read; a store that does not exist yet is empty.
    """
    manifest = directory.absolute() / MANIFEST
    if not manifest.exists():
        return ()
    try:
        # Text after the last line end is still being written.
        lines = manifest.read_bytes().split(b'\n')[:-1]
    except OSError as error:
        raise StoreError(f'cannot read {manifest}: {error.strerror}') from error
    entries = [entry for entry in map(entry_of_line, lines) if entry is not None]
    shots = []
    for shot_id in dict.fromkeys(entry.shot_id for entry in entries):
        try:
            shots.append(read_shot(directory, shot_id))
        except StoreError as error:
            notice(str(error))
    return tuple(shots)


def read_shot(directory: Path, shot_id: str) -> StoredShot:
    """Return one photograph of the store in `directory`.

    Raises
    ------
    StoreError
        If there is no such photograph or its record cannot be read.
    """
    sidecar = directory.absolute() / (shot_id + SIDECAR_SUFFIX)
    try:
        plain = json.loads(sidecar.read_bytes())
        record = record_of_plain(plain)
        size_bytes = int(plain.get('stored_bytes', 0))
    except (OSError, ValueError, TypeError, OverflowError, RecursionError) as error:
        raise StoreError(f'cannot read record {sidecar}: {error}') from error
    if record.shot_id != shot_id:
        raise StoreError(f'cannot read record {sidecar}: it is that of {record.shot_id}')
    return StoredShot(
        record=record,
        path=sidecar.with_suffix(IMAGE_SUFFIX),
        sha256=str(plain.get('stored_sha256', '')),
        size_bytes=size_bytes,
    )


def entry_of_line(line: bytes) -> ManifestEntry | None:
    """Return the entry that `line` of the manifest holds, None if it is damaged."""
    try:
        values = json.loads(line)
        known = {field.name: values[field.name] for field in fields(ManifestEntry)}
        return values_of(known, ManifestEntry, MANIFEST)
    except (ValueError, KeyError, TypeError, RecursionError):
        return None


def entry_of_files(sidecar: Path, image: Path) -> ManifestEntry | None:
    """Return the entry that `sidecar` and `image` lack, None unless they are whole."""
    try:
        plain = json.loads(sidecar.read_bytes())
        record = record_of_plain(plain)
        stored = image.read_bytes()
        whole = hashlib.sha256(stored).hexdigest() == plain['stored_sha256']
    except (OSError, ValueError, KeyError, RecursionError):
        return None
    if not whole or record.shot_id != sidecar.stem:
        return None
    return ManifestEntry(
        shot_id=record.shot_id,
        received_sha256=record.sha256,
        stored_sha256=plain['stored_sha256'],
        stored_bytes=len(stored),
    )
