# SPDX-License-Identifier: Apache-2.0
"""The processes of a scenario without the mission: for launch files, and who commands by hand."""

import os
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from rocsafe_orchestrator.parameters.node_parameters import BRIDGE
from rocsafe_orchestrator.process_table.launches import child_environment, launches
from rocsafe_orchestrator.process_table.scene_export import export_scenes
from rocsafe_orchestrator.process_table.table import ProcessSpec, process_table
from rocsafe_orchestrator.process_table.values import Launch
from rocsafe_orchestrator.run_directory import create_run_directory, run_name
from rocsafe_ros.domain.mission_identity import new_identity
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario_file import read_scenario


def scenario_launches(
    path: Path, parent: Path, *, is_hardware: bool
) -> tuple[tuple[Launch, ...], Mapping[str, str]]:
    """Make a run directory; return how to start each process, and the environment of all.

    Parameters
    ----------
    path
        Scenario file.
    parent
        Where to make the run directory.
    is_hardware
        Only what connects real vehicles and detectors, on the time of the wall.

    Raises
    ------
    ScenarioError
        If the file is wrong, or has no real vehicle although `is_hardware`.
    SetupError
        If an executable is missing, or the folder cannot be made.
    """
    scenario = read_scenario(path)
    if is_hardware and not scenario.real_names:
        raise ScenarioError(f'{path.name}: vehicles: none has a link to a real vehicle')
    run = create_run_directory(parent, run_name(scenario.name, datetime.now().astimezone()))
    export_scenes(scenario, run)
    table = process_table(scenario, run)
    if is_hardware:
        table = tuple(spec for spec in table if _is_of_hardware(spec))
    starts = [start for start in launches(table, run, new_identity(run.name)) if not start.is_task]
    if is_hardware:
        starts = [_on_wall_time(start) for start in starts]
    return tuple(starts), {**os.environ, **child_environment(run)}


def _is_of_hardware(spec: ProcessSpec) -> bool:
    return spec.name == BRIDGE or spec.executable == 'detector'


def _on_wall_time(start: Launch) -> Launch:
    return replace(start, command=(*start.command, '-p', 'use_sim_time:=false'))
