# SPDX-License-Identifier: Apache-2.0
"""Checks across the blocks of a scenario: polygons, names, distances, size of the survey."""

import math
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.position import distance_m
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.wind.anemometer_file import read_wind
from rocsafe_geo.wind.mission_wind import LEAST_WIND_MPS
from rocsafe_scenario.blocks.cameras import FIRST_CAMERA
from rocsafe_scenario.blocks.ground_vehicle import GroundVehicleBlock
from rocsafe_scenario.blocks.vehicles import PLANNING_KEYS, VehicleBlock
from rocsafe_scenario.host_checks import host_mistakes
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.survey_size import fewest_viewpoints

# Beyond this distance the error of the flat local frame exceeds the noise of a GPS fix.
LARGEST_DISTANCE_M = 20_000.0
# On one machine DDS finds 32 participants; a mission has a dozen besides its vehicles.
MOST_VEHICLE_PROCESSES = 20
# A proposal of the agents names all vehicles in one packet.
MOST_AGENTS = 20


def mistakes(scenario: Scenario) -> list[str]:
    """Return one line for each mistake of `scenario`, naming key path, value and limit."""
    lines = [
        *_double_names(scenario),
        *_double_cameras(scenario),
        *_unequal_fleet(scenario),
        *_missing_homes(scenario),
        *_unreal_time(scenario),
        *_double_autopilots(scenario),
        *_too_many_processes(scenario),
        *_half_origin(scenario),
        *_unclear_strengths(scenario),
        *_two_ends(scenario),
        *_too_much_wind(scenario),
        *_missing_sensors(scenario),
        *_missing_gas_sensors(scenario),
        *_unclear_places(scenario),
        *_unused_shields(scenario),
        *_unclear_releases(scenario),
        *_unfit_for_agents(scenario),
        *host_mistakes(scenario),
    ]
    try:
        area = scenario.area()
    except ValueError as error:
        return [*lines, f'region.polygon: {error}']
    for areas in (scenario.exclusion_areas, scenario.other_areas):
        try:
            areas()
        except ValueError as error:
            lines.append(str(error))
    return [*lines, *_far_places(scenario, area), *_too_large(scenario, area)]


def _double_names(scenario: Scenario) -> Iterator[str]:
    for block, names in (
        ('vehicles', scenario.all_names),
        ('radiation.sources', tuple(source.name for source in scenario.radiation.sources)),
        ('air.releases', tuple(release.name for release in scenario.air.releases)),
    ):
        for name, count in Counter(names).items():
            if count > 1:
                index = [i for i, other in enumerate(names) if other == name][1]
                yield f'{block}[{index}].name = {name!r}: is given {count} times, must be unique'


def _double_cameras(scenario: Scenario) -> Iterator[str]:
    if scenario.other_cameras and scenario.camera.backend == 'none':
        count = len(scenario.other_cameras)
        yield f"other_cameras: has {count} entries, must be empty with camera.backend = 'none'"
    taken = [FIRST_CAMERA]
    for index, camera in enumerate(scenario.other_cameras):
        if camera.name in taken:
            yield f'other_cameras[{index}].name = {camera.name!r}: is taken, must be unique'
        taken.append(camera.name)


def _unequal_fleet(scenario: Scenario) -> Iterator[str]:
    """Refuse unlike vehicles in one process."""
    if scenario.simulation.processes != 'fleet':
        return
    simulated = [i for i, vehicle in enumerate(scenario.vehicles) if not vehicle.link]
    for index in simulated:
        first, vehicle = scenario.vehicles[simulated[0]], scenario.vehicles[index]
        for key in type(vehicle).model_fields:
            is_own = key in ('name', 'home', *PLANNING_KEYS)
            if not is_own and getattr(vehicle, key) != getattr(first, key):
                value, limit = getattr(vehicle, key), getattr(first, key)
                yield (
                    f'vehicles[{index}].{key} = {value}: must be {limit}, as of vehicles[0], '
                    'with simulation.processes = fleet'
                )


