# SPDX-License-Identifier: Apache-2.0
"""Parameters of ``air``, ``estimator`` and ``advisor``, from the air block of a scenario."""

from typing import Any

from rocsafe_orchestrator.run_directory import PROCEDURES, RunDirectory
from rocsafe_scenario.scenario import Scenario

Parameters = dict[str, Any]
ESTIMATOR, ADVISOR = 'estimator', 'advisor'
# Keys of the block that are parameters of the node, not settings of its file.
OWN_KEYS = {'window_s', 'wind', 'search'}


def wind_settings(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the wind of a mission, which pushes the vehicles and carries the gas."""
    east, north = scenario.survey.airspace.wind_mps
    wind = scenario.air.wind
    return {
        'towards_east_mps': east,
        'towards_north_mps': north,
        **wind.model_dump(exclude={'scene_file'}),
        **({'site_file': str(run.site_wind)} if wind.scene_file else {}),
    }


def air_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the air; `air_file` is the content of that file."""
    origin = scenario.origin_position()
    return {
        'vehicles': list(scenario.metered_names),
        # The true position of a real vehicle is unknown.
        'vehicles_at_their_fix': [n for n in scenario.metered_names if n in scenario.real_names],
        'start_time_s': scenario.clock.start.timestamp(),
        'air_file': {
            'wind': wind_settings(scenario, run),
            'origin': [origin.latitude_deg, origin.longitude_deg],
            'ground_altitude_m': scenario.origin.ground_altitude_m,
            **scenario.air.model_dump(mode='json', exclude=OWN_KEYS, exclude_defaults=True),
        },
        'window_s': scenario.air.window_s,
        'seed': scenario.seed,
        'lock_step': True,
    }


def estimator_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the estimator, which is told of the air but not of releases."""
    air, origin = scenario.air, scenario.origin_position()
    return {
        'vehicles': list(scenario.all_names),
        'origin_latitude_deg': origin.latitude_deg,
        'origin_longitude_deg': origin.longitude_deg,
        'origin_altitude_m': origin.altitude_m,
        'stability': air.wind.stability,
        'roughness_m': air.wind.roughness_m,
        'dilution': air.dilution,
        'intake_delay_s': air.intake_delay_s,
        **air.search.model_dump(exclude={'extra_rounds', 'viewpoints_a_round'}),
        'spool_directory': str(run.spool / ESTIMATOR),
        **({'export_directory': str(run.hazard)} if scenario.driver_name else {}),
    }


def advisor_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the advisor, which reads what the estimator keeps."""
    return {
        'vehicles': list(scenario.vehicle_names),
        'procedures_directory': str(run.path / PROCEDURES),
        'spool_directory': str(run.spool / ESTIMATOR),
    }
