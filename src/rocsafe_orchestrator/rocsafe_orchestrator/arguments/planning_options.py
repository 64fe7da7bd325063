# SPDX-License-Identifier: Apache-2.0
"""Options of the commands that plan; each is defined once and shared by the commands."""

import argparse
from pathlib import Path
from typing import Any

from rocsafe_orchestrator.arguments.numbers import (
    budget,
    count,
    height,
    metres,
    overlap,
    seconds,
    seed,
    vehicle_speed,
    viewpoint_count,
    wind,
)
from rocsafe_planner.plan.survey_options import (
    GRIDS,
    METHODS,
    OBJECTIVES,
    SEPARATIONS,
    SPACING_RULES,
    USUAL_VIEWPOINTS_LIMIT,
)

_AGAIN: dict[str, Any] = {'action': 'append', 'default': []}
# Arguments of argparse, by the name of the option.
_OPTIONS: dict[str, dict[str, Any]] = {
    'out': {
        'type': Path,
        'metavar': 'DIR',
        'help': "also write the plan's files: JSON, GeoJSON, KML, GPX, a table, pictures, and "
        'each flight for QGroundControl, MAVLink and DJI',
    },
    'exclude': {
        **_AGAIN,
        'type': Path,
        'metavar': 'REGION',
        'help': 'region file of an exclusion zone, in addition to those known; may be repeated',
    },
    'terrain': {
        'type': Path,
        'metavar': 'DEM.tif',
        'help': 'GeoTIFF of terrain heights; the flights follow the terrain',
    },
    'budget': {
        'type': budget,
        'metavar': 'S',
        'help': 'time to improve the plan, seconds; 0: a fixed number of steps, which may take '
        "longer than a short budget (default: the scenario's, or 0)",
    },
    'method': {
        'default': '',
        'help': f'{", ".join(METHODS[:-1])} or {METHODS[-1]} (default: {METHODS[0]})',
    },
    'drones': {
        'type': count,
        'default': 3,
        'metavar': 'N',
        'help': 'number of vehicles (default: 3)',
    },
    'height': {
        'type': height,
        'default': 32.0,
        'metavar': 'M',
        'help': 'height of flight above the ground, metres (default: 32)',
    },
    'home': {
        'type': float,
        'nargs': 2,
        'metavar': ('LAT', 'LON'),
        'help': "place where all vehicles take off and land (default: the region's first corner)",
    },
    'overlap': {
        'type': overlap,
        'metavar': 'Y',
        'help': 'overlap of neighbouring photographs, 0 to 0.95 (default: 0.2)',
    },
    'front-overlap': {
        'type': overlap,
        'metavar': 'Y',
        'help': 'overlap of successive photographs along a line (default: as --overlap)',
    },
    'spacing-rule': {
        'choices': tuple(SPACING_RULES),
        'help': 'definition of the overlap: intersection over union, or part of the image side',
    },
    'grid': {
        'choices': GRIDS,
        'help': 'orientation of the grid of viewpoints',
    },
    'max-viewpoints': {
        'type': viewpoint_count,
        'metavar': 'N',
        'help': f'refuse a survey that needs more (default: {USUAL_VIEWPOINTS_LIMIT})',
    },
    'objective': {'choices': OBJECTIVES, 'help': 'quantity to minimise'},
    'clearance': {
        'type': metres,
        'metavar': 'M',
        'help': 'least distance of the routes to exclusion zones, metres',
    },
    'max-height': {
        'type': metres,
        'metavar': 'M',
        'help': 'greatest height above the ground of anything that is flown, metres',
    },
    'wind': {
        'type': wind,
        'nargs': 2,
        'metavar': ('EAST', 'NORTH'),
        'help': 'wind velocity towards east and north, m/s',
    },
    'separation': {
        'type': metres,
        'metavar': 'M',
        'help': 'least distance between two vehicles in the air, metres; 0: none is kept',
    },
    'separation-by': {
        'choices': SEPARATIONS,
        'help': 'means of separation: waits alone, or different heights, too',
    },
    'terrain-clearance': {
        'type': metres,
        'metavar': 'M',
        'help': 'least height of the routes above the terrain, metres',
    },
    'seed': {'type': seed, 'metavar': 'N', 'help': 'seed of the random numbers of the search'},
    'speed': {'type': vehicle_speed, 'metavar': 'M/S', 'help': 'cruise speed, m/s'},
    'hover': {
        'type': seconds,
        'metavar': 'S',
        'help': 'hover time at each viewpoint, seconds; 0: no stop',
    },
    'endurance': {
        'type': seconds,
        'metavar': 'S',
        'help': 'flight time of a full battery, seconds; a reserve of 10 %% is not used',
    },
    'swap': {
        'type': seconds,
        'metavar': 'S',
        'help': 'time to change batteries at home, seconds',
    },
    'open': {
        'action': 'store_true',
        'default': None,
        'help': 'land at the last viewpoint instead of at home',
    },
    'visited': {
        'default': '',
        'metavar': 'IDS',
        'help': 'viewpoints that have been photographed, e.g. 0-20,33',
    },
    'lost': {**_AGAIN, 'metavar': 'NAME', 'help': 'name of a lost vehicle; may be repeated'},
    'at': {
        **_AGAIN,
        'nargs': 4,
        'metavar': ('NAME', 'LAT', 'LON', 'USED_S'),
        'help': 'position of a vehicle in the air, and seconds for which it has used its battery; '
        'may be repeated; the other vehicles are at home',
    },
    'add': {
        **_AGAIN,
        'nargs': 2,
        'type': float,
        'metavar': ('LAT', 'LON'),
        'help': 'an additional place to photograph; may be repeated',
    },
}
_ALIASES = {'drones': ('--vehicles',)}


def add_options(parser: argparse._ActionsContainer, *names: str) -> None:
    """Add options to a command, or to a group of its options.

    Parameters
    ----------
    parser
        Of the command, or the group.
    names
        Of the options, without dashes.
    """
    for name in names:
        flags = (f'--{name}', *_ALIASES.get(name, ()))
        parser.add_argument(*flags, dest=name.replace('-', '_'), **_OPTIONS[name])
