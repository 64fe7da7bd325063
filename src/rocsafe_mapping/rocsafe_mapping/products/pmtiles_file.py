# SPDX-License-Identifier: Apache-2.0
"""Tiles for web maps as one file that a plain web server can serve (PMTiles, version 3)."""

import sqlite3
from pathlib import Path
from typing import IO, Any

from rocsafe_geo.storage.durable import discard_part, finish_part, part_of, sync_file
from rocsafe_mapping.errors import MappingError

DEGREES = 10_000_000
KEPT_METADATA = ('name', 'description', 'attribution', 'type', 'version')


def write_pmtiles(mbtiles: Path, path: Path) -> None:
    """Write the tiles of an MBTiles file of PNG pictures to `path`.

    Raises
    ------
    MappingError
        If they cannot be read, the file cannot be written, or the library is not installed.
    """
    part = part_of(path)
    try:
        # Opened as a URI: a missing file shall not become an empty one.
        source = sqlite3.connect(f'{mbtiles.absolute().as_uri()}?mode=ro', uri=True)
        try:
            with part.open('wb') as file:
                _copy(source, file)
        finally:
            source.close()
        sync_file(part)
        finish_part(path)
    except (OSError, sqlite3.Error, ValueError, ImportError) as error:
        discard_part(path)
        raise MappingError(f'cannot write tiles of {mbtiles} to {path}: {error}') from error


def _copy(source: sqlite3.Connection, file: IO[bytes]) -> None:
    """Write all tiles in the order of their numbers, equal ones once."""
    from pmtiles.tile import zxy_to_tileid
    from pmtiles.writer import Writer

    places = sorted(
        (zxy_to_tileid(zoom, x, (1 << zoom) - 1 - row), number)
        for number, zoom, x, row in source.execute(
            'SELECT rowid, zoom_level, tile_column, tile_row FROM tiles'
        )
    )
    if not places:
        raise ValueError('there are no tiles')
    writer = Writer(file)
    for place, number in places:
        asked = source.execute('SELECT tile_data FROM tiles WHERE rowid = ?', (number,))
        writer.write_tile(place, asked.fetchone()[0])
    metadata = dict(source.execute('SELECT name, value FROM metadata'))
    zooms = source.execute('SELECT MIN(zoom_level), MAX(zoom_level) FROM tiles').fetchone()
    kept = {name: metadata[name] for name in KEPT_METADATA if metadata.get(name)}
    writer.finalize(_header(metadata['bounds'], zooms), kept)


def _header(bounds: str, zooms: tuple[int, int]) -> dict[str, Any]:
    from pmtiles.tile import Compression, TileType

    west, south, east, north = (float(edge) for edge in bounds.split(','))
    return {
        'tile_type': TileType.PNG,
        'tile_compression': Compression.NONE,
        'min_lon_e7': round(west * DEGREES),
        'min_lat_e7': round(south * DEGREES),
        'max_lon_e7': round(east * DEGREES),
        'max_lat_e7': round(north * DEGREES),
        'center_zoom': sum(zooms) // 2,
        'center_lon_e7': round((west + east) / 2 * DEGREES),
        'center_lat_e7': round((south + north) / 2 * DEGREES),
    }
