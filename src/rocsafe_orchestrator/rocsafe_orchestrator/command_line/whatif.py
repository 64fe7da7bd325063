# SPDX-License-Identifier: Apache-2.0
"""`rocsafe whatif`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.arguments.numbers import part
from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Plan a scenario and fly it with agents in simulated time, again and again: each vehicle '
        'is lost at several times, two are lost, the agent of the head is lost, the radio '
        'is cut. Nothing is started.'
    )
    parser = commands.add_parser('whatif', help='try losses of a mission', description=text)
    parser.add_argument('scenario', type=Path, metavar='SCENARIO', help='scenario file (YAML)')
    parser.add_argument(
        '--loss', type=part, default=0.1, metavar='PART',
        help='part of the packets that the radio loses, 0 to 1 (default 0.1)',
    )  # fmt: skip
    parser.set_defaults(command=_whatif)


def _whatif(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.planning_commands.whatif_command import what_if_of

    return what_if_of(arguments.scenario, arguments.loss, Console())
