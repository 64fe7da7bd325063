# SPDX-License-Identifier: Apache-2.0
"""From a scenario to parameter files and commands."""

import os
from collections.abc import Callable
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import yaml
from test.planner.terrains import write_terrain

from rocsafe_dispersion.advisor_options import AdvisorOptions
from rocsafe_dispersion.air_field.air_file import AirFile
from rocsafe_dispersion.air_field.air_options import AirOptions
from rocsafe_dispersion.estimator_options import EstimatorOptions
from rocsafe_geo.motion.autopilot import ARDUCOPTER
from rocsafe_geo.storage.value_file import values_of
from rocsafe_geo.wind.mission_wind import WindSettings
from rocsafe_ground.options import RouterOptions
from rocsafe_interfaces.msg import Route, SurveyPlan, Viewpoint
from rocsafe_mapping.options import CollectorOptions, MosaicOptions
from rocsafe_orchestrator.errors import EXIT_SETUP, SetupError
from rocsafe_orchestrator.fleet_verbs_node import FleetVerbsOptions
from rocsafe_orchestrator.mission.closing import REPORT
from rocsafe_orchestrator.parameters.field_parameters import field_parameters
from rocsafe_orchestrator.parameters.goal_conversions import unseen_viewpoint
from rocsafe_orchestrator.parameters.node_parameters import localizer_parameters, write_parameters
from rocsafe_orchestrator.parameters.terrain_parameters import ground_options
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.process_table.launches import child_environment, launches
from rocsafe_orchestrator.process_table.scene_export import export_scenes
from rocsafe_orchestrator.process_table.table import ProcessSpec, crew_of, process_table
from rocsafe_orchestrator.recorder_node import RecorderOptions
from rocsafe_orchestrator.report.run_texts import what_is_simulated
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_planner.options import PlannerOptions
from rocsafe_radiation.detection.detector import DETECTOR_NAMES
from rocsafe_radiation.detection.survey_field import SurveyField
from rocsafe_radiation.detector_options import DetectorOptions
from rocsafe_radiation.field_parameters.field_making import survey_field
from rocsafe_radiation.field_parameters.field_options import FieldOptions
from rocsafe_radiation.localizer_options import LocalizerOptions
from rocsafe_radiation.physics.field import MODELS
from rocsafe_radiation.physics.nuclide import nuclide, nuclide_names
from rocsafe_radiation.physics.photons import AIR, materials
from rocsafe_ros.domain.mission_identity import new_identity
from rocsafe_scenario.blocks.radiation import Material, Nuclide, RadiationBlock
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario
from rocsafe_sim.driving.rgv_options import RgvOptions
from rocsafe_sim.options import FleetOptions, RavOptions, VehicleOptions, WorldOptions

OPTIONS: dict[str, Any] = {
    'air': AirOptions,
    'advisor': AdvisorOptions,
    'estimator': EstimatorOptions,
    'planner': PlannerOptions,
    'world': WorldOptions,
    'rav': RavOptions,
    'rgv': RgvOptions,
    'router': RouterOptions,
    'fleet': FleetOptions,
    'field': FieldOptions,
    'localizer': LocalizerOptions,
    'collector': CollectorOptions,
    'mosaic': MosaicOptions,
    'recorder': RecorderOptions,
    'fleet_verbs': FleetVerbsOptions,
}
MISSION = new_identity('run')
SCENE = Path(__file__).parents[2] / 'config/scenes/derailment.yaml'
FLEET = {'simulation.processes': 'fleet'}
GAS = {'air.gas_sensors': ['pid_10_6_ev'], 'air.search.extra_rounds': 1}


@pytest.fixture
def run(tmp_path: Path) -> RunDirectory:
    """Give an empty run directory."""
    directory = RunDirectory(tmp_path / 'run')
    directory.parameters.mkdir(parents=True)
    return directory


@pytest.fixture
def workspace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[tuple[ProcessSpec, ...]], Path]:
    """Give a function that installs empty executables for a table into a prefix of their own."""

    def install(table: tuple[ProcessSpec, ...]) -> Path:
        for spec in table:
            path = tmp_path / 'prefix' / 'lib' / spec.package / spec.executable
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch(mode=0o755)
        monkeypatch.setenv('AMENT_PREFIX_PATH', f'/nowhere{os.pathsep}{tmp_path / "prefix"}')
        return tmp_path / 'prefix'

    return install


