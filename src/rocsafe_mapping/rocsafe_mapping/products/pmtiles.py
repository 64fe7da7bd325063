# SPDX-License-Identifier: Apache-2.0
"""Tiles for web maps as one file that a plain web server can serve (PMTiles, version 3).

Layout: header, root directory, metadata, leaf directories, tiles. Directories are lists of
varints, compressed; tiles are sorted along a Hilbert curve. See
https://github.com/protomaps/PMTiles/blob/main/spec/v3/spec.md.
"""

import gzip
import hashlib
import json
import math
import shutil
import sqlite3
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from rocsafe_geo.storage.durable import discard_part, finish_part, part_of, sync_file
from rocsafe_mapping.errors import MappingError

MAGIC, VERSION = b'PMTiles', 3
HEADER = struct.Struct('<7sB11Q6B4iB2i')
# A reader asks for so many bytes first: header and root directory must fit.
FIRST_BYTES = 16_384
NO_COMPRESSION, GZIP, PNG = 1, 2, 2
DEGREES = 10_000_000
LEAF_ENTRIES = 4096


@dataclass(frozen=True, slots=True)
class Entry:
    """A tile, or a run of equal tiles, or with `run` 0 a leaf directory."""

    tile_id: int
    offset: int
    length: int
    run: int


def tile_id(zoom: int, x: int, y: int) -> int:
    """Return the place of a tile on the curve: all coarser zooms first, then Hilbert's order."""
    place = (4**zoom - 1) // 3
    side = 1 << zoom
    step = side >> 1
    while step:
        right, low = int(bool(x & step)), int(bool(y & step))
        place += step * step * ((3 * right) ^ low)
        if not low:
            if right:
                x, y = side - 1 - x, side - 1 - y
            x, y = y, x
        step >>= 1
    return place


def write_pmtiles(mbtiles: Path, path: Path) -> None:
    """Write the tiles of an MBTiles file of PNG pictures to `path`.

    Raises
    ------
    MappingError: if they cannot be read or the file cannot be written.
    """
    part, tiles = part_of(path), path.with_name(path.name + '.tiles')
    try:
        # Opened as a URI: a missing file shall not become an empty one.
        source = sqlite3.connect(f'{mbtiles.absolute().as_uri()}?mode=ro', uri=True)
        try:
            with tiles.open('wb') as data:
                entries, contents = _copied(source, data)
            metadata = dict(source.execute('SELECT name, value FROM metadata'))
            zooms = source.execute('SELECT MIN(zoom_level), MAX(zoom_level) FROM tiles').fetchone()
        finally:
            source.close()
        if not entries:
            raise MappingError(f'{mbtiles} holds no tiles')
        _join(part, tiles, _sections(entries, contents, metadata, zooms, tiles.stat().st_size))
        sync_file(part)
        finish_part(path)
    except (OSError, sqlite3.Error, ValueError) as error:
        discard_part(path)
        raise MappingError(f'cannot write tiles {path}: {error}') from error
    finally:
        tiles.unlink(missing_ok=True)


def _copied(source: sqlite3.Connection, data: IO[bytes]) -> tuple[list[Entry], int]:
    """Write all tiles in order, equal ones once; return their entries and how many there are."""
    places = sorted(
        (tile_id(zoom, x, (1 << zoom) - 1 - row), number)
        for number, zoom, x, row in source.execute(
            'SELECT rowid, zoom_level, tile_column, tile_row FROM tiles'
        )
    )  # fmt: skip
    entries: list[Entry] = []
    known: dict[bytes, tuple[int, int]] = {}
    for place, number in places:
        asked = source.execute('SELECT tile_data FROM tiles WHERE rowid = ?', (number,))
        (tile,) = asked.fetchone()
        digest = hashlib.sha256(tile).digest()
        if digest not in known:
            known[digest] = (data.tell(), len(tile))
            data.write(tile)
        _append(entries, place, *known[digest])
    return entries, len(known)


def _append(entries: list[Entry], place: int, offset: int, length: int) -> None:
    last = entries[-1] if entries else None
    if last and last.offset == offset and last.tile_id + last.run == place:
        entries[-1] = Entry(last.tile_id, offset, length, last.run + 1)
    else:
        entries.append(Entry(place, offset, length, 1))


def _sections(
    entries: Sequence[Entry], contents: int, metadata: dict[str, Any], zooms: tuple[int, int],
    size: int,
) -> tuple[bytes, ...]:  # fmt: skip
    """Return header, root directory, metadata and leaf directories."""
    root, leaves = _directories(entries)
    text = gzip.compress(json.dumps(_described(metadata)).encode(), mtime=0)
    starts = [HEADER.size]
    for section in (root, text, leaves):
        starts.append(starts[-1] + len(section))
    west, south, east, north = (float(edge) for edge in metadata['bounds'].split(','))
    header = HEADER.pack(
        MAGIC, VERSION, starts[0], len(root), starts[1], len(text), starts[2], len(leaves),
        starts[3], size, sum(entry.run for entry in entries), len(entries), contents,
        1, GZIP, NO_COMPRESSION, PNG, zooms[0], zooms[1],
        *(round(edge * DEGREES) for edge in (west, south, east, north)),
        (zooms[0] + zooms[1]) // 2, round((west + east) / 2 * DEGREES),
        round((south + north) / 2 * DEGREES),
    )  # fmt: skip
    return header, root, text, leaves


def _described(metadata: dict[str, Any]) -> dict[str, Any]:
    kept = ('name', 'description', 'attribution', 'type', 'version')
    return {name: metadata[name] for name in kept if metadata.get(name)}


def _directories(entries: Sequence[Entry]) -> tuple[bytes, bytes]:
    """Return the root directory, and the leaves that it points to where it would be too long."""
    root = _directory(entries)
    size = LEAF_ENTRIES
    leaves = b''
    while HEADER.size + len(root) > FIRST_BYTES:
        leaves, pointers = b'', []
        for start in range(0, len(entries), size):
            leaf = _directory(entries[start : start + size])
            pointers.append(Entry(entries[start].tile_id, len(leaves), len(leaf), 0))
            leaves += leaf
        root = _directory(pointers)
        size *= 2
    return root, leaves


def _directory(entries: Sequence[Entry]) -> bytes:
    """Return a directory: number, then columns of ids, runs, lengths and offsets."""
    before = [0, *(entry.tile_id for entry in entries[:-1])]
    columns = [entry.tile_id - last for entry, last in zip(entries, before, strict=True)]
    columns += [entry.run for entry in entries]
    columns += [entry.length for entry in entries]
    end = math.nan
    for entry in entries:
        # 0: right behind the entry before.
        columns.append(0 if entry.offset == end else entry.offset + 1)
        end = entry.offset + entry.length
    numbers = (len(entries), *columns)
    return gzip.compress(b''.join(part for n in numbers for part in _varint(n)), mtime=0)


def _varint(number: int) -> Iterator[bytes]:
    while number > 0x7F:
        yield bytes((number & 0x7F | 0x80,))
        number >>= 7
    yield bytes((number,))


def _join(path: Path, tiles: Path, sections: Sequence[bytes]) -> None:
    with path.open('wb') as file, tiles.open('rb') as data:
        file.write(b''.join(sections))
        shutil.copyfileobj(data, file)
