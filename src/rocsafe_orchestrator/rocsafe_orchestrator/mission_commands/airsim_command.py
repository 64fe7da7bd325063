# SPDX-License-Identifier: Apache-2.0
"""`rocsafe airsim`: the vehicles and the scene of a scenario, for scripts of AirSim's API."""

import os
import socket
import sys
import time
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from rocsafe_orchestrator.errors import EXIT_COMPLETE, SetupError
from rocsafe_orchestrator.parameters.node_parameters import AIR, FLEET, RECORDER
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.process_table.launches import child_environment, launches
from rocsafe_orchestrator.process_table.scene_export import export_scenes
from rocsafe_orchestrator.process_table.table import (
    AIRSIM,
    ProcessSpec,
    airsim_process,
    process_table,
)
from rocsafe_orchestrator.process_table.values import ProcessEventKind
from rocsafe_orchestrator.processes.company import needed_names, open_topics
from rocsafe_orchestrator.processes.domain_lock import domain_lock
from rocsafe_orchestrator.processes.interrupt import Interrupt
from rocsafe_orchestrator.processes.process_start import begin_as_fork, import_for
from rocsafe_orchestrator.processes.ros_reach import stay_on_this_machine
from rocsafe_orchestrator.processes.supervisor import Supervisor
from rocsafe_orchestrator.provenance import provenance, write_json
from rocsafe_orchestrator.run_directory import RunDirectory, create_run_directory, run_name
from rocsafe_ros.domain.mission_identity import new_identity
from rocsafe_ros.domain.mission_partition import keep_to_mission
from rocsafe_ros.lease.control_lease import MISSION_VARIABLE
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario

if TYPE_CHECKING:
    from rocsafe_orchestrator.company_node import Claim

POLL_S = 0.1
# Scripts ask for the newest value: more a second would only cost time.
SENSORS = {name: {'rate_hz': 10.0} for name in ('imu', 'barometer', 'magnetometer')}
READY_S = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class AirsimRequest:
    """Arguments of the command."""

    scenario: Path
    parent: Path
    speed: float
    host: str
    port: int


def serve_scripts(request: AirsimRequest, console: Console) -> int:
    """Run the vehicles until interrupted and return the exit code.

    Raises
    ------
    OrchestratorError
        If a process cannot be started, or fails for good.
    """
    from rocsafe_orchestrator.company_node import claimed

    scenario = read_scenario(request.scenario, speed=request.speed)
    for name in scenario.real_names:
        raise ScenarioError(
            f'{request.scenario.name}: {name} is a real vehicle: use `rocsafe run --airsim`'
        )
    stay_on_this_machine()
    started = datetime.now().astimezone()
    mission = new_identity(run_name(f'{scenario.name}-airsim', started))
    table = _table(scenario, RunDirectory(request.parent), request)
    with (
        domain_lock(os.environ.get('ROS_DOMAIN_ID') or '0', mission.mission),
        claimed(mission, needed_names(scenario, table)) as claim,
    ):
        for spec in table:
            import_for(find_executable(spec.package, spec.executable))
        claim.require_alone()
        directory = create_run_directory(request.parent, mission.mission)
        directory.scenario.write_text(scenario.to_yaml(), encoding='utf-8')
        write_json(directory.run_info, provenance(sys.argv, started))
        export_scenes(scenario, directory)
        table = _table(scenario, directory, request)
        topics = open_topics(scenario)
        keep_to_mission(os.environ, directory.parameters, mission.token, topics)
        return _serve(table, directory, claim, request, console)


def _table(
    scenario: Scenario, directory: RunDirectory, request: AirsimRequest
) -> tuple[ProcessSpec, ...]:
    """Return the processes that vehicles need, and the server."""
    wanted = {'world', 'radiation_field', AIR, FLEET, *scenario.vehicle_names}
    specs = [spec for spec in process_table(scenario, directory) if spec.name in wanted]
    world = {'autostart': True, 'pause_when_idle': False, 'pause_on_news': False}
    server = airsim_process(scenario, request.host, request.port)
    return (*(_free(spec, world) for spec in specs), server)


def _free(spec: ProcessSpec, world: dict[str, bool]) -> ProcessSpec:
    """Return a process that goes on without a mission: its time runs, and nothing is recorded.

    Its vehicles have at least the sensors that scripts find on every vehicle of AirSim.
    """
    if spec.name in (AIR, 'radiation_field'):
        return spec
    if spec.name != 'world':
        sensors = {**SENSORS, **spec.parameters.get('sensors_file', {})}
        return replace(spec, parameters={**spec.parameters, 'sensors_file': sensors})
    participants = [each for each in spec.parameters['participants'] if each != RECORDER]
    return replace(spec, parameters={**spec.parameters, **world, 'participants': participants})


def _serve(
    table: tuple[ProcessSpec, ...],
    directory: RunDirectory,
    claim: 'Claim',
    request: AirsimRequest,
    console: Console,
) -> int:
    identity = replace(claim.mission, mission=directory.name)
    os.environ[MISSION_VARIABLE] = identity.token
    interrupt = Interrupt()
    supervisor = Supervisor(launches(table, directory, identity), child_environment(directory))
    try:
        for spec in table:
            supervisor.start(spec.name, begin_as_fork)
        # Its names are those of the processes now.
        claim.close()
        _await_server(request, supervisor, interrupt)
        if not interrupt.count:
            where = f'{request.host}:{request.port}'
            console.print(f'AirSim clients are served on {where}; Ctrl-C ends', highlight=False)
        while not interrupt.count:
            _check(supervisor)
            time.sleep(POLL_S)
    finally:
        supervisor.stop(must_hurry=lambda: interrupt.is_urgent)
    return interrupt.exit_code or EXIT_COMPLETE


def _await_server(request: AirsimRequest, supervisor: Supervisor, interrupt: Interrupt) -> None:
    """Wait until the port is open."""
    end_s = time.monotonic() + READY_S
    while not interrupt.count:
        _check(supervisor)
        try:
            socket.create_connection((request.host, request.port), POLL_S).close()
        except OSError:
            if time.monotonic() > end_s:
                raise SetupError(
                    f'{AIRSIM}: not ready on {request.host}:{request.port} within {READY_S:g} s'
                ) from None
            time.sleep(POLL_S)
        else:
            return


def _check(supervisor: Supervisor) -> None:
    for event in supervisor.poll():
        if event.kind is ProcessEventKind.GAVE_UP:
            raise SetupError(f'{event.name} {event.text}')
