# SPDX-License-Identifier: Apache-2.0
"""`rocsafe report`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = 'Make recording, tables, summary and report of a run directory again.'
    parser = commands.add_parser('report', help='make the report of a run', description=text)
    parser.add_argument('run', type=Path, metavar='RUN_DIR', help='run directory')
    parser.set_defaults(command=_report)


def _report(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.mission_commands.report_command import report

    return report(arguments.run, Console())
