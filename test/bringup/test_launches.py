# SPDX-License-Identifier: Apache-2.0
"""Launch files start what a mission starts, and layouts are current."""

import json
import runpy
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / 'src/rocsafe_bringup'
SCENARIOS = ROOT / 'config/scenarios'
pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')


def test_simulation_starts_every_process_of_the_table(tmp_path):
    """Each with its parameters, and without the tasks of the mission."""
    from rocsafe_orchestrator.process_table.bringup import scenario_launches
    from rocsafe_orchestrator.process_table.table import process_table
    from rocsafe_orchestrator.run_directory import RunDirectory
    from rocsafe_scenario.scenario_file import read_scenario

    path = SCENARIOS / 'derailment.yaml'
    starts, _ = scenario_launches(path, tmp_path, is_hardware=False)
    table = process_table(read_scenario(path), RunDirectory(tmp_path))
    assert [start.name for start in starts] == [spec.name for spec in table]
    for start in starts:
        assert Path(start.command[0]).is_file()
        assert Path(start.command[start.command.index('--params-file') + 1]).is_file()


def test_hardware_starts_the_bridge_alone_on_the_time_of_the_wall(tmp_path):
    """No simulated vehicle, field or clock."""
    from rocsafe_orchestrator.process_table.bringup import scenario_launches

    starts, _ = scenario_launches(SCENARIOS / 'sitl.yaml', tmp_path, is_hardware=True)
    assert [start.name for start in starts] == ['bridge']
    assert starts[0].command[-1] == 'use_sim_time:=false'


def test_hardware_without_a_real_vehicle_is_refused(tmp_path):
    """In one line, before a folder is made."""
    from rocsafe_orchestrator.process_table.bringup import scenario_launches
    from rocsafe_scenario.errors import ScenarioError

    with pytest.raises(ScenarioError, match='none has a link'):
        scenario_launches(SCENARIOS / 'derailment.yaml', tmp_path, is_hardware=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('name', ['sim', 'hardware', 'replay'])
def test_launch_files_describe_what_to_start(name):
    """With the launch package of ROS, which the wheels lack."""
    # Without it, a folder of this name may be found in its place.
    pytest.importorskip('launch.actions', reason='the wheels have no launch')
    launch = pytest.importorskip('launch')
    described = runpy.run_path(str(PACKAGE / f'launch/{name}_launch.py'))
    description = described['generate_launch_description']()
    assert isinstance(description, launch.LaunchDescription)
    wanted = 'run' if name == 'replay' else 'scenario'
    assert wanted in [argument.name for argument in description.get_launch_arguments()]


def test_layouts_are_those_of_the_table_of_topics():
    """``python tools/layouts.py`` would change nothing."""
    import layouts

    rviz = yaml.safe_load((PACKAGE / 'view/rocsafe.rviz').read_text())
    assert rviz == layouts.rviz_layout()
    panels = json.loads((PACKAGE / 'view/rocsafe_layout.json').read_text())
    assert panels == layouts.panel_layout()
