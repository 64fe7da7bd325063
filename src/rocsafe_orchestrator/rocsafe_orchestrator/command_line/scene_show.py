# SPDX-License-Identifier: Apache-2.0
"""`rocsafe scene show`: a live view of the scene of a mission that runs."""

import argparse
import json
import os
import sys
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rocsafe_geo.argument import image_size, number
from rocsafe_orchestrator.command_line import Commands
from rocsafe_orchestrator.command_line.passed_on import SCENE, SHOW

if TYPE_CHECKING:
    from rocsafe_scenario.scenario import Scenario

# The camera stands in the south, so far from the middle of the region as this part of its reach.
BACK, UP = 1.3, 1.0
LEAST_REACH_M = 60.0
SIZE = (960, 600)


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe scene`."""
    text = (
        'Look at the scene of a mission of this ROS domain while it runs, with vehicles, tracks '
        'and routes: in a window where there is a display, otherwise in the console (camera '
        '"Scene"). Keys: 0 overview, 1 to 9 behind a vehicle, q ends.'
    )
    words = commands.choices[SCENE].add_subparsers(required=True)
    parser = words.add_parser(SHOW, help='a live view of a mission that runs', description=text)
    parser.add_argument('scenario', type=Path, metavar='SCENARIO', help='scenario file (YAML)')
    for name, what in (('eye', 'place of the camera'), ('target', 'place at which it looks')):
        parser.add_argument(
            f'--{name}', type=_place, metavar='E,N,U',
            help=f'{what}: metres east, north, up of the origin of the mission',
        )  # fmt: skip
    parser.add_argument('--follow', default='', metavar='VEHICLE', help='look from behind it')
    parser.add_argument(
        '--size', type=image_size, default=SIZE, metavar='WxH', help='pixels (default: 960x600)'
    )
    parser.add_argument(
        '--rate',
        type=number(0.1, 60.0, ' Hz'),
        default=5.0,
        metavar='HZ',
        help='most pictures a second (default: 5)',
    )
    parser.add_argument(
        '--no-window', action='store_true', help='for the console only, also where a display is'
    )
    parser.set_defaults(command=_show)


def _place(text: str) -> tuple[float, ...]:
    try:
        east, north, up = (float(part) for part in text.split(','))
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text}: must be three numbers, E,N,U') from None
    return east, north, up


def _show(arguments: argparse.Namespace) -> int:
    from rocsafe_orchestrator.process_table.executables import find_executable
    from rocsafe_orchestrator.processes.ros_reach import stay_on_this_machine
    from rocsafe_scenario.scenario_file import read_scenario

    scenario = read_scenario(arguments.scenario)
    viewer = str(find_executable('rocsafe_sim', 'viewer'))
    window = bool(os.environ.get('DISPLAY')) and not arguments.no_window
    values = {**_scene(scenario, arguments.scenario), **_view(scenario, arguments)}
    values['window'] = window
    pairs = (('-p', f'{name}:={json.dumps(value)}') for name, value in values.items())
    stay_on_this_machine()
    if not window:
        sys.stdout.write('no window: look at "Scene" among the cameras of `rocsafe console`\n')
        sys.stdout.flush()
    # This process becomes the viewer: signals reach it, and nothing is left behind.
    os.execv(viewer, [viewer, '--ros-args', '-p', 'use_sim_time:=true', *chain(*pairs)])  # noqa: S606


def _scene(scenario: 'Scenario', path: Path) -> dict[str, Any]:
    """Return the parameters of the scene, which vehicles over a flat ground have, too."""
    from rocsafe_orchestrator.parameters.node_parameters import origin_parameters
    from rocsafe_scenario.errors import ScenarioError

    file = scenario.engine_scene or str(
        (path.parent / f'../scenes/{scenario.scene}.yaml').resolve()
    )
    if not Path(file).is_file():
        raise ScenarioError(f'{path.name}: scene = {scenario.scene!r}: there is no {file} to show')
    return {
        'scene_file': file,
        'scene_start_s': scenario.clock.start.timestamp(),
        'seed': scenario.seed,
        **origin_parameters(scenario),
    }


def _view(scenario: 'Scenario', arguments: argparse.Namespace) -> dict[str, Any]:
    from rocsafe_orchestrator.errors import SetupError

    if arguments.follow and arguments.follow not in scenario.all_names:
        names = ', '.join(scenario.all_names)
        raise SetupError(f'--follow {arguments.follow}: must be one of {names}')
    eye, target = _overview(scenario)
    return {
        'vehicles': list(scenario.all_names),
        'eye_m': list(arguments.eye or eye),
        'target_m': list(arguments.target or target),
        'follow': arguments.follow,
        'width_px': arguments.size[0],
        'height_px': arguments.size[1],
        'rate_hz': arguments.rate,
    }


def _overview(scenario: 'Scenario') -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return a place in the south and above from which the region is seen, and its middle."""
    import numpy as np

    from rocsafe_geo.frame import LocalFrame

    frame = LocalFrame(scenario.origin_position())
    corners = np.array(scenario.area().polygon(frame).exterior.coords)
    low, high = corners.min(axis=0), corners.max(axis=0)
    east, north = (0.5 * (low + high)).tolist()
    reach = max(LEAST_REACH_M, 0.5 * float(np.hypot(*(high - low))))
    return (east, north - BACK * reach, UP * reach), (east, north, 0.0)
