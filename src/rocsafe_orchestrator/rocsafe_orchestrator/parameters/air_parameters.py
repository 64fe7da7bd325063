# SPDX-License-Identifier: Apache-2.0
"""Parameters of the node ``air``, made from the air block of a scenario."""

from typing import Any

from rocsafe_scenario.scenario import Scenario

Parameters = dict[str, Any]
# Keys of the block that are parameters of the node, not settings of its file.
OWN_KEYS = {'window_s', 'wind'}


def air_parameters(scenario: Scenario) -> Parameters:
    """Return the parameters of the air; `air_file` is the content of that file.

    The wind is the one that pushes the vehicles.
    """
    metered = scenario.with_simulated_detector
    east, north = scenario.survey.airspace.wind_mps
    wind = {'towards_east_mps': east, 'towards_north_mps': north}
    return {
        'vehicles': [vehicle.name for vehicle in metered],
        # The true position of a real vehicle is unknown.
        'vehicles_at_their_fix': [vehicle.name for vehicle in metered if vehicle.link],
        'start_time_s': scenario.clock.start.timestamp(),
        'air_file': {
            'wind': wind | scenario.air.wind.model_dump(),
            'ground_altitude_m': scenario.origin.ground_altitude_m,
            **scenario.air.model_dump(mode='json', exclude=OWN_KEYS, exclude_defaults=True),
        },
        'window_s': scenario.air.window_s,
        'seed': scenario.seed,
        'lock_step': True,
    }
