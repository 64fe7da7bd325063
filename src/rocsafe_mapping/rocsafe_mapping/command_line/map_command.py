# SPDX-License-Identifier: Apache-2.0
"""`map`: the map of a folder of photographs, without ROS."""

import argparse
import math
import os
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rocsafe_geo.argument import number
from rocsafe_geo.regions.area_files import read_area
from rocsafe_mapping.allocation import keep_freed_memory
from rocsafe_mapping.command_line.notes import note
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions, Shot
from rocsafe_mapping.mosaic.survey import Survey
from rocsafe_mapping.photographs.geolocation import located, read_geolocations
from rocsafe_mapping.photographs.ground_control import read_control
from rocsafe_mapping.photographs.label_images import LABELS
from rocsafe_mapping.photographs.track import read_track
from rocsafe_mapping.products.map_products import ProductOptions, write_products
from rocsafe_mapping.store.catalogue import MANIFEST, StoredShot, read_store
from rocsafe_mapping.store.photograph_files import photographs_of

EXIT_OK, EXIT_FAILED, EXIT_REFUSED = 0, 1, 2
NAME = 'mosaic'
EPILOG = """\
The folder holds drone photographs with Exif, or is an image store of ROCSAFE. Written are
mosaic.tif (cloud optimised GeoTIFF in UTM), mosaic.png with world file and mosaic.kml,
mosaic.mbtiles and mosaic.pmtiles, quality.json and quality.html; where there are label images,
labels.tif and labels.json too. Exit code 1: there is a map, but it must not be called
georeferenced; the reasons are printed.
"""


