# SPDX-License-Identifier: Apache-2.0
"""`rocsafe run`: fly a scenario and write a run directory."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from rich.console import Console

from rocsafe_orchestrator.company_node import Claim, claimed
from rocsafe_orchestrator.contamination import require_clean
from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.mission_commands.mission_run import Extras, MissionRun, locked
from rocsafe_orchestrator.parameters.config_file import require_parameter_file
from rocsafe_orchestrator.planning_commands.preflight_command import cleared, on_wall_time
from rocsafe_orchestrator.process_table.launches import require_executables
from rocsafe_orchestrator.process_table.scene_export import export_scenes
from rocsafe_orchestrator.process_table.table import process_table
from rocsafe_orchestrator.processes.company import needed_names
from rocsafe_orchestrator.processes.disk_space import require_space
from rocsafe_orchestrator.processes.domain_lock import domain_lock
from rocsafe_orchestrator.processes.interrupt import Interrupted
from rocsafe_orchestrator.processes.process_start import import_for
from rocsafe_orchestrator.processes.ros_reach import reach
from rocsafe_orchestrator.provenance import provenance, write_json
from rocsafe_orchestrator.run_directory import RunDirectory, create_run_directory, run_name
from rocsafe_ros.domain.mission_identity import new_identity
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_checks import flight_mistakes
from rocsafe_scenario.scenario_file import read_scenario

# Real vehicles must be heard and ready within this time.
PREFLIGHT_S = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRequest:
    """Arguments of the command; None means the value of the scenario."""

    scenario: Path
    parent: Path
    speed: float | None = None
    seed: int | None = None
    extras: Extras = field(default_factory=Extras)


def run_scenario(request: RunRequest, console: Console) -> int:
    """Fly the scenario and return the exit code.

    Raises
    ------
    OrchestratorError
        If the run cannot start.
    """
    scenario = read_scenario(request.scenario, speed=request.speed, seed=request.seed)
    lines = flight_mistakes(scenario)
    if lines:
        raise ScenarioError('\n'.join(f'{request.scenario.name}: {line}' for line in lines))
    if request.extras.config is not None:
        require_parameter_file(request.extras.config)
    reach(scenario)
    require_space(request.parent, scenario)
    table = process_table(scenario, RunDirectory(request.parent))
    executables = require_executables(table)
    started = datetime.now().astimezone()
    mission = new_identity(run_name(scenario.name, started))
    holder = f'{mission.mission}, process {os.getpid()}'
    with (
        domain_lock(os.environ.get('ROS_DOMAIN_ID') or '0', holder),
        claimed(mission, needed_names(scenario, table), request.extras.config) as claim,
    ):
        # The modules load while the claim looks.
        for executable in executables:
            import_for(executable)
        claim.require_alone()
        if scenario.real_names:
            require_clean(request.parent, scenario.real_names)
        if scenario.linked:
            scenario = cleared(scenario, PREFLIGHT_S, started)
        elif scenario.real_names:
            scenario = on_wall_time(scenario, started)
        return _run(request, scenario, console, claim)


def _run(request: RunRequest, scenario: Scenario, console: Console, claim: Claim) -> int:
    started = datetime.now().astimezone()
    directory = create_run_directory(request.parent, claim.mission.mission)
    source = f'# As flown: {request.scenario}, with every default written out.\n'
    directory.scenario.write_text(source + scenario.to_yaml(), encoding='utf-8')
    run_info = provenance(sys.argv, started)
    write_json(directory.run_info, run_info)
    with _told(directory, run_info):
        export_scenes(scenario, directory)
        flight = MissionRun(
            extras=request.extras,
            scenario=scenario,
            directory=directory,
            claim=claim,
            table=process_table(scenario, directory),
            run_info=run_info,
        )
    with locked(directory):
        return flight.run(console)


@contextmanager
def _told(directory: RunDirectory, run_info: dict[str, Any]) -> Iterator[None]:
    """Write what ended a run that has a directory, and no processes yet."""
    try:
        yield
    except (OrchestratorError, Interrupted) as error:
        run_info['outcome'] = 'cancelled' if isinstance(error, Interrupted) else 'failed'
        run_info['outcome_text'] = str(error)
        write_json(directory.run_info, run_info)
        raise
