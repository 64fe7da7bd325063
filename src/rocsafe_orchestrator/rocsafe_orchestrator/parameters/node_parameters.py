# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of each node, made from a scenario."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from rocsafe_orchestrator.parameters.air_parameters import wind_settings
from rocsafe_orchestrator.parameters.terrain_parameters import known_terrain_parameters
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.blocks.cameras import camera_parameters
from rocsafe_scenario.blocks.ground_vehicle import GroundVehicleBlock
from rocsafe_scenario.blocks.simulation import sensor_parameters
from rocsafe_scenario.blocks.vehicles import LINK_KEYS, PLANNING_KEYS, VehicleBlock
from rocsafe_scenario.scenario import Scenario

Parameters = dict[str, Any]

FIELD, RECORDER, FLEET, BRIDGE = 'radiation_field', 'recorder', 'fleet', 'bridge'
LOCALIZER, AIR, AGENTS = 'localizer', 'air', 'agents'
LOCK_STEP = {'lock_step': True}
# A route tells the speed of each line; none is faster.
FASTEST_DRIVE_MPS = 1.5
# Where the head of several hosts takes photographs from the others.
PHOTOGRAPHS_PORT = 47612
# Where agents listen with Zenoh.
AGENTS_PORT = 47613


def planner_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the planner."""
    parameters: Parameters = {
        'grid': scenario.survey.grid,
        'max_viewpoints': scenario.survey.max_viewpoints,
        'export_directory': str(run.path),
    }
    if scenario.survey.effort.method:
        parameters['default_method'] = scenario.survey.effort.method
    return parameters


def world_parameters(scenario: Scenario) -> Parameters:
    """Return the parameters of the world: time stands still until the routes are accepted.

    Not where a real vehicle takes part: time runs as on the wall then, and does not wait.
    """
    is_real = bool(scenario.real_names)
    return {
        'step_s': scenario.clock.step_s,
        'speed': 1.0 if is_real else scenario.clock.speed,
        'start_time_s': scenario.clock.start.timestamp(),
        'participants': _participants(scenario),
        'autostart': is_real,
        'pause_when_idle': not is_real,
        'pause_on_news': not (is_real or scenario.fleet.agents) and scenario.replan == 'on_loss',
        'scene': scenario.scene,
    }


def rav_parameters(scenario: Scenario, vehicle: VehicleBlock, run: RunDirectory) -> Parameters:
    """Return the parameters of the process of one simulated vehicle."""
    return {
        'home_latitude_deg': vehicle.home[0],
        'home_longitude_deg': vehicle.home[1],
        **_vehicle_model(scenario, vehicle, run),
        'spool_directory': str(run.spool / vehicle.name),
    }


def fleet_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the one process of all simulated vehicles, which are alike."""
    return {
        'fleet_file': {
            'vehicles': [
                {'name': vehicle.name, 'home': vehicle.home} for vehicle in scenario.simulated
            ]
        },
        **_vehicle_model(scenario, scenario.simulated[0], run),
        'spool_directory': str(run.spool),
    }


def bridge_parameters(
    scenario: Scenario,
    state_directory: str,
    linked: tuple[VehicleBlock, ...],
    driver: GroundVehicleBlock | None = None,
) -> Parameters:
    """Return the parameters of the bridge to some real vehicles, and to a ground vehicle."""
    drones = [
        {
            'name': vehicle.name,
            'link': vehicle.link,
            'speed_mps': vehicle.cruise_speed_mps,
            'hover_s': vehicle.hover_s,
            'endurance_s': vehicle.endurance_s,
            **vehicle.drone.model_dump(exclude={'detector'}),
        }
        for vehicle in linked
    ]
    if driver is not None:
        drones.append(
            {
                'name': driver.name,
                'link': driver.link,
                'speed_mps': FASTEST_DRIVE_MPS,
                'endurance_s': driver.endurance_s,
                'drives': True,
                **driver.drone.model_dump(exclude={'detector'}),
            }
        )
    return {
        'drones_file': {'drones': drones},
        'state_directory': state_directory,
        'needs_supervisor': True,
        'max_height_agl_m': scenario.survey.airspace.max_height_agl_m,
        'separation_m': scenario.survey.separation.distance_m,
        'camera_horizontal_fov_deg': scenario.camera.horizontal_fov_deg,
        **origin_parameters(scenario),
    }