def _missing_homes(scenario: Scenario) -> Iterator[str]:
    for index, vehicle in enumerate(scenario.vehicles):
        if not vehicle.has_home and not vehicle.link:
            yield f'vehicles[{index}].home: must be given, or a link to a vehicle that tells it'


def _unreal_time(scenario: Scenario) -> Iterator[str]:
    speed = scenario.clock.speed
    if scenario.real_names and speed not in (0.0, 1.0):
        name = scenario.real_names[0]
        yield f'clock.speed = {speed:g}: must be 1, {name} is real (it has a link)'


def _double_autopilots(scenario: Scenario) -> Iterator[str]:
    """Refuse two real vehicles that cannot be told apart, or differ in what is of their link."""
    found: dict[tuple[str, int, int], str] = {}
    keys: dict[str, tuple[str, bool]] = {}
    blocks: list[tuple[str, VehicleBlock | GroundVehicleBlock]] = [
        (f'vehicles[{index}]', vehicle) for index, vehicle in enumerate(scenario.vehicles)
    ]
    if scenario.ground_vehicle:
        blocks.append(('ground_vehicle', scenario.ground_vehicle))
    for block, vehicle in blocks:
        if not vehicle.link:
            continue
        drone = vehicle.drone
        number = (vehicle.link, drone.system, drone.component)
        other = found.setdefault(number, vehicle.name)
        if other != vehicle.name:
            yield (
                f'{block}.drone.system = {drone.system}: {other} has it on the same '
                'link, must differ'
            )
        key = (drone.signing_key_file, drone.unsigned)
        if keys.setdefault(vehicle.link, key) != key:
            yield (
                f'{block}.drone.signing_key_file and unsigned: must be those of the '
                'other vehicles on its link'
            )


def _too_many_processes(scenario: Scenario) -> Iterator[str]:
    count = len(scenario.simulated)
    if scenario.simulation.processes == 'per_vehicle' and count > MOST_VEHICLE_PROCESSES:
        yield (
            f'vehicles = {count} of them: must be at most {MOST_VEHICLE_PROCESSES} with '
            'simulation.processes = per_vehicle; fleet flies more in one process'
        )


def _unfit_for_agents(scenario: Scenario) -> Iterator[str]:
    """Refuse agents where they could not keep vehicles apart, or would not be asked."""
    if not scenario.fleet.agents:
        return
    separation, count = scenario.survey.separation, len(scenario.vehicles)
    if separation.by != 'reserved':
        yield f'survey.separation.by = {separation.by!r}: must be reserved with fleet.agents'
    if separation.distance_m <= 0.0:
        yield 'survey.separation.distance_m = 0: must be positive with fleet.agents'
    if scenario.replan != 'on_loss':
        yield f'replan = {scenario.replan!r}: must be on_loss with fleet.agents'
    if count > MOST_AGENTS:
        yield f'vehicles = {count} of them: must be at most {MOST_AGENTS} with fleet.agents'
    if rounds := scenario.air.search.extra_rounds:
        yield f'air.search.extra_rounds = {rounds}: must be 0 with fleet.agents'
    if scenario.radiation.search.extra_rounds and not scenario.has_radiation:
        yield 'radiation.search.extra_rounds: needs a source, a background or a real detector'


def _two_ends(scenario: Scenario) -> Iterator[str]:
    for index, vehicle in enumerate(scenario.vehicles):
        if vehicle.is_open and vehicle.end is not None:
            yield f'vehicles[{index}]: has an end and is_open, must have one of them at most'


def _too_much_wind(scenario: Scenario) -> Iterator[str]:
    wind = scenario.air.wind
    try:
        strongest = _strongest_wind(scenario)
    except ValueError as error:
        yield f'air.wind.record_file: {error}'
        return
    rates = ('cruise_speed_mps', 'acceleration_mps2', 'climb_rate_mps', 'descent_rate_mps')
    for index, vehicle in enumerate(scenario.vehicles):
        try:
            Performance(
                **vehicle.model_dump(include=set(rates)),
                autopilot=Autopilot(**vehicle.autopilot.model_dump()),
                wind_mps=strongest,
            )
        except ValueError as error:
            key = 'air.wind.record_file' if wind.record_file else 'survey.airspace.wind_mps'
            gusts = ' with gusts of air.wind' if wind.gust_std_mps else ''
            yield f'vehicles[{index}] in {key}{gusts}: {error}'


