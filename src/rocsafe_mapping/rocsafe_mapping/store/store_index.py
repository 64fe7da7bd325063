# SPDX-License-Identifier: Apache-2.0
"""A store's photographs as a table to be asked, made from its files and never needed by them."""

import math
import sqlite3
from collections.abc import Sequence
from pathlib import Path

from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.store.catalogue import StoredShot

INDEX = 'index.sqlite'
SCHEMA = """
CREATE TABLE IF NOT EXISTS photographs (
    shot_id TEXT PRIMARY KEY, image TEXT NOT NULL, vehicle TEXT NOT NULL, time_ns INTEGER NOT NULL,
    latitude_deg REAL, longitude_deg REAL, altitude_m REAL, height_agl_m REAL, sha256 TEXT NOT NULL
);
CREATE INDEX IF NOT EXISTS by_time ON photographs (time_ns);
CREATE INDEX IF NOT EXISTS by_place ON photographs (latitude_deg, longitude_deg);
"""
INSERT = 'INSERT OR REPLACE INTO photographs VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)'


def write_index(folder: Path, shots: Sequence[StoredShot]) -> None:
    """Bring the index of a store up to date; a damaged one is made again.

    Raises
    ------
    StoreError
        If it cannot be written.
    """
    path = folder / INDEX
    try:
        _fill(path, shots)
    except sqlite3.DatabaseError:
        try:
            for leftover in folder.glob(INDEX + '*'):
                leftover.unlink()
            _fill(path, shots)
        except (OSError, sqlite3.Error) as error:
            raise StoreError(f'cannot write index {path}: {error}') from error


def _fill(path: Path, shots: Sequence[StoredShot]) -> None:
    connection = sqlite3.connect(path)
    try:
        connection.execute('PRAGMA journal_mode = WAL')
        connection.execute('PRAGMA synchronous = FULL')
        connection.executescript(SCHEMA)
        with connection:
            known = {row[0] for row in connection.execute('SELECT shot_id FROM photographs')}
            wanted = {shot.record.shot_id for shot in shots}
            gone = [(shot_id,) for shot_id in sorted(known - wanted)]
            connection.executemany('DELETE FROM photographs WHERE shot_id = ?', gone)
            fresh = [_row(shot) for shot in shots if shot.record.shot_id not in known]
            connection.executemany(INSERT, fresh)
    finally:
        connection.close()


def _row(shot: StoredShot) -> tuple[str | int | float | None, ...]:
    record = shot.record
    numbers = (
        record.latitude_deg, record.longitude_deg, record.altitude_m, record.height_agl_m
    )  # fmt: skip
    known = (value if math.isfinite(value) else None for value in numbers)
    return (
        record.shot_id, shot.path.name, record.vehicle, record.time_ns, *known, record.sha256
    )  # fmt: skip
