# SPDX-License-Identifier: Apache-2.0
"""`rocsafe run --resume`: join a mission whose orchestrator has died, and bring it to its end."""

import json
import os
import sys
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from rich.console import Console

from rocsafe_orchestrator.company_node import claimed
from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.mission.closing import MOSAIC
from rocsafe_orchestrator.mission_commands.mission_run import Extras, Found, MissionRun, locked
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.parameters.node_parameters import AGENTS
from rocsafe_orchestrator.process_table.launches import require_executables
from rocsafe_orchestrator.process_table.table import ProcessSpec, crew_of, process_table
from rocsafe_orchestrator.processes.company import needed_names
from rocsafe_orchestrator.processes.domain_lock import domain_lock
from rocsafe_orchestrator.processes.ros_reach import reach
from rocsafe_orchestrator.processes.session import Adopted, read_session
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario


def resume_run(path: Path, extras: Extras, console: Console) -> int:
    """Join the mission of a run directory and return the exit code.

    Processes that live are taken over, others are started again. If nothing flies any more, map
    and products are made.

    Raises
    ------
    OrchestratorError
        If there is nothing to resume.
    """
    directory = RunDirectory(path.resolve())
    _require_resumable(directory)
    # Before the processes are looked at: none of them ends from now on for want of a supervisor.
    with locked(directory):
        session = read_session(directory.session)
        scenario = read_scenario(directory.scenario)
        table = process_table(scenario, directory)
        names = {spec.name for spec in table}
        living = {name: one for name, one in session.living().items() if name in names}
        found, table = _found(scenario, table, living)
        extras = replace(extras, config=Path(session.config) if session.config else None)
        reach(scenario)
        require_executables(table)
        holder = f'{session.mission}, process {os.getpid()}'
        with (
            domain_lock(os.environ.get('ROS_DOMAIN_ID') or '0', holder),
            claimed(session.identity, needed_names(scenario, table), extras.config) as claim,
        ):
            claim.require_alone()
            flight = MissionRun(
                extras=extras,
                scenario=scenario,
                directory=directory,
                claim=claim,
                table=table,
                run_info=_run_info(directory),
                found=found,
            )
            return flight.run(console)


def _require_resumable(run: RunDirectory) -> None:
    """Refuse what is no run, is over, or has never flown: one line each."""
    if not run.scenario.is_file():
        raise SetupError(f'{run.path} is no run directory')
    if not run.session.is_file():
        text = 'it is over, or its vehicles have no agents and ended with it'
        raise SetupError(f'{run.path} cannot be resumed: {text}; rocsafe report {run.path}')
    if not run.plan.is_file():
        raise SetupError(f'{run.path} cannot be resumed: it had no plan yet; run it again')


def _found(
    scenario: Scenario, table: tuple[ProcessSpec, ...], living: dict[str, Adopted]
) -> tuple[Found, tuple[ProcessSpec, ...]]:
    """Return what there is of a mission, and the processes that it needs from now on."""
    vehicles = crew_of(scenario, table).vehicle_processes
    # Whether vehicles of other hosts fly is not known: they are waited for.
    is_known = all(spec.is_here for spec in table)
    flies = AGENTS in living or any(process in living for process in vehicles.values())
    if is_known and not flies:
        needed = tuple(spec for spec in table if spec.name == MOSAIC or spec.name in living)
        return Found(first=Phase.MAPPING, living=living), needed
    elsewhere = {spec.name for spec in table if not spec.is_here}
    simulated = {v.name for v in scenario.simulated} - elsewhere
    lost = tuple(n for n, p in vehicles.items() if n in simulated and p not in living)
    gone = {vehicles[name] for name in lost}
    needed = tuple(spec for spec in table if spec.is_here and spec.name not in gone)
    return Found(first=Phase.FLYING, living=living, lost=lost), needed


def _run_info(run: RunDirectory) -> dict[str, Any]:
    """Return what the run noted about itself, and that it is resumed now."""
    info: dict[str, Any] = json.loads(run.run_info.read_text(encoding='utf-8'))
    now = datetime.now().astimezone().isoformat(timespec='seconds')
    command = [Path(sys.argv[0]).name, *sys.argv[1:]]
    resumed = [*info.get('resumed', []), {'at': now, 'command': command}]
    return {**info, 'resumed': resumed}
