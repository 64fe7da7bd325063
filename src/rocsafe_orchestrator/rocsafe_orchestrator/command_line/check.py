# SPDX-License-Identifier: Apache-2.0
"""`rocsafe check`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = 'Check a scenario file and print what would fly. Nothing is started.'
    parser = commands.add_parser('check', help='check a scenario file', description=text)
    parser.add_argument('scenario', type=Path, metavar='SCENARIO', help='scenario file (YAML)')
    parser.set_defaults(command=_check)


def _check(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.command_line.check_command import check

    return check(arguments.scenario, Console())
