# SPDX-License-Identifier: Apache-2.0
"""`rocsafe replan`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Plan the rest of a survey anew: a vehicle is lost, there is more to photograph, a zone '
        'is closed. The vehicles that are left go on from where they are, with what is left in '
        'their batteries. Nothing flies.'
    )
    parser = commands.add_parser('replan', help='plan the rest of a survey', description=text)
    parser.add_argument(
        'plan', type=Path, metavar='PLAN.json', help='as rocsafe plan --out writes it'
    )
    parser.add_argument(
        '--visited',
        default='',
        metavar='IDS',
        help='viewpoints that are photographed, e.g. 0-20,33',
    )
    parser.add_argument(
        '--lost', action='append', default=[], metavar='NAME', help='a vehicle; may be repeated'
    )
    parser.add_argument(
        '--at',
        nargs=4,
        action='append',
        default=[],
        metavar=('NAME', 'LAT', 'LON', 'USED_S'),
        help='where a vehicle is in the air, and since when it flies on its battery; may be '
        'repeated; the others stand at home',
    )
    parser.add_argument(
        '--add',
        nargs=2,
        type=float,
        action='append',
        default=[],
        metavar=('LAT', 'LON'),
        help='a place to photograph too; may be repeated',
    )
    parser.add_argument(
        '--exclude',
        type=Path,
        action='append',
        default=[],
        metavar='REGION',
        help='region file that no leg crosses any more; may be repeated',
    )
    parser.add_argument(
        '--terrain',
        type=Path,
        metavar='DEM.tif',
        help='heights of the ground, of a plan that follows them',
    )
    parser.add_argument(
        '--out', type=Path, metavar='DIR', help="also write the plan's files there"
    )
    parser.set_defaults(command=_replan)


def _replan(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.command_line.replan_command import ReplanRequest, replan

    request = ReplanRequest(
        plan=arguments.plan,
        visited=arguments.visited,
        lost=tuple(arguments.lost),
        aloft=tuple(tuple(words) for words in arguments.at),
        new_places=tuple(tuple(place) for place in arguments.add),
        exclusions=tuple(arguments.exclude),
        folder=arguments.out,
        terrain=arguments.terrain,
    )
    return replan(request, Console())
