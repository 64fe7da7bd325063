# SPDX-License-Identifier: Apache-2.0
"""`rocsafe run`."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from rocsafe_orchestrator.arguments.numbers import seed, speed
from rocsafe_orchestrator.command_line import Commands
from rocsafe_orchestrator.errors import EXIT_SIGNAL_BASE, SetupError

if TYPE_CHECKING:
    from rocsafe_orchestrator.mission_commands.mission_run import Extras


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = 'Fly a scenario and write a run directory: images, readings, recording, map, report.'
    parser = commands.add_parser('run', help='fly a scenario', description=text)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        'scenario', type=Path, nargs='?', metavar='SCENARIO', help='scenario file (YAML)'
    )
    what.add_argument(
        '--resume',
        type=Path,
        metavar='RUN',
        help='join the mission of this run directory, whose vehicles have agents and go on '
        'although their orchestrator has died',
    )
    parser.add_argument(
        '--out',
        type=Path,
        default=Path('runs'),
        metavar='DIR',
        help='where to make the run directory <scenario>-<date>-<time> (default: runs)',
    )
    _add_values(parser)
    _add_servers(parser)
    parser.add_argument('--quiet', action='store_true', help='print nothing but errors')
    parser.set_defaults(command=_run)


def _add_values(parser: argparse.ArgumentParser) -> None:
    """Add the options that take precedence over the scenario, and the confirmation."""
    parser.add_argument(
        '--speed',
        type=speed,
        metavar='X',
        help="simulated time over real time, 0: as fast as possible (default: the scenario's)",
    )
    parser.add_argument(
        '--seed',
        type=seed,
        metavar='N',
        help="seed of the random numbers (default: the scenario's)",
    )
    parser.add_argument(
        '--config',
        type=Path,
        metavar='FILE',
        help='ROS parameter file with defaults of the nodes, like config/rocsafe.yaml; '
        'values of the scenario take precedence',
    )
    parser.add_argument(
        '--confirm',
        action='append',
        default=[],
        metavar='HASH',
        help='let real vehicles take off by the plan with this hash, as a terminal asks for it; '
        'may be given several times',
    )


def _add_servers(parser: argparse.ArgumentParser) -> None:
    """Add the options of what is served beside a mission."""
    parser.add_argument(
        '--console',
        action='store_true',
        help="serve the operator's page while the mission runs; in a terminal, until Ctrl-C",
    )
    parser.add_argument(
        '--airsim',
        type=int,
        nargs='?',
        const=41451,
        metavar='PORT',
        help="serve AirSim's API on loopback while the mission runs (default port: 41451)",
    )


def _run(arguments: argparse.Namespace) -> int:
    # Before numpy is loaded: nodes cannot be forked from a process with threads.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    from rocsafe_orchestrator.mission_commands.mission_run import Extras
    from rocsafe_orchestrator.process_table.console_process import OperatorsPage
    from rocsafe_orchestrator.processes.interrupt import Interrupt

    # The page outlives the mission, which has let go of its domain and its run by then.
    with OperatorsPage(is_wanted=arguments.console) as page:
        extras = Extras(
            config=arguments.config,
            is_quiet=arguments.quiet,
            confirmed=frozenset(arguments.confirm),
            page=page,
            airsim_port=arguments.airsim,
        )
        code = _flown(arguments, extras)
        if code < EXIT_SIGNAL_BASE:
            interrupt = Interrupt()
            page.stay(lambda: interrupt.count > 0)
        return code


def _flown(arguments: argparse.Namespace, extras: 'Extras') -> int:
    from rich.console import Console

    from rocsafe_orchestrator.mission_commands.resume_command import resume_run
    from rocsafe_orchestrator.mission_commands.run_command import RunRequest, run_scenario

    if arguments.resume is not None:
        given = {'--speed': arguments.speed, '--seed': arguments.seed, '--config': extras.config}
        for option in (name for name, value in given.items() if value is not None):
            raise SetupError(f'{option}: a run that is resumed keeps its own')
        return resume_run(arguments.resume, extras, Console())
    request = RunRequest(
        scenario=arguments.scenario,
        parent=arguments.out,
        speed=arguments.speed,
        seed=arguments.seed,
        extras=extras,
    )
    return run_scenario(request, Console())
