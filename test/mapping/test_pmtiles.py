# SPDX-License-Identifier: Apache-2.0
"""Tiles in one file: what a reader of PMTiles finds is what MBTiles holds."""

import sqlite3

import pytest
from pmtiles.reader import MmapSource, Reader, all_tiles

from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.products.pmtiles_file import write_pmtiles


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


def test_a_reader_finds_the_tiles(tmp_path):
    """Each at its place, equal ones stored once, with the map's name and bounds."""
    tiles = {(2, x, y): f'tile {x} {min(y, 2)}'.encode() for x in range(4) for y in range(4)}
    write_pmtiles(mbtiles(tmp_path / 'm.mbtiles', tiles), tmp_path / 'm.pmtiles')
    with (tmp_path / 'm.pmtiles').open('rb') as file:
        source = MmapSource(file)
        assert dict(all_tiles(source)) == tiles
        header, metadata = Reader(source).header(), Reader(source).metadata()
    assert (header['addressed_tiles_count'], header['tile_contents_count']) == (16, 12)
    assert (header['min_zoom'], header['max_zoom'], header['clustered']) == (2, 2, True)
    assert (header['min_lon_e7'], header['max_lat_e7']) == (-91_000_000, 533_000_000)
    assert metadata == {'name': 'mosaic'}


def test_no_tiles_are_an_error(tmp_path):
    """Neither an empty file nor a missing one makes tiles, and none is left behind."""
    empty = mbtiles(tmp_path / 'm.mbtiles', {})
    for source in (empty, tmp_path / 'missing.mbtiles'):
        with pytest.raises(MappingError, match=source.name):
            write_pmtiles(source, tmp_path / 'm.pmtiles')
    assert [path.name for path in tmp_path.iterdir()] == ['m.mbtiles']
