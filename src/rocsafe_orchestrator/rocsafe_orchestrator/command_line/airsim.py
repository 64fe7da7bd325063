# SPDX-License-Identifier: Apache-2.0
"""`rocsafe airsim`."""

import argparse
import os
from pathlib import Path

from rocsafe_orchestrator.arguments.numbers import speed
from rocsafe_orchestrator.command_line import Commands

PORT = 41451


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Start the vehicles and the scene of a scenario, without a survey, and serve scripts '
        "that use AirSim's API (docs/airsim.md)."
    )
    parser = commands.add_parser('airsim', help="fly by scripts of AirSim's API", description=text)
    parser.add_argument('scenario', type=Path, metavar='SCENARIO', help='scenario file (YAML)')
    parser.add_argument(
        '--out', type=Path, default=Path('runs'), metavar='DIR', help='for logs (default: runs)'
    )
    parser.add_argument(
        '--speed',
        type=speed,
        default=1.0,
        metavar='X',
        help='simulated time over real time, 0: as fast as possible (default: 1)',
    )
    parser.add_argument(
        '--host',
        default='127.0.0.1',
        metavar='ADDRESS',
        help='address to listen on; whoever reaches it commands the vehicles (default: 127.0.0.1)',
    )
    parser.add_argument(
        '--port', type=int, default=PORT, metavar='N', help=f'TCP port (default: {PORT})'
    )
    parser.set_defaults(command=_serve)


def _serve(arguments: argparse.Namespace) -> int:
    # Before numpy is loaded: nodes cannot be forked from a process with threads.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    from rich.console import Console

    from rocsafe_orchestrator.errors import SetupError
    from rocsafe_orchestrator.mission_commands.airsim_command import AirsimRequest, serve_scripts

    if not 0 <= arguments.port <= 65_535:
        raise SetupError(f'--port {arguments.port}: must be within 0 and 65535')
    request = AirsimRequest(
        scenario=arguments.scenario,
        parent=arguments.out,
        speed=arguments.speed,
        host=arguments.host,
        port=arguments.port,
    )
    return serve_scripts(request, Console())
