# SPDX-License-Identifier: Apache-2.0
"""Scenario files: what is read from them, and what is refused with which line."""

import json
import os
import re
from collections.abc import Callable
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, get_args

import pytest
from pydantic import BaseModel

from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario

SHIPPED = sorted((Path(__file__).parents[2] / 'config' / 'scenarios').glob('*.yaml'))
BOW_TIE = [[53.28, -9.06], [53.281, -9.062], [53.281, -9.06], [53.28, -9.062]]
ANTIMERIDIAN = [[53.28, 179.999], [53.281, 179.999], [53.281, -179.999]]
POLE = [[89.99, 0.0], [89.99, 90.0], [89.99, 180.0]]
COUNTRY = [[53.2, -9.1], [53.3, -9.1], [53.3, -8.9], [53.2, -8.9]]

WALL = {
    'material': 'iron', 'position': [53.28, -9.06], 'length_m': 1.0, 'width_m': 1.0,
    'height_m': 1.0,
}  # fmt: skip
SPILL = {'name': 'spill', 'sigma_usvps': 1.0}
STOP = {'time_s': 5.0, 'position': [53.28, -9.06]}

# Key path, value, what the line says of them.
REFUSED = [
    ('vehicles[1].home[0]', 95.3, 'latitude must be within -90 to 90'),
    ('vehicles[0].home[1]', 200, 'longitude must be within -180 to 180'),
    ('region.polygon[2][0]', -91.0, 'latitude must be within -90 to 90'),
    ('vehicles', [], 'must have at least 1, has 0'),
    ('vehicles[1].name', 'rav1', 'is given 2 times, must be unique'),
    ('vehicles[1].name', 'rav 1', 'a vehicle name is a ROS namespace: a letter, then'),
    ('vehicles[1].name', '2rav', 'a vehicle name is a ROS namespace: a letter, then'),
    ('vehicles[1].name', 'dröne', 'a vehicle name is a ROS namespace: ASCII'),
    ('vehicles[1].name', 'rav__1', 'a vehicle name is a ROS namespace: ASCII, no __'),
    ('vehicles[1].name', 'world', 'is the name of a ROCSAFE node or topic'),
    ('vehicles[1].cruise_speed_mps', 0, 'must be greater than 0'),
    ('vehicles[1].home', [-9.06, 53.28], 'is 9'),
    ('survey.height_agl_m', -32.0, 'must be greater than 0'),
    ('survey.height_agl_m', '32', 'must be a valid number'),
    ('survey.height_agl_m', float('nan'), 'must be a finite number'),
    ('survey.overlap_fraction', 1.0, 'must be less than or equal to 0.95'),
    ('survey.spacing_rule', 'paper', "must be 'iou' or 'linear'"),
    ('survey', 32.0, 'must be a block of keys'),
    ('region.polygon', [[53.28, -9.06]], 'must have at least 3, has 1'),
    ('seed', -1, 'must be greater than or equal to 0'),
    ('seed', True, 'must be a valid integer'),
    ('name', '../up', 'must match'),
    ('clock.start', 'noon', 'must be a valid datetime'),
    ('clock.start', '1066-10-14T09:00:00Z', 'must be within 1970-01-01 to 2038-01-01'),
    ('clock.start', '2038-01-19T03:14:00Z', 'must be within 1970-01-01 to 2038-01-01'),
    ('clock.start', '0001-01-01T00:00:00+12:00', 'must be within the years 1 to 9999'),
    ('clock.start', '2025-06-01T10:00:00', 'must say its time zone'),
    ('camera.ground', 'no.tif', 'must be scene or the path of a GeoTIFF; no such file'),
    ('survey.terrain_file', 'no.tif', 'must be the path of a GeoTIFF of heights; no such file'),
    ('camera.effects.vignetting', 2.0, 'must be less than or equal to 1'),
    ('camera.gimbal', 1, 'must be a valid boolean'),
    ('radiation.sources[0].sigma_usvps', -1.0, 'must be greater than 0'),
    ('radiation.sources[0].position', [0.0, -9.061], 'is 590'),
]

