# SPDX-License-Identifier: Apache-2.0
"""`rocsafe plan`."""

import argparse
from pathlib import Path
from typing import Any

from rocsafe_orchestrator.arguments.planning_options import add_options
from rocsafe_orchestrator.command_line import Commands


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Plan the survey of each scenario, or of the polygons of each region file (GeoJSON, KML, '
        'KMZ, QGroundControl plan, CSV) with a fleet of like vehicles, and print the routes. '
        'Nothing flies.'
    )
    parser = commands.add_parser(
        'plan',
        help='plan a survey, without flying',
        description=text,
        usage='%(prog)s [options] SCENARIO|REGION ...',
    )
    parser.add_argument(
        'files',
        type=Path,
        nargs='+',
        metavar='SCENARIO|REGION',
        help='scenario (.yaml) or region (.geojson, .json, .kml, .kmz, .plan, .csv)',
    )
    add_options(parser, 'out', 'method', 'budget', 'exclude')
    group = parser.add_argument_group('region files', 'settings that a region file does not hold')
    add_options(group, 'drones', 'height', 'home')
    group = parser.add_argument_group('survey', 'override the values of the scenario')
    add_options(
        group, 'objective', 'grid', 'overlap', 'front-overlap', 'spacing-rule', 'clearance',
        'wind', 'separation', 'separation-by', 'terrain', 'terrain-clearance',
        'max-height', 'max-viewpoints', 'seed',
    )  # fmt: skip
    group = parser.add_argument_group('vehicles', 'values for all vehicles')
    add_options(group, 'speed', 'hover', 'endurance', 'swap', 'open')
    parser.set_defaults(command=_plan)


def _plan(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from rocsafe_orchestrator.planning_commands.plan_command import PlanRequest, plan

    request = PlanRequest(
        files=tuple(arguments.files),
        vehicles=arguments.drones,
        height_agl_m=arguments.height,
        home=arguments.home and tuple(arguments.home),
        parent=arguments.out,
        exclusions=tuple(arguments.exclude),
        seed=arguments.seed,
        survey=_given(
            grid=arguments.grid,
            max_viewpoints=arguments.max_viewpoints,
            overlap_fraction=arguments.overlap,
            front_overlap_fraction=arguments.front_overlap,
            spacing_rule=arguments.spacing_rule,
            terrain_file=arguments.terrain and str(arguments.terrain),
        ),
        airspace=_given(
            clearance_m=arguments.clearance,
            terrain_clearance_m=arguments.terrain_clearance,
            max_height_agl_m=arguments.max_height,
            wind_mps=arguments.wind and tuple(arguments.wind),
        ),
        separation=_given(distance_m=arguments.separation, by=arguments.separation_by),
        effort=_given(
            method=arguments.method or None,
            objective=arguments.objective,
            budget_s=arguments.budget,
        ),
        vehicle=_given(
            cruise_speed_mps=arguments.speed,
            hover_s=arguments.hover,
            battery_swap_s=arguments.swap,
            is_open=arguments.open,
            endurance_s=arguments.endurance,
        ),
    )
    return plan(request, Console())


def _given(**options: Any) -> dict[str, Any]:
    """Return the options that are given."""
    return {key: value for key, value in options.items() if value is not None}
