# SPDX-License-Identifier: Apache-2.0
"""`rocsafe join`."""

import argparse
import os
from pathlib import Path

from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Run the vehicles of this host for a mission that rocsafe run flies from another. Waits '
        'for it for ten minutes, ends with it, and goes on without it when it is lost.'
    )
    parser = commands.add_parser('join', help='run vehicles of a mission here', description=text)
    parser.add_argument('scenario', type=Path, metavar='SCENARIO', help='the same file as there')
    parser.add_argument(
        '--host', required=True, metavar='NAME', help='which of the hosts of the scenario this is'
    )
    parser.add_argument(
        '--out',
        type=Path,
        default=Path('runs'),
        metavar='DIR',
        help='where to make the run directory (default: runs)',
    )
    parser.set_defaults(command=_join)


def _join(arguments: argparse.Namespace) -> int:
    # Before numpy is loaded: nodes cannot be forked from a process with threads.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    from rich.console import Console

    from rocsafe_orchestrator.mission_commands.join_command import join_scenario

    return join_scenario(arguments.scenario, arguments.host, arguments.out, Console())
