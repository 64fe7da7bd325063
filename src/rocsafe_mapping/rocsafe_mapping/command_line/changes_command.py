# SPDX-License-Identifier: Apache-2.0
"""`changes`: what changed between two flights, as GeoJSON."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rocsafe_geo.storage.durable import write_whole
from rocsafe_mapping.command_line.map_command import shots_of
from rocsafe_mapping.command_line.notes import note
from rocsafe_mapping.drawing.renderer import Renderer
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.mosaic.changes import (
    AFTER,
    BEFORE,
    ChangeOptions,
    change_document,
    changes,
    renamed,
)
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions, Shot
from rocsafe_mapping.products.quality import violations
from rocsafe_mapping.store.catalogue import StoredShot

EXIT_OK, EXIT_REFUSED = 0, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare two flights and return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        wanted = ChangeOptions(resolution_m=options.resolution, least_area_m2=options.least_area)
        document = compared(options.before, options.after, wanted)
        write_whole(options.output, json.dumps(document, indent=1).encode() + b'\n')
    except (MappingError, ValueError, OSError) as error:
        note(f'error: {error}')
        return EXIT_REFUSED
    areas = [feature['properties']['area_m2'] for feature in document['features']]
    sys.stdout.write(f'{len(areas)} changes, {sum(areas):.1f} m2; {options.output}\n')
    return EXIT_OK


def compared(before: Path, after: Path, wanted: ChangeOptions) -> dict[str, Any]:
    """Return what changed between the photographs of two folders.

    Raises
    ------
    MappingError
        If a folder has no photographs, or the flights do not tie to each other.
    """
    maker = Mapmaker(MapOptions(ground_resolution_m=wanted.resolution_m), note)
    maker.add_all(
        [
            Shot(
                name=prefix + shot.path.name,
                record=renamed(shot.record, prefix),
                read=shot.read_image,
            )
            for folder, prefix in ((before, BEFORE), (after, AFTER))
            for shot in _shots_of(folder)
        ]
    )
    alignment = maker.align()
    _require_tied(maker)
    for reason in violations(alignment, maker.block.state):
        note(f'not to be called georeferenced: {reason}')
    placed_photos = maker.placed_photos()
    grid = maker.grid(placed_photos)
    renderers = [
        Renderer(
            {name: placed for name, placed in placed_photos.items() if name.startswith(prefix)},
            maker.pixels,
            grid,
            maker.options.drawing,
        )
        for prefix in (BEFORE, AFTER)
    ]
    return change_document(changes(renderers[0], renderers[1], wanted), grid)


def _shots_of(folder: Path) -> tuple[StoredShot, ...]:
    """Return the photographs of a folder, at least one."""
    shots = shots_of(folder)
    if not shots:
        raise MappingError(f'{folder}: no photograph that can be placed')
    return shots


def _require_tied(maker: Mapmaker) -> None:
    """Raise MappingError unless some photographs of one flight tie to the other."""
    bridges = [
        pair
        for pair in maker.block.used_pairs
        if pair.first.startswith(BEFORE) != pair.second.startswith(BEFORE)
    ]
    if not bridges:
        raise MappingError('the flights have no ground in common that looks alike')


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe changes',
        description='Find changes between two flights: place and size of each, as GeoJSON.',
    )
    parser.add_argument(
        'before', type=Path, metavar='BEFORE', help='photographs of the first flight'
    )
    parser.add_argument(
        'after', type=Path, metavar='AFTER', help='photographs of the second flight'
    )
    parser.add_argument(
        '-o', '--output', type=Path, default=Path('changes.geojson'), metavar='FILE',
        help='GeoJSON file to write (default: changes.geojson)',
    )  # fmt: skip
    parser.add_argument(
        '--resolution',
        type=float,
        default=0.2,
        metavar='M',
        help='side of a pixel of the comparison, metres (default: 0.2)',
    )
    parser.add_argument(
        '--least-area',
        type=float,
        default=1.0,
        metavar='M2',
        help='area of the smallest change that is listed, square metres (default: 1)',
    )
    return parser


if __name__ == '__main__':
    sys.exit(main())