def _strongest_wind(scenario: Scenario) -> tuple[float, float]:
    """Return the wind with gusts of two standard deviations along it, which vehicles must hold.

    Raises
    ------
    ValueError
        If the record of the wind cannot be read.
    """
    wind = scenario.air.wind
    east, north = scenario.survey.airspace.wind_mps
    if wind.record_file:
        recorded = read_wind(Path(wind.record_file)).strongest
        east, north = recorded.towards_east_mps, recorded.towards_north_mps
    speed, gust = math.hypot(east, north), 2.0 * wind.gust_std_mps
    return (east * (1.0 + gust / speed), north * (1.0 + gust / speed)) if speed else (gust, 0.0)


def _unclear_releases(scenario: Scenario) -> Iterator[str]:
    for index, release in enumerate(scenario.air.releases):
        if len(release.amounts) != 1 or not set(release.amounts) <= set(release.own_amounts):
            keys = ', '.join(release.own_amounts)
            yield f'air.releases[{index}]: needs exactly one of {keys} above 0'
        elif release.temperature_c is not None and not release.rate_g_s:
            yield f'air.releases[{index}].temperature_c: needs rate_g_s'
    speed = math.hypot(*scenario.survey.airspace.wind_mps)
    if scenario.air.releases and speed < LEAST_WIND_MPS:
        yield (
            f'survey.airspace.wind_mps = {speed:g} m/s: must be at least {LEAST_WIND_MPS:g} m/s '
            'with air.releases'
        )
    elif scenario.air.wind.scene_file and speed < LEAST_WIND_MPS:
        yield (
            f'survey.airspace.wind_mps = {speed:g} m/s: must be at least {LEAST_WIND_MPS:g} m/s '
            'with air.wind.scene_file'
        )
    air = scenario.air
    if air.search.extra_rounds and not (air.reads and air.anemometer):
        yield (
            'air.search.extra_rounds: needs air.gas_sensors or air.particle_counter, and '
            'air.anemometer'
        )


def _missing_sensors(scenario: Scenario) -> Iterator[str]:
    blocks = {'region': scenario.region}
    blocks |= {f'other_regions[{i}]': block for i, block in enumerate(scenario.other_regions)}
    for key, block in blocks.items():
        if not any(set(block.sensors) <= set(v.sensors) for v in scenario.vehicles):
            yield f'{key}.sensors = {list(block.sensors)}: no vehicle carries all of them'


def _missing_gas_sensors(scenario: Scenario) -> Iterator[str]:
    block = scenario.ground_vehicle
    if block is None or block.turn_back_ppm is None:
        return
    line = f'ground_vehicle.turn_back_ppm = {block.turn_back_ppm:g}: '
    if block.link:
        yield f'{line}must be left out, no gas sensor of a real ground vehicle is read'
    elif not scenario.air.gas_sensors:
        yield f'{line}needs air.gas_sensors, by which it turns back'


def _half_origin(scenario: Scenario) -> Iterator[str]:
    origin = scenario.origin
    if (origin.latitude_deg is None) != (origin.longitude_deg is None):
        yield 'origin: must have both latitude_deg and longitude_deg, or neither'


def _unclear_strengths(scenario: Scenario) -> Iterator[str]:
    for index, source in enumerate(scenario.radiation.sources):
        key = f'radiation.sources[{index}]'
        if (source.sigma_usvps is None) == (source.activity_gbq is None):
            yield f'{key}: must have sigma_usvps or activity_gbq, one of them'
        elif source.activity_gbq is not None and source.nuclide is None:
            yield f'{key}.nuclide: must be given with activity_gbq'


