# SPDX-License-Identifier: Apache-2.0
"""Commands of other packages: `rocsafe localize ...` runs the executable of the package."""

import os
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass

from rocsafe_orchestrator.command_line import Commands
from rocsafe_orchestrator.errors import EXIT_SIGNAL_BASE


@dataclass(frozen=True, slots=True, kw_only=True)
class PassedOn:
    """A command that is an executable of another package, which reads the arguments itself.

    Attributes
    ----------
    word
        The command, after `rocsafe`.
    package, executable
        The executable that carries it out.
    summary
        Its line in `rocsafe --help`.
    """

    word: str
    package: str
    executable: str
    summary: str


PASSED_ON = (
    PassedOn(
        word='localize',
        package='rocsafe_radiation',
        executable='localize',
        summary='estimate sources from readings',
    ),
    PassedOn(
        word='map',
        package='rocsafe_mapping',
        executable='map',
        summary='map a folder of photographs',
    ),
    PassedOn(
        word='scene',
        package='rocsafe_scene',
        executable='scene',
        summary='check, list and render scenes; write their terrain heights',
    ),
    PassedOn(
        word='dataset',
        package='rocsafe_dataset',
        executable='dataset',
        summary='make labelled images of a scene for training',
    ),
    PassedOn(
        word='changes',
        package='rocsafe_mapping',
        executable='changes',
        summary='find changes between two flights',
    ),
    PassedOn(
        word='import',
        package='rocsafe_mapping',
        executable='import',
        summary='import photographs into an image store',
    ),
    PassedOn(
        word='repository',
        package='rocsafe_mapping',
        executable='repository',
        summary='receive photographs over HTTP and store them',
    ),
)


def add_to(commands: Commands) -> None:
    """List the commands in the help of `rocsafe`; `pass_on` handles their arguments."""
    for row in PASSED_ON:
        commands.add_parser(row.word, help=row.summary, add_help=False)


def passed_on(argv: Sequence[str]) -> PassedOn | None:
    """Return the row for the command line `argv`, None if `rocsafe` itself handles it."""
    return next((row for row in PASSED_ON if argv and argv[0] == row.word), None)


def pass_on(row: PassedOn, arguments: Sequence[str]) -> int:
    """Run the executable of `row` with `arguments` and return its exit code.

    Raises
    ------
    SetupError
        If it is not installed.
    """
    from rocsafe_orchestrator.processes.launches import ONE_THREAD, find_executable

    command = [str(find_executable(row.package, row.executable)), *arguments]
    done = subprocess.run(command, env={**ONE_THREAD, **os.environ}, check=False)
    return done.returncode if done.returncode >= 0 else EXIT_SIGNAL_BASE - done.returncode
