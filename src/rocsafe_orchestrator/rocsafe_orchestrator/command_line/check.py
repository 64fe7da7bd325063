# SPDX-License-Identifier: Apache-2.0
"""`rocsafe check`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.arguments.planning_options import add_options
from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Check a scenario file and print what would fly, or check a plan.json with the '
        'independent checker of plans. Nothing is started.'
    )
    parser = commands.add_parser('check', help='check a scenario file or a plan', description=text)
    parser.add_argument(
        'file',
        type=Path,
        metavar='SCENARIO|PLAN.json',
        help='scenario (.yaml), or plan as rocsafe plan --out writes it',
    )
    add_options(parser, 'terrain')
    parser.set_defaults(command=_check)


def _check(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    if arguments.file.suffix.lower() == '.json':
        from rocsafe_orchestrator.planning_commands.check_plan_command import check_plan_file

        return check_plan_file(arguments.file, arguments.terrain, Console())
    from rocsafe_orchestrator.planning_commands.check_command import check

    return check(arguments.file, Console())