def _unclear_places(scenario: Scenario) -> Iterator[str]:
    for index, source in enumerate(scenario.radiation.sources):
        key = f'radiation.sources[{index}]'
        if len(source.shapes) != 1:
            yield f'{key}: must have one of position, line, area, track'
        elif 0 < len(source.line) < 2 or 0 < len(source.area) < 3:
            shape = source.shapes[0]
            fewest = 2 if shape == 'line' else 3
            yield f'{key}.{shape}: has {len(source.corners)} corners, must have at least {fewest}'
        times = [stop.time_s for stop in source.track]
        if any(later <= earlier for earlier, later in pairwise(times)):
            yield f'{key}.track: time_s = {times} must rise from stop to stop'


def _unused_shields(scenario: Scenario) -> Iterator[str]:
    radiation = scenario.radiation
    if radiation.shields and radiation.model != 'shielded':
        yield (
            f'radiation.model = {radiation.model!r}: must be shielded where there are '
            'radiation.shields'
        )
    if radiation.scene_file and radiation.model != 'shielded':
        yield (
            f'radiation.model = {radiation.model!r}: must be shielded where there is a '
            'radiation.scene_file'
        )
    for index, shield in enumerate(radiation.shields):
        thinnest_m = min(shield.length_m, shield.width_m, shield.height_m)
        if shield.wall_m >= thinnest_m / 2.0:
            yield (
                f'radiation.shields[{index}].wall_m = {shield.wall_m:g}: must be less than half '
                f'the shortest side, {thinnest_m / 2.0:g}'
            )


def _far_places(scenario: Scenario, area: SurveyArea) -> Iterator[str]:
    """Find swapped coordinates and missions that are too large for the flat frame."""
    centroid = area.centroid()
    places = {f'vehicles[{i}].home': v.home for i, v in enumerate(scenario.vehicles) if v.has_home}
    for index, source in enumerate(scenario.radiation.sources):
        key = f'radiation.sources[{index}]'
        places.update({f'{key}.{shape}': source.place for shape in source.shapes[:1]})
        if len(source.shapes) == 1 and source.corners:
            far = max(
                source.corners,
                key=lambda corner: distance_m(centroid, scenario.ground_position(corner)),
            )
            places[f'{key}.{source.shapes[0]}'] = far
    for index, shield in enumerate(scenario.radiation.shields):
        places[f'radiation.shields[{index}].position'] = shield.position
    if scenario.origin.latitude_deg is not None and scenario.origin.longitude_deg is not None:
        places['origin'] = (scenario.origin.latitude_deg, scenario.origin.longitude_deg)
    corners = enumerate(scenario.region.polygon or ())
    index, corner = max(
        corners, key=lambda item: distance_m(centroid, scenario.ground_position(item[1]))
    )
    places[f'region.polygon[{index}]'] = corner
    for key, place in places.items():
        distance = distance_m(centroid, scenario.ground_position(place))
        if distance > LARGEST_DISTANCE_M:
            yield (
                f'{key} = {list(place)}: is {distance / 1000:.1f} km from the centre of the '
                f'region, must be at most {LARGEST_DISTANCE_M / 1000:.0f} km'
            )


def _too_large(scenario: Scenario, area: SurveyArea) -> Iterator[str]:
    points = fewest_viewpoints(area, scenario.survey, scenario.camera)
    limit = scenario.survey.max_viewpoints
    if points > limit:
        yield (
            f'region.polygon: needs at least {points} viewpoints at survey.height_agl_m = '
            f'{scenario.survey.height_agl_m:g}, must be at most survey.max_viewpoints = {limit}'
        )


def flight_mistakes(scenario: Scenario) -> list[str]:
    """Return one line for each setting that can be planned but not flown by real vehicles."""
    lines = []
    for index, vehicle in enumerate(scenario.vehicles):
        for key in ('battery_swap_s', 'end', 'is_open', 'fails_after_s') if vehicle.link else ():
            value = getattr(vehicle, key)
            if value is not None and value is not False and value != 0.0:
                lines.append(
                    f'vehicles[{index}].{key} = {value}: is for plans and simulated vehicles; '
                    f'{vehicle.name} is real and flies once, from home to home'
                )
    return lines
