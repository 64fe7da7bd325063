# SPDX-License-Identifier: Apache-2.0
"""`rocsafe plan`."""

import argparse
from pathlib import Path
from typing import Any

from rocsafe_orchestrator.command_line import Commands
from rocsafe_orchestrator.command_line.numbers import (
    budget,
    count,
    height,
    metres,
    seconds,
    seed,
    wind,
)


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
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
        '--budget',
        type=budget,
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
    _add_region_options(parser)
    _add_survey_options(parser)
    _add_vehicle_options(parser)
    parser.set_defaults(command=_plan)


def _add_region_options(parser: argparse.ArgumentParser) -> None:
    """Add what a scenario says and a region file does not."""
    group = parser.add_argument_group('region files', 'what flies, and how high')
    group.add_argument(
        '--drones',
        '--vehicles',
        dest='vehicles',
        type=count,
        default=3,
        metavar='N',
        help='how many fly (default: 3)',
    )
    group.add_argument(
        '--height',
        type=height,
        default=32.0,
        metavar='M',
        help='metres above the ground (default: 32)',
    )


def _add_survey_options(parser: argparse.ArgumentParser) -> None:
    """Add what replaces keys of a scenario's survey."""
    group = parser.add_argument_group('survey', "instead of the scenario's own values")
    names = ('longest_time', 'longest_distance', 'total_time', 'total_distance', 'energy')
    group.add_argument('--objective', choices=names, help='what is to be small')
    group.add_argument('--grid', choices=('axis_aligned', 'rotated', 'best'), help='its angle')
    group.add_argument(
        '--wind',
        type=wind,
        nargs=2,
        metavar=('EAST', 'NORTH'),
        help='m/s that the air moves towards',
    )
    group.add_argument(
        '--separation', type=metres, metavar='M', help='least distance of two vehicles in the air'
    )
    group.add_argument(
        '--separation-by',
        choices=('delay', 'layers'),
        help='how it is kept: take-offs are delayed, or vehicles fly at unlike heights',
    )
    group.add_argument(
        '--terrain', type=Path, metavar='TIF', help='GeoTIFF of heights that the flights follow'
    )
    group.add_argument(
        '--terrain-clearance', type=metres, metavar='M', help='that legs keep above it'
    )
    group.add_argument('--seed', type=seed, metavar='N', help='of the search')


def _add_vehicle_options(parser: argparse.ArgumentParser) -> None:
    """Add what replaces keys of all of a scenario's vehicles."""
    group = parser.add_argument_group('vehicles', 'for all of them')
    group.add_argument(
        '--swap',
        type=seconds,
        metavar='S',
        help='batteries are changed at home in so many seconds',
    )
    group.add_argument(
        '--open', action='store_true', default=None, help='each lands at its last viewpoint'
    )
    group.add_argument('--endurance', type=seconds, metavar='S', help='of a full battery')


def _plan(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.command_line.plan_command import PlanRequest, plan

    request = PlanRequest(
        files=tuple(arguments.files),
        method=arguments.method,
        vehicles=arguments.vehicles,
        height_agl_m=arguments.height,
        parent=arguments.out,
        exclusions=tuple(arguments.exclude),
        seed=arguments.seed,
        survey=_given(
            objective=arguments.objective,
            grid=arguments.grid,
            wind_mps=arguments.wind and tuple(arguments.wind),
            separation_m=arguments.separation,
            separation_by=arguments.separation_by,
            terrain_file=arguments.terrain and str(arguments.terrain),
            terrain_clearance_m=arguments.terrain_clearance,
            budget_s=arguments.budget,
        ),
        vehicle=_given(
            battery_swap_s=arguments.swap,
            is_open=arguments.open,
            endurance_s=arguments.endurance,
        ),
    )
    return plan(request, Console())


def _given(**options: Any) -> dict[str, Any]:
    """Return the options that are given."""
    return {key: value for key, value in options.items() if value is not None}