DRIVER = {'name': 'rgv1', 'home': [53.28, -9.06], 'dose_budget_usv': 60.0}
# Key path, value, the line: mistakes without a single value.
REFUSED_BLOCKS = [
    ('other_cameras', [{'name': 'camera'}], "other_cameras[0].name = 'camera': is taken"),
    ('other_cameras', [{'name': 'a b'}], "other_cameras[0].name = 'a b': must match"),
    ('other_cameras', [{'pitch_deg': 9.0}], 'other_cameras[0].name: is missing'),
    ('sede', 3, 'sede: unknown key (did you mean seed?)'),
    ('survey.hight_agl_m', 3.0, 'survey.hight_agl_m: unknown key (did you mean height_agl_m?)'),
    ('vehicles[1].colour', 'red', 'vehicles[1].colour: unknown key (known: name, home, '),
    ('survey', {}, 'survey.height_agl_m: is missing'),
    ('survey.separation_m', 9.0, 'survey.separation_m: is now survey.separation.distance_m'),
    ('survey.wind_mps', [1.0, 0.0], 'survey.wind_mps: is now survey.airspace.wind_mps'),
    ('survey.budget_s', 9.0, 'survey.budget_s: is now survey.effort.budget_s'),
    ('radiation.sources[0].activity_gbq', 5.0, 'radiation.sources[0]: must have sigma_usvps or'),
    ('radiation.sources[0].line', [[53.28, -9.06]], 'must have one of position, line, area'),
    ('radiation.shields', [WALL], "radiation.model = 'paper': must be shielded where there are"),
    ('radiation.scene_file', 'gone.yaml', "radiation.scene_file = 'gone.yaml': must be the path"),
    (
        'ground_vehicle',
        {**DRIVER, 'labels_file': 'no.tif'},
        "ground_vehicle.labels_file = 'no.tif': must be the path of a GeoTIFF of labels; no such",
    ),
    ('ground_vehicle', {**DRIVER, 'turn_back_ppm': 2.0}, 'turn_back_ppm = 2: needs air.gas_sens'),
    (
        'ground_vehicle',
        {**DRIVER, 'turn_back_ppm': 2.0, 'link': 'udp://127.0.0.1:14560'},
        'turn_back_ppm = 2: must be left out, no gas sensor of a real ground vehicle is read',
    ),
    ('camera', {'backend': 'engine', 'scene_file': 'no.yaml'}, 'must be the path of a scene; no '),
    (
        'radiation',
        {'model': 'shielded', 'shields': [{**WALL, 'wall_m': 0.5}]},
        'radiation.shields[0].wall_m = 0.5: must be less than half the shortest side, 0.5',
    ),
    (
        'radiation.sources[0]',
        {**SPILL, 'line': [[53.28, -9.06]]},
        'line: has 1 corners, must have',
    ),
    ('radiation.sources[0]', {**SPILL, 'area': [[53.28, -9.06]]}, 'area: has 1 corners, must'),
    (
        'radiation.sources[0]',
        {**SPILL, 'track': [STOP, STOP]},
        'radiation.sources[0].track: time_s = [5.0, 5.0] must rise from stop to stop',
    ),
    ('radiation.sources[0].nuclide', 'Xx-1', "radiation.sources[0].nuclide = 'Xx-1': must be 'Am"),
    ('region.polygon', BOW_TIE, 'region.polygon: the boundary crosses or touches itself near'),
    ('region.polygon', ANTIMERIDIAN, 'must not cross the antimeridian (180 deg)'),
    ('region.polygon', POLE, 'the boundary has a corner at latitude 89.99 deg'),
    ('region.polygon', COUNTRY, 'must be at most survey.max_viewpoints = 100000'),
    ('region.holes', [BOW_TIE], 'region.polygon: hole 1 crosses or touches itself'),
    ('region', {'file': 'no.kml'}, "small.yaml: region.file = 'no.kml': "),
    ('region', {}, 'region: must have either polygon or file'),
    ('exclusions', [{'polygon': BOW_TIE}], 'exclusions[0].polygon: the boundary crosses or'),
    ('exclusions', [{'file': 'no.kml'}], "small.yaml: exclusions[0].file = 'no.kml': "),
    ('origin.latitude_deg', 53.28, 'origin: must have both latitude_deg and longitude_deg'),
]


@pytest.mark.parametrize('path', SHIPPED, ids=lambda path: path.stem)
def test_shipped_scenario_is_valid_and_named_as_its_file(path: Path) -> None:
    """Every scenario in config/scenarios can be flown."""
    assert read_scenario(path).name == path.stem


