# SPDX-License-Identifier: Apache-2.0
"""Ground heights for the radiation nodes, as parameters made from a scenario."""

from typing import Any

from rocsafe_geo.solids.ground_heights import read_heights, shift_to_m
from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.scenario import Scenario

Parameters = dict[str, Any]


def true_terrain_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return those of the field: the ground of the engine's scene, else that of the planner.

    Raises
    ------
    SetupError
        If the elevation model cannot be read or has no height at a home.
    """
    return _of_scene(scenario, run) or _of_file(scenario)


def known_terrain_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return those of the localizer: the ground of the planner, else that of the engine's scene.

    Raises
    ------
    SetupError
        As `true_terrain_parameters`.
    """
    return _of_file(scenario) or _of_scene(scenario, run)


def ground_options(scenario: Scenario, run: RunDirectory) -> tuple[str, ...]:
    """Return the options of the command `localize` that mean the same as the localizer's."""
    options = [f'--ground={scenario.origin.ground_altitude_m}']
    if scenario.survey.terrain_file:
        options.append(f'--terrain={scenario.survey.terrain_file}')
        for home in _homes(scenario):
            place = (home.latitude_deg, home.longitude_deg, home.altitude_m)
            options += ['--terrain-at', *(f'{value:.9f}' for value in place)]
    elif scenario.engine_scene:
        options.append(f'--terrain={run.solids_of(scenario.engine_scene)}')
    return tuple(options)


def _of_scene(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the ground of the scene that vehicles fly in, none if they fly in none."""
    scene = scenario.engine_scene
    return {'terrain_file': str(run.solids_of(scene))} if scene else {}


def _of_file(scenario: Scenario) -> Parameters:
    """Return the elevation model, shifted to agree with the homes as the planner shifts it."""
    file = scenario.survey.terrain_file
    if not file:
        return {}
    try:
        shift_m = shift_to_m(read_heights(file), _homes(scenario))
    except ValueError as error:
        raise SetupError(f'survey.terrain_file: {error}') from error
    return {'terrain_file': file, 'terrain_shift_m': shift_m}


def _homes(scenario: Scenario) -> list[Any]:
    return [scenario.ground_position(v.home) for v in scenario.vehicles if v.has_home]
