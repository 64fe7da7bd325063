# SPDX-License-Identifier: Apache-2.0
"""`rocsafe preflight`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.arguments.numbers import waiting_time
from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Look at the real vehicles of a scenario and at what they are to fly, as a careful pilot '
        'does, and print every check. Nothing is commanded. Exit code 1 if a check failed.'
    )
    parser = commands.add_parser('preflight', help='check real vehicles', description=text)
    parser.add_argument('scenario', type=Path, metavar='SCENARIO', help='scenario file (YAML)')
    parser.add_argument(
        '--wait',
        type=waiting_time,
        default=20.0,
        metavar='S',
        help='how long to wait for vehicles to be heard and ready (default: 20)',
    )
    parser.set_defaults(command=_preflight)


def _preflight(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.planning_commands.preflight_command import preflight

    return preflight(arguments.scenario, arguments.wait, Console())
