# SPDX-License-Identifier: Apache-2.0
"""Commands of other packages: `rocsafe localize ...` runs the executable of the package."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

from rocsafe_orchestrator.command_line import Commands


@dataclass(frozen=True, slots=True)
class PassedOn:
    """A command that is an executable of another package, which reads the arguments itself.

    Attributes
    ----------
    word
        The command, after `rocsafe`, and the name of the executable.
    package
        The package of the executable.
    summary
        Its line in `rocsafe --help`.
    """

    word: str
    package: str
    summary: str


# `rocsafe scene show` reads a scenario: it is a command of this package.
SCENE, SHOW = 'scene', 'show'
PASSED_ON = (
    PassedOn('localize', 'rocsafe_radiation', 'estimate sources from readings'),
    PassedOn('locate-release', 'rocsafe_dispersion', 'find releases of gas in readings'),
    PassedOn('site-wind', 'rocsafe_dispersion', 'compute the wind around buildings'),
    PassedOn('advise', 'rocsafe_dispersion', 'name the agent and rank procedures from evidence'),
    PassedOn('ground', 'rocsafe_ground', 'plan the drive of a ground vehicle to evidence points'),
    PassedOn(
        'campaign', 'rocsafe_campaign', 'fly many missions, and find what moves their result'
    ),
    PassedOn('mavlink_view', 'rocsafe_mavlink', 'show simulated vehicles to QGroundControl'),
    PassedOn('map', 'rocsafe_mapping', 'map a folder of photographs'),
    PassedOn(SCENE, 'rocsafe_scene', 'check, list, render and show scenes; write heights'),
    PassedOn('dataset', 'rocsafe_dataset', 'make labelled images of a scene for training'),
    PassedOn('changes', 'rocsafe_mapping', 'find changes between two flights'),
    PassedOn('import', 'rocsafe_mapping', 'import photographs into an image store'),
    PassedOn('console', 'rocsafe_console', "serve the operator's page"),
    PassedOn('users', 'rocsafe_console', 'add and remove users of the console'),
    PassedOn('seal', 'rocsafe_console', 'seal a run, or make the key that signs seals'),
    PassedOn('verify', 'rocsafe_console', 'find what has been changed in a sealed run'),
    PassedOn('repository', 'rocsafe_mapping', 'receive photographs over HTTP and store them'),
)


def add_to(commands: Commands) -> None:
    """List the commands in the help of `rocsafe`; `pass_on` handles their arguments."""
    for row in PASSED_ON:
        commands.add_parser(row.word, help=row.summary, add_help=False)


def passed_on(argv: Sequence[str]) -> PassedOn | None:
    """Return the row for the command line `argv`, None if `rocsafe` itself handles it."""
    if tuple(argv[:2]) == (SCENE, SHOW):
        return None
    return next((row for row in PASSED_ON if argv and argv[0] == row.word), None)


def pass_on(row: PassedOn, arguments: Sequence[str]) -> NoReturn:
    """Become the executable of `row` with `arguments`.

    A process beside this one would outlive it when it is ended, and be killed at Ctrl-C.

    Raises
    ------
    SetupError
        If it is not installed.
    """
    from rocsafe_orchestrator.process_table.executables import ONE_THREAD, find_executable

    path = find_executable(row.package, row.word)
    os.execve(path, [str(path), *arguments], {**ONE_THREAD, **os.environ})  # noqa: S606
