# SPDX-License-Identifier: Apache-2.0
"""The `rocsafe` command."""

import argparse
import math
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeAlias

from rocsafe_orchestrator.errors import EXIT_SETUP, EXIT_SIGNAL_BASE, OrchestratorError
from rocsafe_orchestrator.limits import (
    LARGEST_BUDGET_S,
    LARGEST_FLEET,
    LARGEST_HEIGHT_M,
    LARGEST_SEED,
    LARGEST_SPEED,
)

DESCRIPTION = """\
ROCSAFE surveys a region with a fleet of unmanned vehicles: it plans who photographs what, flies
the plan over simulated or real vehicles, measures radiation on the way, and hands over a map and
a report. A scenario file says what to survey with whom; config/scenarios/ has two to begin with.
"""

EPILOG = """\
examples:
  rocsafe check config/scenarios/derailment.yaml    is it valid, and what would fly?
  rocsafe plan config/scenarios/derailment.yaml     plan it, without flying
  rocsafe run config/scenarios/derailment.yaml      fly it as fast as this machine can
  rocsafe run config/scenarios/derailment.yaml --speed 1    fly it in real time
  rocsafe localize readings.csv                     find the sources in a file of readings

exit codes:
  0    done; for `run`: the mission is complete
  1    the mission failed, or the plan is not possible; the reason is printed
  2    wrong arguments, or a scenario that cannot be flown as written
  3    the workspace is not set up, a process cannot start, or another run is in the way
  129  the terminal was closed    130  ended by Ctrl-C    143  ended by SIGTERM
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with `argv`, by default the arguments of this process."""
    arguments = _parser().parse_args(argv)
    command: Callable[[argparse.Namespace], int] = arguments.command
    try:
        return command(arguments)
    except OrchestratorError as error:
        for line in str(error).splitlines():
            print(f'rocsafe: {line}', file=sys.stderr)
        return error.exit_code
    except ModuleNotFoundError as error:
        print(
            f'rocsafe: Python module {error.name} is missing: run `make setup`, or '
            'source the workspace (. install/setup.bash)',
            file=sys.stderr,
        )
        return EXIT_SETUP
    except KeyboardInterrupt:
        return EXIT_SIGNAL_BASE + signal.SIGINT


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe',
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(title='commands', required=True, metavar='COMMAND')
    _add_run(commands)
    _add_check(commands)
    _add_plan(commands)
    _add_report(commands)
    _add_localize(commands)
    return parser


Commands: TypeAlias = 'argparse._SubParsersAction[argparse.ArgumentParser]'


def _add_run(commands: Commands) -> None:
    text = 'Fly a scenario and write a run directory: images, readings, recording, map, report.'
    parser = commands.add_parser('run', help='fly a scenario', description=text)
    parser.add_argument('scenario', type=Path, metavar='SCENARIO', help='scenario file (YAML)')
    parser.add_argument(
        '--out',
        type=Path,
        default=Path('runs'),
        metavar='DIR',
        help='where to make the run directory <scenario>-<date>-<time> (default: runs)',
    )
    parser.add_argument(
        '--speed',
        type=_speed,
        metavar='X',
        help="simulated seconds a second, 0: as fast as possible (default: the scenario's)",
    )
    parser.add_argument(
        '--seed',
        type=_seed,
        metavar='N',
        help="seed of all that is random (default: the scenario's)",
    )
    parser.add_argument(
        '--config',
        type=Path,
        metavar='FILE',
        help='ROS parameter file with defaults of the nodes, like config/rocsafe.yaml; what the '
        'scenario says wins',
    )
    parser.add_argument('--quiet', action='store_true', help='print nothing but errors')
    parser.set_defaults(command=_run)


def _add_check(commands: Commands) -> None:
    text = 'Check a scenario file and print what would fly. Nothing is started.'
    parser = commands.add_parser('check', help='check a scenario file', description=text)
    parser.add_argument('scenario', type=Path, metavar='SCENARIO', help='scenario file (YAML)')
    parser.set_defaults(command=_check)


def _add_plan(commands: Commands) -> None:
    text = (
        'Plan the survey of each scenario, or of each region file (GeoJSON, KML, KMZ, '
        'QGroundControl plan, CSV) with a fleet of like vehicles that start at its first corner, '
        'and print the routes. Nothing flies.'
    )
    parser = commands.add_parser('plan', help='plan a survey, without flying', description=text)
    parser.add_argument(
        'files',
        type=Path,
        nargs='+',
        metavar='SCENARIO|REGION',
        help='scenario (.yaml) or region (.geojson, .json, .kml, .kmz, .plan, .csv)',
    )
    parser.add_argument(
        '--out',
        type=Path,
        metavar='DIR',
        help='also write the plan to DIR/<name of the file>: JSON, GeoJSON, KML, GPX, pictures, '
        'and each flight for QGroundControl, MAVLink and DJI',
    )
    parser.add_argument('--method', default='', help="routing method (default: the planner's)")
    parser.add_argument(
        '--drones',
        '--vehicles',
        dest='vehicles',
        type=_count,
        default=3,
        metavar='N',
        help='of a region file (default: 3)',
    )
    parser.add_argument(
        '--budget',
        type=_budget,
        metavar='S',
        help="seconds that may be used to improve the plan (default: the scenario's, or none)",
    )
    parser.add_argument(
        '--exclude',
        type=Path,
        action='append',
        default=[],
        metavar='REGION',
        help='region file that no leg crosses, besides those of the scenario; may be repeated',
    )
    parser.add_argument(
        '--height',
        type=_height,
        default=32.0,
        metavar='M',
        help='metres above the ground, of a region file (default: 32)',
    )
    parser.set_defaults(command=_plan)


