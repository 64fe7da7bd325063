# SPDX-License-Identifier: Apache-2.0
"""A base map that the operator has brought: raster tiles in an MBTiles file (version 1.3)."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from rocsafe_console.errors import ConsoleError

TYPES = {'png': 'image/png', 'jpg': 'image/jpeg', 'jpeg': 'image/jpeg', 'webp': 'image/webp'}
DEEPEST = 30


class BaseMap:
    """The tiles of an MBTiles file.

    Raises
    ------
    ConsoleError
        If it is no MBTiles file of raster tiles.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            with self._opened() as file:
                facts: dict[str, Any] = dict(file.execute('SELECT name, value FROM metadata'))
                zooms = file.execute('SELECT min(zoom_level), max(zoom_level) FROM tiles')
                least, most = zooms.fetchone()
        except sqlite3.Error as error:
            raise ConsoleError(f'{path}: is no MBTiles file: {error}') from error
        kind = facts.get('format', '')
        if kind not in TYPES or least is None:
            known = ', '.join(sorted(TYPES))
            raise ConsoleError(f'{path}: its format is {kind!r}: must be tiles of {known}')
        self.content_type = TYPES[kind]
        self.zooms = (int(least), int(most))
        self.attribution = str(facts.get('attribution', ''))

    def tile(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile, None if there is none; rows count from the north."""
        if not 0 <= zoom <= DEEPEST:
            return None
        # MBTiles counts rows from the south.
        place = (zoom, column, 2**zoom - 1 - row)
        with self._opened() as file:
            found = file.execute(
                'SELECT tile_data FROM tiles '
                'WHERE zoom_level = ? AND tile_column = ? AND tile_row = ?',
                place,
            ).fetchone()
        return None if found is None else bytes(found[0])

    @contextmanager
    def _opened(self) -> Iterator[sqlite3.Connection]:
        uri = f'{self._path.resolve().as_uri()}?mode=ro'
        with closing(sqlite3.connect(uri, uri=True)) as file:
            yield file
