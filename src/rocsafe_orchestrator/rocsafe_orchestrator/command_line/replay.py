# SPDX-License-Identifier: Apache-2.0
"""`rocsafe replay`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.command_line import Commands

DESCRIPTION = """\
Feed the recorded readings and the stored photographs of a run to the localizer and the mosaic
again, as fast as they take them, and make the products in a run directory of its own.
"""


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    parser = commands.add_parser(
        'replay', help='localize and map a recorded run again', description=DESCRIPTION
    )
    parser.add_argument('run', type=Path, metavar='RUN_DIR', help='run directory')
    parser.add_argument(
        '--out', type=Path, metavar='DIR', help='folder for the new one (default: beside RUN_DIR)'
    )
    parser.set_defaults(command=_replay)


def _replay(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.mission_commands.replay_command import replay

    return replay(arguments.run, arguments.out, Console())
