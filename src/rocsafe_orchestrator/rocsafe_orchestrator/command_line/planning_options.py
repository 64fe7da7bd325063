# SPDX-License-Identifier: Apache-2.0
"""Options of the commands that plan: each is said once, and taken by the commands that want it."""

import argparse
from pathlib import Path
from typing import Any

from rocsafe_orchestrator.command_line.numbers import (
    budget,
    count,
    height,
    metres,
    overlap,
    seconds,
    seed,
    vehicle_speed,
    wind,
)
from rocsafe_planner.plan.survey_options import (
    GRIDS,
    METHODS,
    OBJECTIVES,
    SEPARATIONS,
    SPACING_RULES,
)

_AGAIN: dict[str, Any] = {'action': 'append', 'default': []}
# By name: what argparse is told.
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
        'help': 'region file that no leg crosses, besides those known; may be repeated',
    },
    'terrain': {
        'type': Path,
        'metavar': 'DEM.tif',
        'help': 'GeoTIFF of heights of the ground, which the flights follow',
    },
    'budget': {
        'type': budget,
        'metavar': 'S',
        'help': "seconds that may be used to improve the plan (default: the scenario's, or none)",
    },
    'method': {
        'default': '',
        'help': f'{", ".join(METHODS[:-1])} or {METHODS[-1]} (default: {METHODS[0]})',
    },
    'drones': {
        'type': count,
        'default': 3,
        'metavar': 'N',
        'help': 'how many fly (default: 3); also --vehicles',
    },
    'height': {
        'type': height,
        'default': 32.0,
        'metavar': 'M',
        'help': 'metres above the ground (default: 32)',
    },
    'home': {
        'type': float,
        'nargs': 2,
        'metavar': ('LAT', 'LON'),
        'help': "where all take off and land (default: the region's first corner)",
    },
    'overlap': {
        'type': overlap,
        'metavar': 'Y',
        'help': 'of neighbouring photographs, 0 to 0.95 (default: 0.2)',
    },
    'front-overlap': {
        'type': overlap,
        'metavar': 'Y',
        'help': 'of those that follow each other in the direction of flight (default: the same)',
    },
    'spacing-rule': {'choices': tuple(SPACING_RULES), 'help': 'what an overlap is a fraction of'},
    'grid': {'choices': GRIDS, 'help': 'its angle'},
    'objective': {'choices': OBJECTIVES, 'help': 'what is to be small'},
    'clearance': {'type': metres, 'metavar': 'M', 'help': 'that legs keep from exclusions'},
    'wind': {
        'type': wind,
        'nargs': 2,
        'metavar': ('EAST', 'NORTH'),
        'help': 'm/s that the air moves towards',
    },
    'separation': {
        'type': metres,
        'metavar': 'M',
        'help': 'least distance of two vehicles in the air',
    },
    'separation-by': {
        'choices': SEPARATIONS,
        'help': 'how it is kept: take-offs are delayed, or vehicles fly at unlike heights',
    },
    'terrain-clearance': {
        'type': metres,
        'metavar': 'M',
        'help': 'that legs keep above the terrain',
    },
    'seed': {'type': seed, 'metavar': 'N', 'help': 'of the search'},
    'speed': {'type': vehicle_speed, 'metavar': 'M/S', 'help': 'at which they cruise'},
    'hover': {
        'type': seconds,
        'metavar': 'S',
        'help': 'that they stand at each viewpoint; 0: they pass it',
    },
    'endurance': {
        'type': seconds,
        'metavar': 'S',
        'help': 'flight time on a full battery, of which the reserve (10 %%) is not used',
    },
    'swap': {
        'type': seconds,
        'metavar': 'S',
        'help': 'batteries are changed at home in so many seconds',
    },
    'open': {
        'action': 'store_true',
        'default': None,
        'help': 'each lands at its last viewpoint',
    },
    'visited': {
        'default': '',
        'metavar': 'IDS',
        'help': 'viewpoints that are photographed, e.g. 0-20,33',
    },
    'lost': {**_AGAIN, 'metavar': 'NAME', 'help': 'a vehicle; may be repeated'},
    'at': {
        **_AGAIN,
        'nargs': 4,
        'metavar': ('NAME', 'LAT', 'LON', 'USED_S'),
        'help': 'where a vehicle is in the air, and for how long it has used its battery; may be '
        'repeated; the others stand at home',
    },
    'add': {
        **_AGAIN,
        'nargs': 2,
        'type': float,
        'metavar': ('LAT', 'LON'),
        'help': 'a place to photograph too; may be repeated',
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
