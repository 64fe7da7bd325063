# SPDX-License-Identifier: Apache-2.0
"""`rocsafe plan`."""

import argparse
from pathlib import Path

from rocsafe_orchestrator.command_line import Commands
from rocsafe_orchestrator.command_line.numbers import budget, count, height


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
        '--drones',
        '--vehicles',
        dest='vehicles',
        type=count,
        default=3,
        metavar='N',
        help='of a region file (default: 3)',
    )
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
    parser.add_argument(
        '--height',
        type=height,
        default=32.0,
        metavar='M',
        help='metres above the ground, of a region file (default: 32)',
    )
    parser.set_defaults(command=_plan)


def _plan(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.command_line.plan_command import PlanRequest, plan

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
