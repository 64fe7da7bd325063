# SPDX-License-Identifier: Apache-2.0
"""Base maps that the operator brings."""

import sqlite3
from pathlib import Path

import pytest
from test.console.caller import Caller
from test.console.stage import TOKEN, Stage, served

from rocsafe_console.errors import ConsoleError
from rocsafe_console.runs.base_map import BaseMap


def make_map(path: Path, kind: str = 'png') -> Path:
    """Write an MBTiles file with one tile, in the north-west of zoom 1."""
    with sqlite3.connect(path) as file:
        file.execute('CREATE TABLE metadata (name text, value text)')
        file.execute(
            'CREATE TABLE tiles (zoom_level int, tile_column int, tile_row int, tile_data blob)'
        )
        file.execute("INSERT INTO metadata VALUES ('format', ?)", (kind,))
        file.execute('INSERT INTO tiles VALUES (1, 0, 1, ?)', (b'tile',))
    file.close()
    return path


def test_rows_are_counted_from_the_north(tmp_path):
    """As web maps do; MBTiles has them from the south."""
    base = BaseMap(make_map(tmp_path / 'a.mbtiles'))
    assert (base.zooms, base.content_type) == ((1, 1), 'image/png')
    assert base.tile(1, 0, 0) == b'tile'
    assert base.tile(1, 0, 1) is None
    assert base.tile(99, 0, 0) is None


def test_what_is_no_map_is_told_in_one_line(tmp_path):
    """No file, another file, or vector tiles."""
    (tmp_path / 'text').write_text('no database')
    for path in (tmp_path / 'none', tmp_path / 'text', make_map(tmp_path / 'v', 'pbf')):
        with pytest.raises(ConsoleError, match=path.name):
            BaseMap(path)


def test_the_page_gets_its_tiles(tmp_path):
    """And a transparent one where there is none, so that nothing fails."""
    stage = Stage(tmp_path)
    stage.context.base_map = BaseMap(make_map(tmp_path / 'a.mbtiles'))
    with served(stage) as address:
        caller = Caller(address)
        assert caller.ask('/api/base/1/0/0')[0] == 401
        caller.ask('/api/token', {'token': TOKEN})
        assert caller.ask('/api/base/1/0/0')[0] == 200
        assert caller.headers['Content-Type'] == 'image/png'
        assert caller.ask('/api/base/1/1/1')[0] == 200
        caller.ask('/static/main.js', **{'Accept-Encoding': 'gzip'})
        assert caller.headers['Content-Encoding'] == 'gzip'
        etag = caller.headers['ETag']
        assert caller.ask('/static/main.js', **{'If-None-Match': etag})[0] == 304
