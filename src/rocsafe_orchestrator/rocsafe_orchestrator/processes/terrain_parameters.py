# SPDX-License-Identifier: Apache-2.0
"""From a scenario to what the radiation nodes know of the ground's height."""

from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_scenario.scenario import Scenario

Parameters = dict[str, Any]
# Who answers for the ground of a scene; the nodes call it by this name.
SCENE_HEIGHTS = 'rocsafe_scene.solids.ground_heights:scene_heights'


def true_terrain_parameters(scenario: Scenario) -> Parameters:
    """Return those of the field: of the engine's scene, else of what the flights follow."""
    return _of_scene(scenario) or _of_file(scenario)


def known_terrain_parameters(scenario: Scenario) -> Parameters:
    """Return those of the localizer: of what the flights follow, else of the engine's scene."""
    return _of_file(scenario) or _of_scene(scenario)


def ground_options(scenario: Scenario) -> tuple[str, ...]:
    """Return the options of the command `localize` that mean the same as the localizer's."""
    options = [f'--ground={scenario.origin.ground_altitude_m}']
    known = known_terrain_parameters(scenario)
    if known:
        options += [
            f'--terrain={known["terrain_file"]}',
            f'--terrain-provider={known["terrain_provider"]}',
            f'--terrain-seed={known["terrain_seed"]}',
        ]
        keys = ('latitudes_deg', 'longitudes_deg', 'altitudes_m')
        for place in zip(*(known[f'terrain_{key}'] for key in keys), strict=True):
            options += ['--terrain-at', *(f'{value:.9f}' for value in place)]
    return tuple(options)


def _of_scene(scenario: Scenario) -> Parameters:
    """Return the ground of the scene that vehicles fly in, none if they fly in none."""
    camera = scenario.camera
    if camera.backend != 'engine' or not camera.scene_file:
        return {}
    return _parameters(camera.scene_file, [scenario.origin_position()], SCENE_HEIGHTS, scenario)


def _of_file(scenario: Scenario) -> Parameters:
    """Return the ground of the elevation model, as the planner shifts it: to agree with homes."""
    file = scenario.survey.terrain_file
    if not file:
        return {}
    homes = [scenario.ground_position(v.home) for v in scenario.vehicles if v.has_home]
    return _parameters(file, homes, '', scenario)


def _parameters(
    file: str, places: list[GeoPosition], provider: str, scenario: Scenario
) -> Parameters:
    return {
        'terrain_file': file,
        'terrain_provider': provider,
        'terrain_seed': scenario.seed,
        'terrain_latitudes_deg': [place.latitude_deg for place in places],
        'terrain_longitudes_deg': [place.longitude_deg for place in places],
        'terrain_altitudes_m': [place.altitude_m for place in places],
    }
