# SPDX-License-Identifier: Apache-2.0
"""`rocsafe check`: check that a scenario is valid and can be planned, and print its plan."""

from pathlib import Path

from rich.console import Console
from rich.table import Table

from rocsafe_geo.position import distance_m
from rocsafe_orchestrator.errors import EXIT_COMPLETE
from rocsafe_orchestrator.planning_commands.plan_command import planned
from rocsafe_orchestrator.planning_commands.plan_tables import quality_table
from rocsafe_orchestrator.planning_commands.preflight_command import require_links
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_checks import flight_mistakes
from rocsafe_scenario.scenario_file import read_scenario
from rocsafe_scenario.survey_size import area_m2, fewest_viewpoints, spacings_m


def check(path: Path, console: Console) -> int:
    """Print what the scenario at `path` would fly.

    Raises
    ------
    ScenarioError
        If it is not valid.
    OrchestratorError
        If there is no plan, with the reason of the planner.
    """
    scenario = read_scenario(path)
    for line in flight_mistakes(scenario):
        console.print(line, style='yellow', highlight=False, soft_wrap=True)
    require_links(scenario)
    console.print(_survey_table(scenario))
    console.print(_vehicle_table(scenario))
    if scenario.radiation.sources:
        console.print(_source_table(scenario))
    if all(vehicle.has_home for vehicle in scenario.vehicles):
        # Only the planner knows whether there is a plan: exclusions, endurance, wind, separation.
        console.print(quality_table(path, planned(path, scenario)))
    else:
        console.print('not planned: a home is told by its vehicle', style='yellow')
    console.print(f'{path}: valid', style='bold green', highlight=False)
    return EXIT_COMPLETE


def _survey_table(scenario: Scenario) -> Table:
    survey, camera, area = scenario.survey, scenario.camera, scenario.area()
    table = Table.grid(padding=(0, 2))
    table.add_column(style='dim')
    table.add_row('scenario', scenario.name)
    if scenario.description:
        table.add_row('', scenario.description)
    holes = f', {len(area.holes)} holes' if area.holes else ''
    table.add_row('region', f'{area_m2(area) / 1e4:.2f} ha, {len(area.boundary)} corners{holes}')
    table.add_row(
        'photographs',
        f'{survey.height_agl_m:g} m above the ground, {camera.horizontal_fov_deg:g} deg, '
        f'{camera.image_width_px} x {camera.image_height_px} px',
    )
    for other in scenario.other_cameras:
        hung = 'in a gimbal' if other.gimbal else f'pitch {other.pitch_deg:g} deg'
        table.add_row('also', f'camera {other.name}, {hung}')
    across, along = spacings_m(survey, camera)
    table.add_row(
        'viewpoints',
        f'at least {fewest_viewpoints(area, survey, camera)}, {across:.2f} x {along:.2f} m apart '
        f'({survey.overlap_fraction:g} {survey.spacing_rule} overlap)',
    )
    speed = f'{scenario.clock.speed:g}x' if scenario.clock.speed else 'as fast as possible'
    table.add_row('simulation', f'seed {scenario.seed}, {speed}, {scenario.simulation.processes}')
    return table


def _vehicle_table(scenario: Scenario) -> Table:
    table = Table(box=None, pad_edge=False, header_style='dim')
    for column in ('vehicle', 'home', 'to the region', 'speed', 'endurance'):
        table.add_column(column)
    centroid = scenario.area().centroid()
    for vehicle in scenario.vehicles:
        distance = distance_m(centroid, scenario.ground_position(vehicle.home))
        table.add_row(
            vehicle.name,
            f'{vehicle.home[0]:.6f}, {vehicle.home[1]:.6f}' if vehicle.has_home else vehicle.link,
            f'{distance:.0f} m' if vehicle.has_home else 'told by the vehicle',
            f'{vehicle.cruise_speed_mps:g} m/s',
            f'{vehicle.endurance_s / 60.0:.0f} min',
        )
    return table


def _source_table(scenario: Scenario) -> Table:
    table = Table(box=None, pad_edge=False, header_style='dim')
    for column in ('source', 'place', 'height', 'strength'):
        table.add_column(column)
    for source in scenario.radiation.sources:
        table.add_row(
            source.name,
            f'{source.place[0]:.6f}, {source.place[1]:.6f}',
            f'{source.height_m:g} m',
            ', '.join(filter(None, (source.strength_text, source.shape_text))),
        )
    return table
