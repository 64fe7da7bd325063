# SPDX-License-Identifier: Apache-2.0
"""Tiles in one file: what a reader of PMTiles finds is what MBTiles holds."""

import gzip
import itertools
import json
import sqlite3

import numpy as np
import pytest

from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.products import pmtiles
from rocsafe_mapping.products.pmtiles import FIRST_BYTES, HEADER, tile_id, write_pmtiles


def numbers(data):
    """Return the varints of a directory."""
    found, value, shift = [], 0, 0
    for byte in data:
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            found.append(value)
            value, shift = 0, 0
    return found


def directory(data):
    """Return (id, run, length, offset) of each entry, as the specification reads them."""
    count, *columns = numbers(gzip.decompress(data))
    ids, runs, lengths, offsets = (columns[n * count : (n + 1) * count] for n in range(4))
    entries, place, end = [], 0, 0
    for step, run, length, offset in zip(ids, runs, lengths, offsets, strict=True):
        place += step
        at = end if offset == 0 else offset - 1
        entries.append((place, run, length, at))
        end = at + length
    return entries


def tiles_of(path):
    """Return the tiles of a file by id, and its header."""
    data = path.read_bytes()
    header = HEADER.unpack_from(data)
    root, root_size, _, _, leaf, _, start, size = header[2:10]
    assert start + size == len(data)
    assert root + root_size <= FIRST_BYTES
    entries, waiting = [], directory(data[root : root + root_size])
    for place, run, length, offset in waiting:
        if run:
            entries.append((place, run, length, offset))
        else:
            entries += directory(data[leaf + offset : leaf + offset + length])
    return {
        place + n: data[start + offset : start + offset + length]
        for place, run, length, offset in entries
        for n in range(run)
    }, header


def mbtiles(path, tiles):
    """Write tiles (zoom, x, y from the north) to an MBTiles file."""
    with sqlite3.connect(path) as file:
        file.execute('CREATE TABLE metadata (name TEXT, value TEXT)')
        file.execute('CREATE TABLE tiles (zoom_level, tile_column, tile_row, tile_data)')
        values = {'name': 'mosaic', 'bounds': '-9.1,53.2,-9.0,53.3'}
        file.executemany('INSERT INTO metadata VALUES (?, ?)', values.items())
        file.executemany(
            'INSERT INTO tiles VALUES (?, ?, ?, ?)',
            [(z, x, (1 << z) - 1 - y, data) for (z, x, y), data in tiles.items()],
        )
    file.close()
    return path


def test_tiles_are_numbered_as_the_specification_does():
    """Examples of the specification and of its reference implementation."""
    places = [(0, 0, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0), (2, 0, 0), (12, 3423, 1763)]
    assert [tile_id(*place) for place in places] == [0, 1, 2, 3, 4, 5, 19078479]


def test_every_tile_has_a_number_of_its_own():
    """A zoom's tiles fill their range, and each is next to the one before."""
    places = {tile_id(4, x, y): (x, y) for x in range(16) for y in range(16)}
    assert sorted(places) == list(range((4**4 - 1) // 3, (4**5 - 1) // 3))
    path = [places[n] for n in sorted(places)]
    assert {abs(a - c) + abs(b - d) for (a, b), (c, d) in itertools.pairwise(path)} == {1}


def test_a_reader_finds_the_tiles(tmp_path):
    """Each under its number, equal ones stored once."""
    tiles = {(2, x, y): f'tile {x} {min(y, 2)}'.encode() for x in range(4) for y in range(4)}
    write_pmtiles(mbtiles(tmp_path / 'm.mbtiles', tiles), tmp_path / 'm.pmtiles')
    found, header = tiles_of(tmp_path / 'm.pmtiles')
    assert found == {tile_id(*place): data for place, data in tiles.items()}
    assert header[:2] == (b'PMTiles', 3)
    assert header[10] == 16
    assert header[12] == 12
    assert header[16:22] == (2, 2, 2, -91_000_000, 532_000_000, -90_000_000)


def test_many_tiles_go_to_leaf_directories(tmp_path, monkeypatch):
    """Header and root directory stay within the bytes that a reader asks for first."""
    monkeypatch.setattr(pmtiles, 'FIRST_BYTES', 300)
    monkeypatch.setattr(pmtiles, 'LEAF_ENTRIES', 8)
    sizes = np.random.default_rng(1).integers(8, 400, (32, 32)).tolist()
    tiles = {(5, x, y): bytes([x, y]) * sizes[x][y] for x in range(32) for y in range(32)}
    write_pmtiles(mbtiles(tmp_path / 'm.mbtiles', tiles), tmp_path / 'm.pmtiles')
    found, header = tiles_of(tmp_path / 'm.pmtiles')
    assert header[2] + header[3] <= 300
    assert header[7] > 0
    assert found == {tile_id(*place): data for place, data in tiles.items()}


def test_metadata_is_kept(tmp_path):
    """The map's name."""
    write_pmtiles(mbtiles(tmp_path / 'm.mbtiles', {(0, 0, 0): b'x'}), tmp_path / 'm.pmtiles')
    data = (tmp_path / 'm.pmtiles').read_bytes()
    offset, size = HEADER.unpack_from(data)[4:6]
    assert json.loads(gzip.decompress(data[offset : offset + size])) == {'name': 'mosaic'}


def test_no_tiles_are_an_error(tmp_path):
    """Neither an empty file nor a missing one makes tiles, and none is left behind."""
    empty = mbtiles(tmp_path / 'm.mbtiles', {})
    for source in (empty, tmp_path / 'missing.mbtiles'):
        with pytest.raises(MappingError, match=r'm\.mbtiles|unable to open'):
            write_pmtiles(source, tmp_path / 'm.pmtiles')
    assert [path.name for path in tmp_path.iterdir()] == ['m.mbtiles']