def localizer_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the localizer, which is not told of the sources."""
    radiation = scenario.radiation
    search = radiation.search.model_dump(exclude={'extra_rounds', 'viewpoints_a_round'})
    levels = {
        key: list(value) if isinstance(value, tuple) else value
        for key, value in radiation.levels.model_dump(exclude={'contamination_usvh'}).items()
    }
    return {
        'vehicles': list(scenario.all_names),
        'model': radiation.estimator_model,
        'detector': radiation.detector,
        **search,
        **levels,
        'spool_directory': str(run.spool / LOCALIZER),
        **({'export_directory': str(run.hazard)} if scenario.driver_name else {}),
        **known_terrain_parameters(scenario, run),
        **origin_parameters(scenario),
    }


def collector_parameters(scenario: Scenario, run: RunDirectory, host: str = '') -> Parameters:
    """Return the parameters of the image store of a host; without a name: of the head.

    An engine's camera knows what it shows. Photographs of other hosts are copied to the head.
    """
    own = host or scenario.head
    driver = [scenario.driver_name] if scenario.driver_name and own == scenario.head else []
    values = {
        'vehicles': [n for n in scenario.vehicle_names if scenario.host_of(n) == own] + driver,
        'store_directory': str(run.images),
        'store_labels': scenario.camera.backend == 'engine',
    }
    if not scenario.hosts:
        return values
    address, token = scenario.hosts[0].address, str(run.photographs_token)
    if own == scenario.head:
        serving = {'serve_host': address, 'serve_port': PHOTOGRAPHS_PORT}
        return {**values, **serving, 'serve_token_file': token}
    url = f'http://{address}:{PHOTOGRAPHS_PORT}'
    return {**values, 'copy_to': url, 'copy_token_file': token}


def mosaic_parameters(run: RunDirectory) -> Parameters:
    """Return the parameters of the map maker."""
    return {'store_directory': str(run.images), 'output_path': str(run.mosaic)}


def fleet_verbs_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the node that commands all vehicles at once."""
    return {'vehicles': list(scenario.vehicle_names), 'mission': run.name}


def airsim_parameters(scenario: Scenario, host: str, port: int) -> Parameters:
    """Return the parameters of the server of AirSim's API."""
    vehicles = list(scenario.vehicle_names)
    return {'host': host, 'port': port, 'vehicles': vehicles, **origin_parameters(scenario)}


def host_names(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of the hosts, one empty name if all is on one machine."""
    return tuple(host.name for host in scenario.hosts) or ('',)


def name_on(scenario: Scenario, process: str, host: str) -> str:
    """Return the name of a process that several hosts have."""
    return process if host == scenario.head else f'{process}_{host}'


def agent_parameters(scenario: Scenario, run: RunDirectory, host: str = '') -> Parameters:
    """Return the parameters of the agents of the vehicles of a host; no name: of the head."""
    own = host or scenario.head
    vehicles = [n for n in scenario.vehicle_names if scenario.host_of(n) == own]
    simulated = [v.name for v in scenario.simulated if v.name in vehicles]
    is_apart = scenario.simulation.processes != FLEET
    return {
        'vehicles': vehicles,
        'real_vehicles': list(scenario.real_names),
        'mission': run.name,
        'plan_file': str(run.plan),
        'terrain_file': scenario.survey.terrain_file,
        'batteries_file': _batteries(scenario),
        **_search_parameters(scenario, run),
        'state_directory': str(run.path / AGENTS),
        'lock_step': not scenario.real_names,
        'participants': simulated if is_apart else [],
        'others': _participants_elsewhere(scenario, own),
        **_link_parameters(scenario, own),
    }


def _batteries(scenario: Scenario) -> Parameters:
    """Return the flight times of all batteries, of which the first plan leaves some."""
    return {
        'vehicles': [
            {'name': v.name, 'endurance_s': v.endurance_s, 'usable_s': v.usable_endurance_s}
            for v in scenario.vehicles
        ]
    }


def _search_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return how agents search after the survey, with the estimator of the localizer."""
    search = scenario.radiation.search
    if not search.extra_rounds:
        return {}
    localizer = localizer_parameters(scenario, run)
    for own in ('spool_directory', 'export_directory'):
        localizer.pop(own, None)
    rounds = search.model_dump(include={'extra_rounds', 'viewpoints_a_round'})
    return {'search_file': {**rounds, 'localizer': localizer}}


def _link_parameters(scenario: Scenario, own: str) -> Parameters:
    """Return how agents of different hosts reach each other."""
    if scenario.fleet.link == 'dds':
        return {}
    # A host without vehicles has no agents.
    with_agents = {scenario.host_of(name) for name in scenario.vehicle_names}
    addresses = {
        host.name: f'{host.address}:{AGENTS_PORT}'
        for host in scenario.hosts
        if host.name in with_agents
    }
    listen = addresses.pop(own, '')
    return {
        'link': scenario.fleet.link,
        'link_listen': listen,
        'link_peers': list(addresses.values()),
    }


def _participants_elsewhere(scenario: Scenario, own: str) -> list[str]:
    """Return who takes part in simulated time on other hosts than this."""
    places = {name_on(scenario, AGENTS, h): h for h in host_names(scenario)}
    places.update((name, scenario.host_of(name)) for name in scenario.vehicle_names)
    places.update((name, host.name) for host in scenario.hosts for name in host.runs)
    return [n for n in _participants(scenario) if places.get(n, scenario.head) != own]


def recorder_parameters(scenario: Scenario, run: RunDirectory) -> Parameters:
    """Return the parameters of the recorder."""
    return {
        'output_directory': str(run.path),
        'vehicles': list(scenario.all_names),
        'other_cameras': [camera.name for camera in scenario.other_cameras],
        'real_vehicles': list(scenario.real_names),
        **LOCK_STEP,
    }


def write_parameters(path: Path, node: str, parameters: Mapping[str, Any]) -> None:
    """Write the ROS parameter file of `node`, a full name such as ``/rav1/rav``, to `path`.

    A value that is a mapping, e.g. of ``cameras_file``, is written to a YAML file of its own
    beside it, ``rav1-cameras.yaml``, and the parameter is the path of that file. Empty lists are
    left out: they have no type of their own in a parameter file, and every such parameter is
    empty by default.
    """
    given = {
        key: _write_value_file(path, key, value) if isinstance(value, Mapping) else value
        for key, value in parameters.items()
        if value != []
    }
    content = {node: {'ros__parameters': given}}
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding='utf-8')


