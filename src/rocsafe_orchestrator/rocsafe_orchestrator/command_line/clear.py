# SPDX-License-Identifier: Apache-2.0
"""`rocsafe clear`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Note that a real vehicle that may be contaminated was checked and is clean: it may fly '
        'again. Until then `rocsafe run` refuses it.'
    )
    parser = commands.add_parser('clear', help='note that a vehicle is clean', description=text)
    parser.add_argument('vehicle', metavar='VEHICLE', help='name of the vehicle, e.g. rav1')
    parser.add_argument(
        '--out',
        type=Path,
        default=Path('runs'),
        metavar='DIR',
        help='where its run directories are (default: runs)',
    )
    parser.set_defaults(command=_clear)


def _clear(arguments: argparse.Namespace) -> int:
    from rocsafe_orchestrator.contamination import clear

    clear(arguments.out, arguments.vehicle)
    return 0