DRIVE = {'ground_vehicle': {'name': 'rgv1', 'home': [53.2801, -9.061], 'dose_budget_usv': 100.0}}


@pytest.mark.parametrize(
    'changes', [{}, FLEET, GAS, DRIVE], ids=['per_vehicle', 'fleet', 'gas', 'drive']
)
def test_every_parameter_is_an_option_of_its_node(
    changes: dict[str, object], small: Callable[..., Path], run: RunDirectory
) -> None:
    """No node refuses what it is started with: names, types and ranges fit its options."""
    scenario = read_scenario(small(changes))
    for spec in process_table(scenario, run):
        path = run.parameters_of(spec.name)
        write_parameters(path, spec.node, spec.parameters)
        written = yaml.safe_load(path.read_text())[spec.node]['ros__parameters']
        values = {
            key: tuple(value) if isinstance(value, list) else value
            for key, value in written.items()
        }
        options = OPTIONS[spec.executable](**values)
        if isinstance(options, VehicleOptions):
            assert options.cameras()[0].image_height_px == scenario.camera.image_height_px
            assert options.airframe().performance.autopilot == ARDUCOPTER
        if isinstance(options, FleetOptions):
            assert [vehicle.name for vehicle in options.vehicles()] == ['rav1', 'rav2']


def test_one_wind_with_its_gusts_pushes_vehicles_and_carries_gas(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """Mean, gusts, record, site, their seed and the time from which they count are the same."""
    record = small().with_name('wind.csv')
    record.write_text('time_s,wind_speed_mps,wind_from_deg\n0,2,250\n60,3,240\n')
    changes = {'gust_std_mps': 0.7, 'record_file': record.name, 'scene_file': str(SCENE)}
    gusts = {'survey.airspace.wind_mps': [2.0, 1.0], 'air.wind': changes}
    scenario = read_scenario(small({**GAS, **gusts}))
    table = {spec.name: spec.parameters for spec in process_table(scenario, run)}
    air, wind = table['air'], table['air']['air_file']['wind']
    flown = table['rav1']
    assert (flown['wind_east_mps'], flown['wind_north_mps']) == (2.0, 1.0)
    assert (wind['towards_east_mps'], wind['towards_north_mps']) == (2.0, 1.0)
    assert flown['wind_file'] == wind
    assert wind['gust_std_mps'] == 0.7
    assert wind['record_file'] == str(record)
    assert wind['site_file'] == str(run.site_wind)
    settings = values_of(wind, WindSettings, 'wind')
    assert values_of(air['air_file'], AirFile, 'air').wind == settings
    assert flown['seed'] == air['seed']
    assert flown['scene_start_s'] == air['start_time_s']


def test_a_ground_vehicle_smells_as_drones_do(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """The air gives it readings, the estimator hears them and writes what the router reads."""
    scenario = read_scenario(small({**GAS, **DRIVE}))
    table = {spec.name: spec for spec in process_table(scenario, run)}
    names = ['rav1', 'rav2', 'rgv1']
    assert table['air'].parameters['vehicles'] == names
    assert {end.vehicle for end in table['air'].readiness} == set(names)
    assert table['estimator'].parameters['vehicles'] == names
    router = RouterOptions(**table['router'].parameters)
    assert str(router.files('').gas) == table['estimator'].parameters['export_directory']


def test_vehicles_are_processes_of_their_own_or_one(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """The table has a `rav` a vehicle, or one `fleet`, and the world waits for them."""
    each = process_table(read_scenario(small()), run)
    one = process_table(read_scenario(small(FLEET)), run)
    fleet_level = {
        'recorder', 'planner', 'world', 'fleet_verbs', 'radiation_field', 'localizer', 'collector',
        'mosaic',
    }  # fmt: skip
    assert {spec.name for spec in each} == fleet_level | {'rav1', 'rav2'}
    assert {spec.name for spec in one} == fleet_level | {'fleet'}
    worlds = [next(s for s in table if s.name == 'world') for table in (each, one)]
    assert worlds[0].parameters['participants'] == ['rav1', 'rav2', 'radiation_field', 'recorder']
    assert worlds[1].parameters['participants'] == ['fleet', 'radiation_field', 'recorder']


def test_crew_names_the_process_of_each_vehicle(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """The mission knows whose restart concerns which vehicle."""
    scenario = read_scenario(small(FLEET))
    crew = crew_of(scenario, process_table(scenario, run))
    assert crew.vehicle_processes == {'rav1': 'fleet', 'rav2': 'fleet'}


def test_source_stands_on_the_ground_above_the_ellipsoid(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """Height above the ground and the ground's altitude add up."""
    changes = {'origin.ground_altitude_m': 66.0, 'radiation.sources[0].height_m': 1.5}
    table = process_table(read_scenario(small(changes)), run)
    field = next(spec for spec in table if spec.name == 'radiation_field')
    settings = field.parameters['field_file']
    assert settings['ground_altitude_m'] == 66.0
    assert settings['sources'][0]['height_m'] == 1.5


def test_command_starts_the_executable_in_its_namespace(
    small: Callable[..., Path],
    run: RunDirectory,
    workspace: Callable[[tuple[ProcessSpec, ...]], Path],
) -> None:
    """A vehicle runs in its namespace with its own parameter file, after the user's."""
    table = process_table(read_scenario(small()), run)
    prefix = workspace(table)
    config = Path('my.yaml')
    launch = next(
        launch for launch in launches(table, run, MISSION, config) if launch.name == 'rav2'
    )
    assert launch.command == (
        str(prefix / 'lib' / 'rocsafe_sim' / 'rav'),
        '--ros-args',
        '-r',
        '__ns:=/rav2',
        '-p',
        'use_sim_time:=true',
        *MISSION.ros_arguments,
        '--params-file',
        'my.yaml',
        '--params-file',
        str(run.parameters / 'rav2.yaml'),
    )
    parameters = yaml.safe_load((run.parameters / 'rav2.yaml').read_text())
    assert parameters['/rav2/rav']['ros__parameters']['home_latitude_deg'] == 53.2795
    assert launch.log == run.logs / 'rav2.log'


def test_empty_lists_are_not_written(
    small: Callable[..., Path],
    run: RunDirectory,
    workspace: Callable[[tuple[ProcessSpec, ...]], Path],
) -> None:
    """ROS cannot read the type of an empty list: a mission without sources leaves them out."""
    table = process_table(read_scenario(small({'radiation': {}})), run)
    workspace(table)
    launches(table, run, MISSION)
    assert '[]' not in (run.parameters / 'radiation_field.yaml').read_text()


def test_nested_settings_are_written_to_a_file_of_their_own(tmp_path: Path) -> None:
    """The parameter holds its path."""
    nested = {'cameras': [{'name': 'camera', 'stream_rate_hz': 2.0}]}
    write_parameters(tmp_path / 'rav1.yaml', '/rav1/rav', {'seed': 3, 'cameras_file': nested})
    path = tmp_path / 'rav1-cameras.yaml'
    written = yaml.safe_load((tmp_path / 'rav1.yaml').read_text())['/rav1/rav']['ros__parameters']
    assert written == {'seed': 3, 'cameras_file': str(path)}
    assert yaml.safe_load(path.read_text()) == nested


def test_products_are_made_by_a_task_that_is_not_repeated(
    small: Callable[..., Path],
    run: RunDirectory,
    workspace: Callable[[tuple[ProcessSpec, ...]], Path],
) -> None:
    """The report runs once, in a process of its own."""
    table = process_table(read_scenario(small()), run)
    workspace(table)
    report = next(launch for launch in launches(table, run, MISSION) if launch.name == REPORT)
    assert report.is_task
    assert report.restart.limit == 0
    assert report.command[-2:] == ('rocsafe_orchestrator.report_process', str(run.path))


def test_missing_executable_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A workspace that is not built or not sourced is a matter of set-up."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    with pytest.raises(SetupError, match='executable rav of package rocsafe_sim') as caught:
        find_executable('rocsafe_sim', 'rav')
    assert caught.value.exit_code == EXIT_SETUP
    assert 'make setup' in str(caught.value)


def test_children_know_their_supervisor(run: RunDirectory) -> None:
    """Nodes end when the process that started them does, and log into the run directory."""
    environment = child_environment(run)
    assert environment['ROCSAFE_SUPERVISOR_PID'] == str(os.getpid())
    assert environment['ROS_LOG_DIR'].startswith(str(run.path))


def test_scenarios_know_the_nuclides_and_detectors_of_the_field() -> None:
    """The names are written twice: here they are one."""
    fields = RadiationBlock.model_fields
    assert set(get_args(Nuclide)) == set(nuclide_names())
    assert set(get_args(fields['detector'].annotation)) == set(DETECTOR_NAMES)
    assert set(get_args(fields['model'].annotation)) == set(MODELS)
    assert set(get_args(Material)) == set(materials()) - {AIR}


def field_of(scenario: Scenario, run: RunDirectory) -> SurveyField:
    """Return the field as its node makes it from the parameter file."""
    path = run.parameters_of('radiation_field')
    write_parameters(path, '/radiation_field', field_parameters(scenario, run))
    given = yaml.safe_load(path.read_text())['/radiation_field']['ros__parameters']
    values = {k: tuple(v) if isinstance(v, list) else v for k, v in given.items()}
    return survey_field(FieldOptions(**values))


def test_a_scenario_of_shapes_and_shields_makes_a_field(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """A line, an area and a moving source behind a wagon, as the field node takes them."""
    corners = [[53.2805, -9.061], [53.2806, -9.061], [53.2806, -9.0611]]
    stops = [{'time_s': 0.0, 'position': corners[0]}, {'time_s': 30.0, 'position': corners[1]}]
    strength = {'sigma_usvps': 1.0, 'height_m': 0.5}
    sources = [
        {'name': 'spill', 'line': corners[:2], **strength},
        {'name': 'field', 'area': corners, **strength},
        {'name': 'thief', 'track': stops, **strength},
        {'name': 'pot', 'position': corners[2], **strength},
    ]
    wagon = {
        'material': 'iron', 'position': corners[0], 'length_m': 14.0, 'width_m': 3.0,
        'height_m': 4.0, 'base_height_m': 1.0, 'heading_deg': 30.0, 'wall_m': 0.008,
    }  # fmt: skip
    changes = {
        'radiation.model': 'shielded',
        'radiation.sources': sources,
        'radiation.shields': [wagon],
        'radiation.background': {'dose_rate_usvh': 0.08, 'variation': 0.2, 'cosmic': False},
    }
    survey = field_of(read_scenario(small(changes)), run)
    parts = [len(source.places()) for source in survey.field.sources]
    assert parts[0] > 10
    assert parts[1] > 10
    assert parts[2:] == [1, 1]
    assert survey.field.model == 'shielded'
    assert survey.field.shielding is not None
    assert not survey.background.is_cosmic


def test_the_ground_of_a_scenario_reaches_field_localizer_and_command(
    small: Callable[..., Path], run: RunDirectory, tmp_path: Path
) -> None:
    """The truth is the scene's ground, what is known the elevation model; else level ground."""
    level = read_scenario(small())
    assert 'terrain_file' not in field_parameters(level, run)['field_file']
    assert ground_options(level, run) == (f'--ground={level.origin.ground_altitude_m}',)
    dem = str(write_terrain(tmp_path / 'dem.tif', np.full((300, 300), 1000.0, np.float32)))
    survey = level.survey.model_copy(update={'terrain_file': dem})
    camera = level.camera.model_copy(update={'backend': 'engine', 'scene_file': '/hill.yaml'})
    followed = level.model_copy(update={'survey': survey})
    in_scene = level.model_copy(update={'camera': camera})
    both = followed.model_copy(update={'camera': camera})
    hill = str(run.solids_of('/hill.yaml'))
    for scenario, truth, known in (
        (followed, dem, dem), (in_scene, hill, hill), (both, hill, dem),
    ):  # fmt: skip
        field = field_parameters(scenario, run)['field_file']
        localizer = localizer_parameters(scenario, run)
        assert (field['terrain_file'], localizer['terrain_file']) == (truth, known)
        assert f'--terrain={known}' in ground_options(scenario, run)
        for given in (field, localizer):
            shift_m = level.origin.ground_altitude_m - 1000.0
            expected = shift_m if given['terrain_file'] == dem else 0.0
            assert given.get('terrain_shift_m', 0.0) == pytest.approx(expected)


def test_slopes_of_a_drive_are_those_of_the_elevation_model_and_never_of_the_scene(
    small: Callable[..., Path], run: RunDirectory, tmp_path: Path
) -> None:
    """A router knows what the planner of the survey knows, not the simulator's truth."""
    plain = read_scenario(small(DRIVE))
    dem = write_terrain(tmp_path / 'dem.tif', np.full((300, 300), 1000.0, np.float32))
    survey = plain.survey.model_copy(update={'terrain_file': str(dem)})
    camera = plain.camera.model_copy(update={'backend': 'engine', 'scene_file': '/hill.yaml'})
    changes = {'survey': survey, 'camera': camera}
    for scenario, known in (
        (plain, None),
        (plain.model_copy(update={'camera': camera}), None),
        (plain.model_copy(update=changes), dem),
    ):
        table = {spec.name: spec.parameters for spec in process_table(scenario, run)}
        assert RouterOptions(**table['router']).files('').terrain == known


def test_the_kind_of_detector_reaches_field_localizer_and_command(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """One that counts scattered photons must be known to whoever reads its counts."""
    level = read_scenario(small())
    radiation = level.radiation.model_copy(update={'detector': 'nai_2x2'})
    scenario = level.model_copy(update={'radiation': radiation})
    assert field_parameters(scenario, run)['detector'] == 'nai_2x2'
    assert localizer_parameters(scenario, run)['detector'] == 'nai_2x2'
    assert '--detector=nai_2x2' in radiation.localize_options


def test_a_terrain_that_misses_a_home_is_a_matter_of_setup(
    small: Callable[..., Path], run: RunDirectory, tmp_path: Path
) -> None:
    """In one line, before anything starts."""
    level = read_scenario(small())
    dem = write_terrain(tmp_path / 'dem.tif', np.full((3, 3), 1.0, np.float32))
    survey = level.survey.model_copy(update={'terrain_file': str(dem)})
    with pytest.raises(SetupError, match=r'survey\.terrain_file: the terrain has no height at'):
        field_parameters(level.model_copy(update={'survey': survey}), run)


def test_scenes_are_exported_once_for_all_nodes(
    small: Callable[..., Path], run: RunDirectory, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """By the command, about the origin and with the seed of the mission; it may refuse."""
    program = tmp_path / 'scene'
    program.write_text(
        '#!/bin/sh\ncase $2 in /gone*)\n'
        'echo "rocsafe: gone.yaml: no such file" >&2; exit 2;; esac\n'
        f'echo "$@" >> {tmp_path}/calls\n'
        'for word in "$@"; do case $word in --out=*) touch "${word#--out=}";; esac; done\n'
    )
    program.chmod(0o755)
    monkeypatch.setattr(
        'rocsafe_orchestrator.process_table.scene_export.find_executable', lambda *_: program
    )
    level = read_scenario(small())
    export_scenes(level, run)
    radiation = level.radiation.model_copy(update={'scene_file': '/hill.yaml'})
    camera = level.camera.model_copy(update={'backend': 'engine', 'scene_file': '/hill.yaml'})
    scenario = level.model_copy(update={'radiation': radiation, 'camera': camera})
    export_scenes(scenario, run)
    export_scenes(scenario, run)
    origin = scenario.origin_position()
    (call,) = (tmp_path / 'calls').read_text().splitlines()
    assert call == (
        f'solids /hill.yaml --out={run.solids_of("/hill.yaml")} --origin={origin.latitude_deg!r},'
        f'{origin.longitude_deg!r},{origin.altitude_m!r} --seed={scenario.seed}'
    )
    wind = level.air.wind.model_copy(update={'scene_file': '/hill.yaml', 'stability': 'B'})
    windy = scenario.model_copy(update={'air': level.air.model_copy(update={'wind': wind})})
    export_scenes(windy, run)
    _, call = (tmp_path / 'calls').read_text().splitlines()
    assert call == (
        f'{run.solids_of("/hill.yaml")} --out={run.site_wind} --height=10.0 --roughness=0.03 '
        '--stability=B --towards 0.000000 0.000000'
    )
    gone = radiation.model_copy(update={'scene_file': '/gone.yaml'})
    with pytest.raises(SetupError, match=r'^/gone\.yaml: gone\.yaml: no such file$'):
        export_scenes(level.model_copy(update={'radiation': gone}), run)


def test_an_activity_decays_to_the_start_of_the_mission(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """Iridium of 2025-03-19 has halved on 2025-06-01, 73.8 days later."""
    source = {
        'name': 'ir',
        'position': [53.2805, -9.061],
        'nuclide': 'Ir-192',
        'activity_gbq': 100.0,
        'activity_date': datetime(2025, 3, 19, 14, tzinfo=timezone.utc),
    }
    scenario = read_scenario(small({'radiation.sources': [source]}))
    (built,) = field_of(scenario, run).field.sources
    assert built.sigma_usvps == pytest.approx(nuclide('Ir-192').sigma_usvps(50.0), rel=0.001)


def test_a_real_drone_may_bring_its_own_detector(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """No field is simulated for it, nobody waits for one, and the report tells them apart."""
    links = {
        'vehicles[0].link': 'udp://127.0.0.1:14550',
        'vehicles[0].drone': {'system': 1, 'detector': 'own'},
        'vehicles[1].link': 'udp://127.0.0.1:14550',
        'vehicles[1].drone': {'system': 2},
    }
    scenario = read_scenario(small(links))
    parameters = field_parameters(scenario, run)
    assert parameters['vehicles'] == parameters['vehicles_at_their_fix'] == ['rav2']
    (field,) = (spec for spec in process_table(scenario, run) if spec.name == 'radiation_field')
    assert {endpoint.vehicle for endpoint in field.readiness} == {'rav2'}
    assert what_is_simulated(scenario) == (
        'Real flight: rav1, rav2. Own detector: rav1. Simulated detector: rav2.'
    )


def test_lines_of_a_real_detector_are_read_by_a_process_of_its_own(
    small: Callable[..., Path], run: RunDirectory
) -> None:
    """Its keys are the parameters of the node; just one of them says where the lines come in."""

    def with_detector(detector: dict[str, object]) -> Path:
        drone = {'system': 1, 'detector': detector}
        return small({'vehicles[0].link': 'udp://127.0.0.1:14550', 'vehicles[0].drone': drone})

    scenario = read_scenario(with_detector({'serial': '/dev/ttyUSB0', 'baud': 115200}))
    (spec,) = (spec for spec in process_table(scenario, run) if spec.package.endswith('radiation')
               and spec.executable == 'detector')  # fmt: skip
    assert (spec.name, spec.node) == ('detector_rav1', '/rav1/detector')
    assert DetectorOptions(**spec.parameters).baud == 115200
    assert [endpoint.vehicle for endpoint in spec.readiness] == ['rav1']
    assert field_parameters(scenario, run)['vehicles'] == ['rav2']
    for wrong in ({}, {'serial': 'a', 'tunnel': True}):
        with pytest.raises(ScenarioError, match='must have one of serial, udp and tunnel'):
            read_scenario(with_detector(wrong))


def test_flat_ground_above_a_viewpoint_is_refused(small: Callable[..., Path]) -> None:
    """Over terrain a vehicle may fly below the ground that the flat camera photographs."""
    plan = SurveyPlan(routes=[Route(viewpoints=[Viewpoint()], follows_terrain=True)])
    plan.routes[0].viewpoints[0].position.altitude = 20.0
    scenario = read_scenario(small({'origin': {'ground_altitude_m': 25.0}}))
    assert unseen_viewpoint(scenario, plan).startswith('origin.ground_altitude_m = 25 is above')
    assert not unseen_viewpoint(read_scenario(small()), plan)
