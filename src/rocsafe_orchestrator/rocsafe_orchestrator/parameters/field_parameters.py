# SPDX-License-Identifier: Apache-2.0
"""Parameters of the radiation field, made from the radiation block of a scenario."""

from typing import Any

from rocsafe_orchestrator.parameters.terrain_parameters import true_terrain_parameters
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.scenario import Scenario

Parameters = dict[str, Any]
# Blocks that have the same keys in the settings file of the field.
SHARED_BLOCKS = {'sources', 'shields', 'background'}


def field_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the radiation field; `field_file` is the content of that file."""
    radiation = scenario.radiation
    return {
        'model': radiation.model,
        'source_radius_m': radiation.source_radius_m,
        'vehicles': list(scenario.metered_names),
        # The true position of a real vehicle is unknown.
        'vehicles_at_their_fix': [n for n in scenario.metered_names if n in scenario.real_names],
        'start_time_s': scenario.clock.start.timestamp(),
        'field_file': _field_file(scenario, run),
        'detector': radiation.detector,
        'window_s': radiation.window_s,
        'seed': scenario.seed,
        'lock_step': True,
    }


def _field_file(scenario: Scenario, run: RunDirectory) -> Parameters:
    radiation = scenario.radiation
    shared = radiation.model_dump(mode='json', include=SHARED_BLOCKS, exclude_defaults=True)
    scene = radiation.scene_file
    return {
        'ground_altitude_m': scenario.origin.ground_altitude_m,
        **shared,
        **({'solids_file': str(run.solids_of(scene))} if scene else {}),
        **true_terrain_parameters(scenario, run),
    }