def _write_value_file(parameter_file: Path, key: str, values: Mapping[str, Any]) -> str:
    """Write the nested settings of parameter `key` and return the path of their file."""
    path = parameter_file.with_name(f'{parameter_file.stem}-{key.removesuffix("_file")}.yaml')
    path.write_text(yaml.safe_dump(dict(values), sort_keys=False), encoding='utf-8')
    return str(path)


def _air(scenario: Scenario) -> list[str]:
    return [AIR] if scenario.air.is_used else []


def _participants(scenario: Scenario) -> list[str]:
    """Return who takes part in simulated time."""
    hosts = host_names(scenario)
    agents = [
        name_on(scenario, AGENTS, host)
        for host in hosts
        if scenario.fleet.agents
        and any(scenario.host_of(n) == host for n in scenario.vehicle_names)
    ]
    return [*_vehicle_participants(scenario), *agents, FIELD, *_air(scenario), RECORDER]


def _vehicle_participants(scenario: Scenario) -> list[str]:
    is_fleet = scenario.simulation.processes == 'fleet'
    names = [vehicle.name for vehicle in scenario.simulated]
    is_simulated = scenario.driver_name and scenario.driver_name not in scenario.real_names
    driver = [scenario.driver_name] if is_simulated else []
    return [*([FLEET] if is_fleet and names else names), *driver]


def _vehicle_model(scenario: Scenario, vehicle: VehicleBlock, run: RunDirectory) -> Parameters:
    """Return what a vehicle can do and what its sensors are like."""
    own_keys = {'name', 'home', 'autopilot', *PLANNING_KEYS, *LINK_KEYS}
    simulation = scenario.simulation.model_dump(exclude={'processes', 'sensors'})
    return {
        **vehicle.model_dump(exclude=own_keys),
        'autopilot_file': vehicle.autopilot.model_dump(),
        'hover_power_w': vehicle.hover_power_w,
        'wind_east_mps': scenario.survey.airspace.wind_mps[0],
        'wind_north_mps': scenario.survey.airspace.wind_mps[1],
        **({} if scenario.air.wind.is_steady else {'wind_file': wind_settings(scenario, run)}),
        **simulation,
        **sensor_parameters(scenario.simulation.sensors),
        **camera_parameters(scenario.camera, scenario.other_cameras),
        'scene': scenario.scene,
        'scene_start_s': scenario.clock.start.timestamp(),
        'seed': scenario.seed,
        **origin_parameters(scenario),
        **LOCK_STEP,
    }


def origin_parameters(scenario: Scenario) -> Parameters:
    """Return the origin of the local frame."""
    origin = scenario.origin_position()
    return {
        'origin_latitude_deg': origin.latitude_deg,
        'origin_longitude_deg': origin.longitude_deg,
        'origin_altitude_m': origin.altitude_m,
    }