def _add_report(commands: Commands) -> None:
    text = 'Make recording, tables, summary and report of a run directory again.'
    parser = commands.add_parser('report', help='make the report of a run', description=text)
    parser.add_argument('run', type=Path, metavar='RUN_DIR', help='run directory')
    parser.set_defaults(command=_report)


def _add_localize(commands: Commands) -> None:
    text = (
        'Find gamma sources in a CSV file of readings: place with its 95 % ellipse, strength, and '
        'how many there are. Columns: latitude_deg, longitude_deg, altitude_m (or east_m, '
        'north_m, up_m), dose_rate_usvh (or counts, live_time_s), as in readings.csv of a run.'
    )
    parser = commands.add_parser('localize', help='find sources in readings', description=text)
    parser.add_argument('file', metavar='READINGS.csv', help='readings, one a row')
    parser.add_argument('--model', choices=('auto', 'paper', 'air'), help='law of the dose rate')
    parser.add_argument('--nuclide', metavar='NAME', help='of the sources (default: Cs-137)')
    parser.add_argument(
        '--sensitivity',
        metavar='CPS',
        help='counts a second for 1 uSv/h (default: as in the file)',
    )
    parser.add_argument(
        '--height', metavar='M', help='metres above the ground, of a file without altitudes'
    )
    parser.add_argument(
        '--levels', nargs='+', metavar='USVH', help='dose rates of cordons, uSv/h at 1 m'
    )
    parser.add_argument(
        '--out', metavar='DIR', help='also write sources, cordons (GeoJSON, KML) and dose map'
    )
    parser.add_argument('--next', metavar='N', help='say at which N places to measure next')
    parser.add_argument('--json', action='store_true', help='print JSON')
    parser.set_defaults(command=_localize)


# Each command loads what it needs when it runs: `--help` and `check` are quick and work where ROS
# is not set up, and a Ctrl-C while Python still loads is no traceback.


def _run(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.run_command import RunRequest, run_scenario

    request = RunRequest(
        scenario=arguments.scenario,
        parent=arguments.out,
        speed=arguments.speed,
        seed=arguments.seed,
        config=arguments.config,
        is_quiet=arguments.quiet,
    )
    return run_scenario(request, Console())


def _check(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.check_command import check

    return check(arguments.scenario, Console())


def _plan(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.plan_command import PlanRequest, plan

    request = PlanRequest(
        files=tuple(arguments.files),
        method=arguments.method,
        vehicles=arguments.vehicles,
        height_agl_m=arguments.height,
        parent=arguments.out,
        budget_s=arguments.budget,
        exclusions=tuple(arguments.exclude),
    )
    return plan(request, Console())


def _report(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.report_command import report

    return report(arguments.run, Console())


def _localize(arguments: argparse.Namespace) -> int:
    from rocsafe_orchestrator.errors import EXIT_COMPLETE
    from rocsafe_orchestrator.source_estimates import localize

    names = ('model', 'nuclide', 'sensitivity', 'height', 'out', 'next')
    given = ((name, getattr(arguments, name)) for name in names)
    options = [f'--{name}={value}' for name, value in given if value is not None]
    levels = ['--levels', *arguments.levels] if arguments.levels else []
    localize([arguments.file, *options, *(['--json'] if arguments.json else []), *levels])
    return EXIT_COMPLETE


def _number(text: str, low: float, high: float, unit: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f'{text}: must be within {low:g} to {high:g}{unit}')
    return value


def _speed(text: str) -> float:
    return _number(text, 0.0, LARGEST_SPEED, ' simulated seconds a second')


def _height(text: str) -> float:
    return _number(text, 1.0, LARGEST_HEIGHT_M, ' m')


def _budget(text: str) -> float:
    return _number(text, 0.0, LARGEST_BUDGET_S, ' s')


def _whole(text: str, low: int, high: int) -> int:
    if not text.isascii() or not text.isdigit() or not low <= int(text) <= high:
        raise argparse.ArgumentTypeError(f'{text}: must be a whole number, {low} to {high}')
    return int(text)


def _seed(text: str) -> int:
    return _whole(text, 0, LARGEST_SEED)


def _count(text: str) -> int:
    return _whole(text, 1, LARGEST_FLEET)


if __name__ == '__main__':
    sys.exit(main())