@dataclass(slots=True)
class Stopwatch:
    """Wall and processor seconds of the stages of a map."""

    costs: dict[str, dict[str, float]] = field(default_factory=dict)
    _wall_s: float = field(default_factory=time.perf_counter)
    # The first stage has what the process used before, for imports.
    _cpu_s: float = 0.0

    def lap(self, stage: str) -> None:
        """Note the time since the last stage as that of `stage`."""
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        self.costs[stage] = {
            'wall_s': round(wall_s - self._wall_s, 3),
            'cpu_s': round(cpu_s - self._cpu_s, 3),
        }
        self._wall_s, self._cpu_s = wall_s, cpu_s


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the map of a folder of photographs and return the exit code.

    Examples
    --------
    Nine photographs of a coloured field, taken from 20 m above it, as a drone writes them: fix in
    Exif, height above the ground in XMP.

    >>> from tempfile import TemporaryDirectory
    >>> import numpy as np
    >>> from PIL import Image
    >>> colours = np.random.default_rng(1).integers(0, 255, (70, 90, 3), np.uint8)
    >>> field = Image.fromarray(colours).resize((900, 700), Image.Resampling.BICUBIC)
    >>> xmp = (
    ...     b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/'
    ...     b'22-rdf-syntax-ns#"><rdf:Description xmlns:drone-dji="http://www.dji.com/drone-dji/'
    ...     b'1.0/" drone-dji:RelativeAltitude="+20.0"/></rdf:RDF></x:xmpmeta>'
    ... )
    >>> def photograph(folder, number):
    ...     left, upper = 100 * (number % 3), 80 * (number // 3)  # a pixel is 5 cm wide
    ...     tags = Image.Exif()
    ...     tags.get_ifd(0x8769)[0xA405] = 36  # focal length: width and height alike
    ...     latitude, longitude = 0.28 - 0.05 * upper / 111_290, 0.06 - 0.05 * left / 66_680
    ...     tags.get_ifd(0x8825).update({
    ...         1: 'N', 2: (53, 0, 3600 * latitude), 3: 'W', 4: (9, 0, 3600 * longitude),
    ...         5: bytes(1), 6: 80.0,
    ...     })
    ...     picture = field.crop((left, upper, left + 400, upper + 300))
    ...     picture.save(Path(folder, f'{number}.jpg'), exif=tags, xmp=xmp)
    >>> with TemporaryDirectory() as folder:
    ...     for number in range(9):
    ...         photograph(folder, number)
    ...     code = main([folder, '--only-geotiff'])  # doctest: +ELLIPSIS
    ...     sorted(path.name for path in Path(folder, 'map').iterdir())
    9 photographs, 9 placed by what they show, 0 by their fix alone
    written to ...map
    ['error.png', 'error.tif', 'mosaic.tif', 'quality.html', 'quality.json']
    >>> code
    0
    """
    options = _parser().parse_args(arguments)
    keep_freed_memory()
    try:
        return make_map(options)
    except (MappingError, ValueError, OSError) as error:
        note(f'error: {error}')
        return EXIT_REFUSED


def make_map(options: argparse.Namespace) -> int:
    """Make the map that the command line asks for.

    Raises
    ------
    MappingError
        If there is nothing to map or a file cannot be written.
    """
    watch = Stopwatch()
    watch.lap('start')
    folder = options.output or options.folder / 'map'
    shots, datum_error_m = _shots(options)
    labels = _labels_of(options, [shot.name for shot in shots])
    maker = Mapmaker(
        MapOptions(ground_resolution_m=options.resolution, max_pixels=options.max_pixels), note
    )
    maker.add_all(shots, _survey(options, datum_error_m))
    if not len(maker) or maker.frame is None:
        raise MappingError(f'{options.folder}: no photograph that can be placed')
    _require_writable(folder)
    watch.lap('read')
    region = None
    if options.region is not None:
        region = read_area(options.region).polygon(maker.frame.frame)
    wanted = ProductOptions(
        geotiff=folder / f'{NAME}.tif',
        folder=folder,
        region=region,
        with_overlays=not options.only_geotiff,
        with_tiles=not options.only_geotiff,
        labels=labels,
    )
    alignment = maker.align(watch.lap)
    document = write_products(maker, alignment, wanted, watch.lap, watch.costs)
    return _conclude(document, folder)


def _shots(options: argparse.Namespace) -> tuple[list[Shot], float]:
    """Return the photographs, and how exactly the CRS of a ``geo.txt`` is known in WGS84, metres.

    They are at the places that it says.
    """
    stored = {shot.path.name: shot for shot in shots_of(options.folder)}
    records = {name: shot.record for name, shot in stored.items()}
    datum_error_m = 0.0
    if options.geo is not None:
        places = read_geolocations(options.geo, note)
        records = located(records, places, note)
        datum_error_m = max(place.datum_error_m for place in places.values())
    shots = [
        Shot(name=name, record=records[name], read=shot.read_image)
        for name, shot in stored.items()
    ]
    return shots, datum_error_m


def _survey(options: argparse.Namespace, places_datum_error_m: float) -> Survey:
    if options.clock_offset is not None and options.track is None:
        raise MappingError('--clock-offset is that of a --track, which is missing')
    return Survey(
        control=read_control(options.gcp, note) if options.gcp is not None else (),
        track=read_track(options.track) if options.track is not None else None,
        clock_offset_s=math.nan if options.clock_offset is None else options.clock_offset,
        places_datum_error_m=places_datum_error_m,
    )


def _require_writable(folder: Path) -> None:
    """Make the folder of the map before the work; raise MappingError if it cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MappingError(f'cannot write to {folder}: {error.strerror}') from error
    if not os.access(folder, os.W_OK):
        raise MappingError(f'cannot write to {folder}: Permission denied')


def _labels_of(options: argparse.Namespace, names: Sequence[str]) -> Path | None:
    """Return the folder of label images: the one that is named, or that of an image store."""
    kept = Path(options.folder) / LABELS
    if options.labels is None:
        return kept if kept.is_dir() else None
    if not any((options.labels / f'{Path(name).stem}.png').is_file() for name in names):
        raise MappingError(f'--labels {options.labels}: has no PNG named like a photograph')
    return Path(options.labels)


def shots_of(folder: Path) -> tuple[StoredShot, ...]:
    """Return the photographs of an image store, or of any folder; each file's bytes once.

    Raises
    ------
    StoreError
        If it cannot be read.
    """
    if (folder / MANIFEST).exists():
        return read_store(folder, note)
    known: dict[str, StoredShot] = {}
    for shot in photographs_of(folder, note):
        first = known.setdefault(shot.record.sha256, shot)
        if first is not shot:
            note(f'not on the map: {shot.path.name}: the same file as {first.path.name}')
    return tuple(known.values())


def _conclude(document: Mapping[str, Any], folder: Path) -> int:
    photographs = document['photographs']
    if document['is_local']:
        sys.stdout.write('local map without scale or north: no KML, no tiles\n')
    for kind, facts in document['control'].items():
        if kind != 'points':
            sys.stdout.write(
                f'{facts["count"]} {kind} points: off by {facts["rmse_m"]:.2f} m, stated '
                f'{facts["stated_error_m"]:.2f} m\n'
            )
    sys.stdout.write(
        f'{photographs["total"]} photographs, {photographs["placed_by_features"]} placed by what '
        f'they show, {len(photographs["placed_by_gps"])} by their fix alone\n'
        f'written to {folder}\n'
    )
    for reason in document['why_not_georeferenced']:
        sys.stdout.write(f'not to be called georeferenced: {reason}\n')
    return EXIT_OK if document['is_georeferenced'] else EXIT_FAILED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe map',
        description='Make a georeferenced map of a folder of drone photographs.',
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        'folder', type=Path, metavar='FOLDER', help='folder of photographs, or an image store'
    )
    parser.add_argument(
        '-o', '--output', type=Path, metavar='DIR', help='where to write (default: FOLDER/map)'
    )
    parser.add_argument(
        '--resolution', type=float, default=0.0, metavar='M',
        help='side of a pixel in metres [that of the photographs]',
    )  # fmt: skip
    parser.add_argument(
        '--max-pixels', type=int, default=400_000_000, metavar='N',
        help='a map of more pixels gets coarser ones [400000000]',
    )  # fmt: skip
    parser.add_argument(
        '--region', type=Path, metavar='FILE',
        help='GeoJSON or KML of the region that was to be covered',
    )  # fmt: skip
    parser.add_argument(
        '--labels',
        type=Path,
        metavar='DIR',
        help='PNG label images named like the photographs: writes labels.tif too',
    )
    parser.add_argument(
        '--geo', type=Path, metavar='FILE',
        help="places of photographs, OpenDroneMap's geo.txt; they replace those of the tags",
    )  # fmt: skip
    parser.add_argument(
        '--gcp', type=Path, metavar='FILE',
        help="ground control points, OpenDroneMap's gcp_list.txt; CHK-... are check points",
    )  # fmt: skip
    parser.add_argument(
        '--track', type=Path, metavar='FILE',
        help='GPX or CSV track: places of photographs without a fix by their times',
    )  # fmt: skip
    parser.add_argument(
        '--clock-offset', type=number(-1e9, 1e9), metavar='S',
        help='time of the track less that of the camera in seconds [found]',
    )  # fmt: skip
    parser.add_argument('--only-geotiff', action='store_true', help='no picture, KML and tiles')
    return parser


if __name__ == '__main__':
    sys.exit(main())