def keys_of(block: Any) -> set[str]:
    """Return the keys of a block of a scenario, and of those in it."""
    if isinstance(block, type) and issubclass(block, BaseModel):
        fields = block.model_fields.items()
        return {key for name, field in fields for key in (name, *keys_of(field.annotation))}
    return {key for part in get_args(block) for key in keys_of(part)}


def test_every_key_is_explained() -> None:
    """In a shipped scenario or in the documentation."""
    docs = Path(__file__).parents[2] / 'docs'
    texts = [path.read_text() for path in (*SHIPPED, *docs.glob('*.md'))]
    words = set(re.findall(r'\w+', ' '.join(texts)))
    assert keys_of(Scenario) - words == set()


@pytest.mark.slow
@pytest.mark.parametrize('path', SHIPPED, ids=lambda path: path.stem)
def test_scenario_survives_being_written_and_read(
    path: Path, scenario_text: Callable[[str], Path]
) -> None:
    """The copy in a run directory flies the same mission."""
    scenario = read_scenario(path)
    assert read_scenario(scenario_text(scenario.to_yaml())) == scenario


@pytest.mark.parametrize('text', ['2025-07-01T12:00:00Z', '2025-07-01 14:00:00+02:00'])
def test_quoted_time_is_taken(text: str, small: Callable[..., Path]) -> None:
    """As YAML takes it without quotes."""
    scenario = read_scenario(small({'clock.start': text}))
    assert scenario.clock.start == datetime(2025, 7, 1, 12, tzinfo=timezone.utc)


@pytest.mark.parametrize(('path', 'value', 'limit'), REFUSED)
def test_wrong_value_is_named_with_its_limit(
    path: str, value: object, limit: str, small: Callable[..., Path]
) -> None:
    """A wrong value is refused in one line: file, key path, value, limit."""
    with pytest.raises(ScenarioError) as caught:
        read_scenario(small({path: value}))
    assert str(caught.value).startswith(f'small.yaml: {path} = {value!r}: {limit}')
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(('path', 'value', 'line'), REFUSED_BLOCKS)
def test_mistake_is_named_in_one_line(
    path: str, value: object, line: str, small: Callable[..., Path]
) -> None:
    """What is wrong with a key or a whole block is said in one line."""
    with pytest.raises(ScenarioError) as caught:
        read_scenario(small({path: value}))
    assert line in str(caught.value)
    assert '\n' not in str(caught.value)


def test_without_a_camera_there_are_no_other_cameras(small: Callable[..., Path]) -> None:
    """Simulated vehicles without one take no photographs."""
    assert read_scenario(small({})).has_cameras
    bare: dict[str, object] = {'camera': {'backend': 'none'}}
    assert not read_scenario(small(bare)).has_cameras
    with pytest.raises(ScenarioError, match='other_cameras: has 1 entries, must be empty with'):
        read_scenario(small({**bare, 'other_cameras': [{'name': 'front'}]}))


def test_gusts_that_vehicles_cannot_hold_are_refused(small: Callable[..., Path]) -> None:
    """Two standard deviations on top of the wind, for each vehicle."""
    with pytest.raises(ScenarioError) as caught:
        read_scenario(small({'air.wind': {'gust_std_mps': 6.0}}))
    for number, line in enumerate(str(caught.value).splitlines()):
        assert f'vehicles[{number}] in survey.airspace.wind_mps with gusts of air.wind' in line


@pytest.mark.parametrize(
    ('record', 'line'),
    [
        ('time_s,wind_speed_mps,wind_from_deg\n0,3,250\n9,40,250\n', 'in air.wind.record_file: '),
        ('time_s,wind_speed_mps,direction\n0,3,250\n', 'column direction does not say whether'),
        ('time_s,wind_speed_mps,wind_from_deg\n9,3,250\n0,3,250\n', 'must ascend'),
        ('', 'air.wind.record_file'),
    ],
)
def test_a_record_that_does_not_fit_is_refused(
    small: Callable[..., Path], record: str, line: str
) -> None:
    """Too strong for a vehicle, of unknown convention, out of order, empty: a line each."""
    path = small({'air.wind': {'record_file': 'wind.csv'}})
    path.with_name('wind.csv').write_text(record)
    with pytest.raises(ScenarioError) as caught:
        read_scenario(path)
    assert all(line in each for each in str(caught.value).splitlines())


