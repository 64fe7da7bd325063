# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the router and of the simulated ground vehicle, made from a scenario."""

from typing import Any

from rocsafe_orchestrator.parameters.node_parameters import LOCK_STEP, origin_parameters
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.blocks.cameras import backend_parameters
from rocsafe_scenario.blocks.ground_vehicle import GroundVehicleBlock
from rocsafe_scenario.scenario import Scenario

Parameters = dict[str, Any]
ROUTER = 'router'
# Time between two readings of detectors that count nothing: they answer each fix.
IDEAL = 'ideal'


def router_parameters(
    scenario: Scenario, block: GroundVehicleBlock, run: RunDirectory
) -> Parameters:
    """Return the parameters of the router: it plans on what the mission has found.

    Slopes are those of the elevation model that the drones fly by, never those of a scene.
    """
    terrain = scenario.survey.terrain_file
    return {
        'width_m': block.width_m,
        **({'terrain_file': terrain} if terrain else {}),
        **({'labels_file': block.labels_file} if block.labels_file else {}),
        'products_directory': str(run.path),
        'hazard_directory': str(run.hazard),
        'export_directory': str(run.drives),
    }


def rgv_parameters(scenario: Scenario, block: GroundVehicleBlock, run: RunDirectory) -> Parameters:
    """Return the parameters of the process of the ground vehicle."""
    simulation, radiation = scenario.simulation, scenario.radiation
    fix_period_s = 1.0 / simulation.fix_rate_hz
    is_ideal = radiation.detector == IDEAL
    return {
        'home_latitude_deg': block.home[0],
        'home_longitude_deg': block.home[1],
        'width_m': block.width_m,
        'endurance_s': block.endurance_s / (1.0 - block.reserve_fraction),
        'gas_sensors': list(scenario.air.gas_sensors),
        'gas_period_s': scenario.air.window_s + fix_period_s,
        'reading_period_s': fix_period_s if is_ideal else radiation.window_s + fix_period_s,
        'fix_rate_hz': simulation.fix_rate_hz,
        'gps_horizontal_std_m': simulation.gps_horizontal_std_m,
        'gps_vertical_std_m': simulation.gps_vertical_std_m,
        **backend_parameters(scenario.camera),
        'scene': scenario.scene,
        'scene_start_s': scenario.clock.start.timestamp(),
        'seed': scenario.seed,
        'spool_directory': str(run.spool / block.name),
        **origin_parameters(scenario),
        **LOCK_STEP,
    }
