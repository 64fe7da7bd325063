# SPDX-License-Identifier: Apache-2.0
"""Arguments of the command `ground`."""

import argparse
import dataclasses
import math
import re
from collections.abc import Sequence
from pathlib import Path

from rocsafe_geo.argument import number
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import DEFAULT_TURN_BACK_USVH, DriveRequest

DEFAULT_CELL_M = 0.5
PLACE_OPTIONS = ('--from', '--to')
SOUTHERN = re.compile(r'-[0-9.]+,')
EPILOG = """\
The folder is a run directory, or has at least mosaic.tif and dose_map.tif. Ground that was not
seen is not free; colours do not tell a grey roof from a road: name such places by --keep-out.

exit codes: 0 there is a route; 1 there is none, with the reason; 2 wrong arguments, or no map
"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = argparse.ArgumentParser(
        prog='rocsafe ground',
        description='Plan the fastest drive to evidence points and back within a budget of dose,\n'
        'on the map and the dose rates of a survey.',
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    found.add_argument(
        'folder', type=Path, metavar='RUN_OR_MAP_DIR', help='folder of a run or of its map'
    )
    _add_task(found)
    _add_vehicle(found.add_argument_group('vehicle'))
    _add_map(found.add_argument_group('map'))
    found.add_argument(
        '--out',
        type=Path,
        metavar='DIR',
        help='folder for the files (default: RUN_OR_MAP_DIR/ground)',
    )
    found.add_argument('--json', action='store_true', help='print JSON instead of a table')
    return found


def _add_task(found: argparse.ArgumentParser) -> None:
    found.add_argument(
        '--from',
        dest='start',
        required=True,
        metavar='LAT,LON',
        help='where the vehicle stands and returns to',
    )
    found.add_argument(
        '--to', required=True, action='append', metavar='EVIDENCE',
        help='LAT,LON, a GeoJSON file of points, or a word: sources, releases (of gas), marks (of '
        'operators), or with --labels objects (drums, flasks, wagons); may be repeated',
    )  # fmt: skip
    found.add_argument(
        '--dose-budget', required=True, type=number(1e-6, 1e12), metavar='USV',
        help='largest dose of the whole drive, uSv',
    )  # fmt: skip
    found.add_argument(
        '--load-budget', type=number(1e-9, 1e9), default=math.inf, metavar='TIMES',
        help='largest toxic load of the gas that was found, by its upper 95 %%, times that of its '
        'level 2 (default: not limited)',
    )  # fmt: skip
    found.add_argument(
        '--turn-back', type=number(1e-3, 1e9), default=DEFAULT_TURN_BACK_USVH,
        metavar='USVH',
        help='no place above this dose rate is entered, uSv/h '
        f'(default: {DEFAULT_TURN_BACK_USVH:g})',
    )  # fmt: skip
    found.add_argument(
        '--turn-back-ppm', type=number(1e-9, 1e6), default=math.inf, metavar='PPM',
        help='no place above this concentration of the gas that was found, by its upper 95 %%, is '
        'entered (default: not limited)',
    )  # fmt: skip
    options = {field.name: field.default for field in dataclasses.fields(DriveRequest)}
    found.add_argument(
        '--confidence', type=number(0.5, 0.999), default=options['confidence'],
        metavar='P',
        help=f'probability that the budget is kept (default: {options["confidence"]:g})',
    )  # fmt: skip


def _add_vehicle(group: argparse._ArgumentGroup) -> None:
    known = GroundVehicle()
    rows = (
        ('width', 'width_m', 0.1, 10.0, 'M', 'width of the vehicle, metres'),
        ('margin', 'margin_m', 0.0, 10.0, 'M', 'distance from obstacles, metres'),
        ('road-speed', 'road_mps', 0.01, 30.0, 'MPS', 'speed on hard ground, m/s'),
        ('grass-speed', 'grass_mps', 0.01, 30.0, 'MPS', 'speed on grass, m/s'),
        ('rough-speed', 'rough_mps', 0.01, 30.0, 'MPS', 'speed on bare soil, m/s'),
        ('slope', 'largest_slope_deg', 0.0, 60.0, 'DEG', 'largest slope, degrees'),
        ('step', 'largest_step_m', 0.0, 5.0, 'M', 'highest step, metres'),
        ('endurance', 'endurance_s', 1.0, 1e6, 'S', 'driving time on the battery, seconds'),
    )
    for option, name, low, high, unit, text in rows:
        default = getattr(known, name)
        group.add_argument(
            f'--{option}', dest=name, type=number(low, high), default=default,
            metavar=unit, help=f'{text} (default: {default:g})',
        )  # fmt: skip


def _add_map(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        '--cell', type=number(0.05, 100.0), default=DEFAULT_CELL_M, metavar='M',
        help=f'side of a cell, metres (default: {DEFAULT_CELL_M:g})',
    )  # fmt: skip
    group.add_argument('--dose-map', type=Path, metavar='FILE', help='GeoTIFF of dose rates')
    group.add_argument('--sources', type=Path, metavar='FILE', help='sources.json of a run')
    group.add_argument(
        '--labels',
        type=Path,
        metavar='FILE',
        help='classes of the ground and things (GeoTIFF, names in the .json beside it), which '
        'count instead of colours',
    )
    group.add_argument('--terrain', type=Path, metavar='FILE', help='elevation model (GeoTIFF)')
    group.add_argument(
        '--keep-out', type=Path, action='append', default=[], metavar='FILE',
        help='zones not to be entered: GeoJSON, KML; may be repeated',
    )  # fmt: skip


def joined(words: Sequence[str]) -> list[str]:
    """Return words of a command line in which southern places are no options.

    ``--from -33.9,18.4`` becomes ``--from=-33.9,18.4``: argparse takes for an option what begins
    with a dash and is no plain number.
    """
    found: list[str] = []
    for word in words:
        if found and found[-1] in PLACE_OPTIONS and SOUTHERN.match(word):
            found[-1] += f'={word}'
        else:
            found.append(word)
    return found
