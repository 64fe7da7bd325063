# SPDX-License-Identifier: Apache-2.0
"""`rocsafe replan`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.arguments.planning_options import add_options
from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Plan the rest of a survey anew: a vehicle is lost, there is more to photograph, a zone '
        'is closed. The vehicles that are left go on from where they are, with what is left in '
        'their batteries. Nothing flies.'
    )
    parser = commands.add_parser(
        'replan',
        help='plan the rest of a survey',
        description=text,
        usage='%(prog)s [options] PLAN.json',
    )
    parser.add_argument(
        'plan', type=Path, metavar='PLAN.json', help='as rocsafe plan --out writes it'
    )
    add_options(parser, 'visited', 'lost', 'at', 'add', 'exclude', 'terrain', 'out')
    parser.set_defaults(command=_replan)


def _replan(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.planning_commands.replan_command import ReplanRequest, replan

    request = ReplanRequest(
        plan=arguments.plan,
        visited=arguments.visited,
        lost=tuple(arguments.lost),
        aloft=tuple(tuple(words) for words in arguments.at),
        new_places=tuple((latitude, longitude) for latitude, longitude in arguments.add),
        exclusions=tuple(arguments.exclude),
        folder=arguments.out,
        terrain=arguments.terrain,
    )
    return replan(request, Console())
