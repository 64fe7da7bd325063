# SPDX-License-Identifier: Apache-2.0
"""A base map that the operator has brought: raster tiles (MBTiles, PMTiles) or a GeoTIFF."""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Protocol

from rocsafe_console.errors import ConsoleError
from rocsafe_console.runs.raster_map import RasterMap

TYPES = {'png': 'image/png', 'jpg': 'image/jpeg', 'jpeg': 'image/jpeg', 'webp': 'image/webp'}
DEEPEST = 30
TIFF_HEADS = (b'II*\0', b'MM\0*', b'II+\0', b'MM\0+')
PMTILES_HEAD = b'PMTiles\3'
SQLITE_HEAD = b'SQLite format 3\0'


class BaseMap(Protocol):
    """Tiles of Web Mercator.

    Attributes
    ----------
    content_type
        Of all tiles.
    zooms
        Least and greatest zoom that has tiles.
    attribution
        Words of the owner of the map; may be empty.
    bounds
        South, west, north and east in degrees; None: not told.
    """

    content_type: str
    zooms: tuple[int, int]
    attribution: str
    bounds: tuple[float, float, float, float] | None

    def tile(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile, None if there is none; rows count from the north."""


def open_base_map(path: Path) -> BaseMap:
    """Return the base map in a file; its first bytes tell its format.

    Raises
    ------
    ConsoleError
        If it cannot be read, or is none of the known formats.
    """
    try:
        with path.open('rb') as file:
            head = file.read(len(SQLITE_HEAD))
    except OSError as error:
        raise ConsoleError(f'{path}: {error.strerror}') from error
    kinds: tuple[tuple[tuple[bytes, ...], Callable[[Path], BaseMap]], ...] = (
        ((SQLITE_HEAD,), MbTiles),
        ((PMTILES_HEAD,), PmTiles),
        (TIFF_HEADS, RasterMap),
    )
    for heads, kind in kinds:
        if head.startswith(heads):
            return kind(path)
    raise ConsoleError(f'{path}: is no MBTiles, PMTiles (version 3) or GeoTIFF file')


class MbTiles:
    """The tiles of an MBTiles file (version 1.3).

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
        self.bounds = _bounds_of(str(facts.get('bounds', '')))

    def tile(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile, None if there is none or the file is damaged there."""
        if not 0 <= zoom <= DEEPEST or max(column, row) >= 2**zoom:
            return None
        # MBTiles counts rows from the south.
        place = (zoom, column, 2**zoom - 1 - row)
        try:
            with self._opened() as file:
                found = file.execute(
                    'SELECT tile_data FROM tiles '
                    'WHERE zoom_level = ? AND tile_column = ? AND tile_row = ?',
                    place,
                ).fetchone()
        except sqlite3.Error:
            return None
        return found[0] if found is not None and isinstance(found[0], bytes) else None

    @contextmanager
    def _opened(self) -> Iterator[sqlite3.Connection]:
        uri = f'{self._path.resolve().as_uri()}?mode=ro'
        with closing(sqlite3.connect(uri, uri=True)) as file:
            yield file


class PmTiles:
    """The tiles of a PMTiles file (version 3).

    Raises
    ------
    ConsoleError
        If it is damaged, or its tiles are no pictures.
    """

    def __init__(self, path: Path) -> None:
        try:
            # Imported on use: set-up brings it where it can.
            from pmtiles.reader import Reader
            from pmtiles.tile import Compression, TileType
        except ImportError as error:
            raise ConsoleError(f'{path}: needs the Python package pmtiles') from error

        self._path = path
        self._size = path.stat().st_size
        self._reader = Reader(self._bytes)
        kinds = {
            TileType.PNG: 'image/png', TileType.JPEG: 'image/jpeg', TileType.WEBP: 'image/webp'
        }  # fmt: skip
        try:
            header = self._reader.header()
            metadata = self._reader.metadata()
        except Exception as error:
            # The package tells a damaged file by whatever its bytes lead to.
            raise ConsoleError(f'{path}: is a damaged PMTiles file: {error}') from error
        kind = header['tile_type']
        if kind not in kinds or header['tile_compression'] not in (
            Compression.NONE, Compression.UNKNOWN,
        ):  # fmt: skip
            raise ConsoleError(f'{path}: has {kind.name} tiles: must be pictures')
        self.content_type = kinds[kind]
        self.zooms = (int(header['min_zoom']), int(header['max_zoom']))
        self.attribution = str(metadata.get('attribution', ''))
        south, west = header['min_lat_e7'] / 1e7, header['min_lon_e7'] / 1e7
        north, east = header['max_lat_e7'] / 1e7, header['max_lon_e7'] / 1e7
        self.bounds = (south, west, north, east) if south < north and west < east else None

    def tile(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile, None if there is none or the file is damaged there."""
        if not 0 <= zoom <= DEEPEST or max(column, row) >= 2**zoom:
            return None
        try:
            found = self._reader.get(zoom, column, row)
        except Exception:  # noqa: BLE001 - see the constructor
            return None
        return None if found is None else bytes(found)

    def _bytes(self, offset: int, length: int) -> bytes:
        """Return a range of the file; what its directories name outside it is refused."""
        if offset < 0 or length < 0 or offset + length > self._size:
            raise ValueError(f'bytes {offset} to {offset + length} are not in the file')
        with self._path.open('rb') as file:
            file.seek(offset)
            return file.read(length)


def _bounds_of(text: str) -> tuple[float, float, float, float] | None:
    """Return south, west, north, east of MBTiles' west, south, east, north; None: not told."""
    try:
        west, south, east, north = (float(part) for part in text.split(','))
    except ValueError:
        return None
    return (south, west, north, east) if south < north and west < east else None