def test_files_of_the_wind_are_named_from_the_scenario(small: Callable[..., Path]) -> None:
    """They become absolute; a scene needs a wind, whose wakes it has."""
    path = small({'air.wind': {'record_file': 'wind.csv'}})
    with pytest.raises(ScenarioError, match=r"air.wind.record_file = 'wind.csv': .*no such file"):
        read_scenario(path)
    record = path.with_name('wind.csv')
    record.write_text('time_s,wind_towards_east_mps,wind_towards_north_mps\n0,1,2\n')
    assert read_scenario(path).air.wind.record_file == str(record)
    scene = path.with_name('scene.yaml')
    scene.write_text('name: scene\n')
    with pytest.raises(ScenarioError, match=r'must be at least 0.5 m/s with air.wind.scene'):
        read_scenario(small({'air.wind': {'scene_file': scene.name}}))


def test_every_mistake_gets_its_line(small: Callable[..., Path]) -> None:
    """Two mistakes are named in two lines."""
    with pytest.raises(ScenarioError) as caught:
        read_scenario(small({'seed': -1, 'survey.height_agl_m': 0.0}))
    assert len(str(caught.value).splitlines()) == 2


@pytest.mark.parametrize(
    ('text', 'line'),
    [
        ('name: small\nregion: [1, 2\nsurvey: 3\n', 'small.yaml: line 3: '),
        ('name: small\nname: other\n', "small.yaml: line 2: key 'name' is given twice"),
        ('name: small\nseed:\t3: 4\n', 'small.yaml: line 2: '),
        ('name: !!python/object:os.system {}\n', 'small.yaml: line 1: could not determine'),
        ('- 1\n', 'small.yaml: must be a block of keys'),
        ('', 'small.yaml: must be a block of keys'),
    ],
)
def test_syntax_error_is_named_with_its_line(
    text: str, line: str, scenario_text: Callable[[str], Path]
) -> None:
    """What is not the YAML of a scenario is refused with the number of the line."""
    with pytest.raises(ScenarioError) as caught:
        read_scenario(scenario_text(text))
    assert str(caught.value).startswith(line)
    assert '\n' not in str(caught.value)


def test_missing_file_directory_and_binary_are_refused(tmp_path: Path) -> None:
    """A path that cannot be read is named with the reason."""
    binary = tmp_path / 'binary.yaml'
    binary.write_bytes(b'name: \xff\xfe')
    for path, reason in (
        (tmp_path / 'no.yaml', 'no such file'),
        (tmp_path, 'is a directory'),
        (binary, 'not a text file in UTF-8'),
    ):
        with pytest.raises(ScenarioError, match=reason):
            read_scenario(path)


@pytest.mark.skipif(os.geteuid() == 0, reason='root may read every file')
def test_file_without_permission_is_refused(small: Callable[..., Path]) -> None:
    """A file that may not be read is named as such."""
    path = small()
    path.chmod(0)
    with pytest.raises(ScenarioError, match='permission denied'):
        read_scenario(path)


def test_command_line_replaces_speed_and_seed(small: Callable[..., Path]) -> None:
    """`--speed` and `--seed` win over the file."""
    scenario = read_scenario(small(), speed=2.5, seed=7)
    assert (scenario.clock.speed, scenario.seed) == (2.5, 7)


def test_region_file_becomes_the_polygon(small: Callable[..., Path], tmp_path: Path) -> None:
    """A GeoJSON region, longitude first, lies beside the scenario and becomes part of it."""
    ring = [[-9.06, 53.28], [-9.06, 53.281], [-9.062, 53.281], [-9.06, 53.28]]
    polygon = {'type': 'Polygon', 'coordinates': [ring]}
    (tmp_path / 'field.geojson').write_text(json.dumps(polygon))
    region = read_scenario(small({'region': {'file': 'field.geojson'}})).region
    assert region.file is None
    assert region.polygon == ((53.28, -9.06), (53.281, -9.06), (53.281, -9.062))


def test_origin_is_the_centroid_on_the_ground(small: Callable[..., Path]) -> None:
    """Without an origin the frame stands at the centre of the region."""
    scenario = read_scenario(small({'origin.ground_altitude_m': 66.0}))
    origin = scenario.origin_position()
    assert origin.latitude_deg == pytest.approx(53.2805, abs=1e-6)
    assert origin.longitude_deg == pytest.approx(-9.061, abs=1e-6)
    assert origin.altitude_m == 66.0


