# SPDX-License-Identifier: Apache-2.0
"""From the radiation block of a scenario to the parameters of the radiation field."""

from typing import Any

from rocsafe_orchestrator.processes.terrain_parameters import true_terrain_parameters
from rocsafe_scenario.radiation_blocks import SourceBlock
from rocsafe_scenario.scenario import Scenario

Parameters = dict[str, Any]
SHAPE_OF_KEY = {'position': 'point'}
# Who answers for the things of a scene; the field calls it by this name.
SCENE_SHIELDING = 'rocsafe_scene.solids.shielding:scene_shielding'


def field_parameters(scenario: Scenario) -> Parameters:
    """Return the parameters of the radiation field."""
    radiation, origin = scenario.radiation, scenario.origin_position()
    metered = scenario.with_simulated_detector
    return {
        'model': radiation.model,
        'source_radius_m': radiation.source_radius_m,
        'vehicles': [vehicle.name for vehicle in metered],
        # Nobody knows where a real vehicle truly is.
        'vehicles_at_their_fix': [vehicle.name for vehicle in metered if vehicle.link],
        'start_time_s': scenario.clock.start.timestamp(),
        **_sources(scenario),
        **_boxes(scenario),
        'shielding': SCENE_SHIELDING if radiation.scene_file else '',
        'shielding_file': radiation.scene_file,
        'origin_latitude_deg': origin.latitude_deg,
        'origin_longitude_deg': origin.longitude_deg,
        'origin_altitude_m': origin.altitude_m,
        'detector': radiation.detector,
        'window_s': radiation.window_s,
        'background_usvh': radiation.background.dose_rate_usvh,
        'background_variation': radiation.background.variation,
        'background_length_m': radiation.background.length_m,
        'background_cosmic': radiation.background.cosmic,
        'ground_altitude_m': scenario.origin.ground_altitude_m,
        **true_terrain_parameters(scenario),
        'seed': scenario.seed,
        'lock_step': True,
    }


def _sources(scenario: Scenario) -> Parameters:
    """Return the parallel lists that describe the sources."""
    sources = scenario.radiation.sources
    altitudes_m = [_altitude_m(scenario, source) for source in sources]
    corners = [
        (*corner, altitude_m)
        for source, altitude_m in zip(sources, altitudes_m, strict=True)
        for corner in source.corners
    ]
    times_s = [time_s for source in sources for time_s in _corner_times_s(source)]
    return {
        'source_names': [source.name for source in sources],
        'source_latitudes_deg': [source.place[0] for source in sources],
        'source_longitudes_deg': [source.place[1] for source in sources],
        'source_altitudes_m': altitudes_m,
        'source_sigmas_usvps': [source.sigma_usvps or 0.0 for source in sources],
        'source_nuclides': [source.nuclide or '' for source in sources],
        'source_activities_gbq': [source.activity_gbq or 0.0 for source in sources],
        'source_ages_s': [_age_s(scenario, source) for source in sources],
        'source_shapes': [SHAPE_OF_KEY.get(key, key) for s in sources for key in s.shapes],
        'source_corner_counts': [len(source.corners) for source in sources],
        'corner_latitudes_deg': [corner[0] for corner in corners],
        'corner_longitudes_deg': [corner[1] for corner in corners],
        'corner_altitudes_m': [corner[2] for corner in corners],
        'corner_times_s': times_s,
    }


def _boxes(scenario: Scenario) -> Parameters:
    """Return the parallel lists that describe the shields."""
    shields = scenario.radiation.shields
    ground_m = scenario.origin.ground_altitude_m
    return {
        'box_materials': [shield.material for shield in shields],
        'box_latitudes_deg': [shield.position[0] for shield in shields],
        'box_longitudes_deg': [shield.position[1] for shield in shields],
        'box_altitudes_m': [ground_m + shield.base_height_m for shield in shields],
        'box_lengths_m': [shield.length_m for shield in shields],
        'box_widths_m': [shield.width_m for shield in shields],
        'box_heights_m': [shield.height_m for shield in shields],
        'box_headings_deg': [shield.heading_deg for shield in shields],
        'box_walls_m': [shield.wall_m for shield in shields],
    }


def _corner_times_s(source: SourceBlock) -> list[float]:
    """Return the times of the stops of a track, zero for the corners of other shapes."""
    if source.track:
        return [stop.time_s for stop in source.track]
    return [0.0] * len(source.corners)


def _age_s(scenario: Scenario, source: SourceBlock) -> float:
    """Return for how long the activity of `source` has decayed when the mission starts."""
    if source.activity_date is None:
        return 0.0
    return (scenario.clock.start - source.activity_date).total_seconds()


def _altitude_m(scenario: Scenario, source: SourceBlock) -> float:
    """Return the altitude of `source` above the ellipsoid."""
    return scenario.ground_position(source.place, source.height_m).altitude_m