def test_number_in_exponent_form_is_a_number(
    small: Callable[..., Path], scenario_text: Callable[[str], Path]
) -> None:
    """1e3 is a number here, though YAML 1.1 would take it for a text."""
    text = small().read_text().replace('25.0', '1e3')
    sources = read_scenario(scenario_text(text)).radiation.sources
    assert sources[0].sigma_usvps == 1000.0


@pytest.mark.parametrize(
    ('sensors', 'line'),
    [
        ({'lidar': {}}, 'sensors.lidar: unknown key (known: imu, barometer, magnetometer, range)'),
        ({'imu': {'rate_hz': 1e4}}, 'imu.rate_hz = 10000.0: must be less than or equal to 400'),
        ({'range': {'min_m': 15.0}}, 'sensors.range: min_m is 15: must be below max_m, 12'),
    ],
)
def test_wrong_sensors_are_refused(
    sensors: dict[str, Any], line: str, small: Callable[..., Path]
) -> None:
    """One line names file, key, value and limit."""
    with pytest.raises(ScenarioError, match=re.escape(line)):
        read_scenario(small({'simulation.sensors': sensors}))


def test_many_vehicles_share_a_process(small: Callable[..., Path]) -> None:
    """DDS does not find more than some thirty processes on a machine: a fleet flies in one."""
    vehicles = [{'name': f'rav{n}', 'home': [53.2795, -9.061]} for n in range(21)]
    with pytest.raises(ScenarioError, match='vehicles = 21 of them: must be at most 20'):
        read_scenario(small({'vehicles': vehicles}))
    fleet = {'vehicles': vehicles, 'simulation.processes': 'fleet'}
    assert len(read_scenario(small(fleet)).vehicles) == 21


def test_fleet_in_one_process_is_alike(small: Callable[..., Path]) -> None:
    """One process simulates vehicles of one kind; another kind is named."""
    changes = {'vehicles[1].hover_s': 3.0, 'simulation.processes': 'fleet'}
    with pytest.raises(ScenarioError, match=r'vehicles\[1\].hover_s = 3.0: must be 1.0'):
        read_scenario(small(changes))


def test_exclusions_reach_the_planner(small: Callable[..., Path]) -> None:
    """A zone of the file is in the request for a plan without flying."""
    zone = [[53.2796, -9.0632], [53.2797, -9.0632], [53.2797, -9.0633]]
    scenario = read_scenario(small({'exclusions': [{'polygon': zone}]}))
    (area,) = scenario.exclusion_areas()
    assert [[c.latitude_deg, c.longitude_deg] for c in area.boundary] == zone


@pytest.mark.parametrize(
    ('second', 'line'),
    [
        ({}, r'vehicles\[1\].drone.system = 1: rav1 has it on the same link, must differ'),
        ({'system': 2, 'unsigned': True}, r'vehicles\[1\].drone.signing_key_file and unsigned: '),
        ({'system': 2}, ''),
        ({'component': 2}, ''),
    ],
)
def test_two_autopilots_on_a_link_must_be_told_apart(
    second: dict[str, Any], line: str, small: Callable[..., Path]
) -> None:
    """`rocsafe run` would refuse them, and only after the plan was confirmed."""
    link = 'udp://127.0.0.1:14550'
    changes = {f'vehicles[{n}].link': link for n in (0, 1)}
    path = small({**changes, 'vehicles[1].drone': second})
    if not line:
        assert len(read_scenario(path).linked) == 2
        return
    with pytest.raises(ScenarioError, match=line):
        read_scenario(path)


@pytest.mark.parametrize(('folder', 'has_cameras'), [('', False), ('/data/camera', True)])
def test_real_vehicles_have_a_camera_where_its_images_come_in(
    folder: str, has_cameras: bool, small: Callable[..., Path]
) -> None:
    """Those that carry a detector alone owe no photographs."""
    changes: dict[str, object] = {}
    for number in (0, 1):
        changes[f'vehicles[{number}].link'] = f'udp://127.0.0.1:{14550 + number}'
        changes[f'vehicles[{number}].drone'] = {'image_folder': folder}
    assert read_scenario(small(changes)).has_cameras is has_cameras
    assert read_scenario(small({})).has_cameras
