# SPDX-License-Identifier: Apache-2.0
"""`rocsafe run`: fly a scenario and write a run directory."""

import logging
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from rich.console import Console
from rich.text import Text

from rocsafe_orchestrator.company_node import Claim, claimed
from rocsafe_orchestrator.contamination import require_clean
from rocsafe_orchestrator.errors import EXIT_COMPLETE, EXIT_FAILED
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.phase import Phase
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.mission_commands.crew_watch import CrewWatch
from rocsafe_orchestrator.mission_commands.mission_loop import MissionLoop, Parts
from rocsafe_orchestrator.mission_commands.progress import (
    Display,
    SteadyDisplay,
    make_display,
    peak_text,
)
from rocsafe_orchestrator.mission_commands.terminal import Terminal
from rocsafe_orchestrator.parameters.config_file import require_parameter_file
from rocsafe_orchestrator.parameters.node_parameters import world_parameters
from rocsafe_orchestrator.planning_commands.preflight_command import cleared
from rocsafe_orchestrator.processes.company import needed_names
from rocsafe_orchestrator.processes.console_process import operators_page, seal
from rocsafe_orchestrator.processes.disk_space import require_space
from rocsafe_orchestrator.processes.domain_lock import domain_lock
from rocsafe_orchestrator.processes.interrupt import Interrupt
from rocsafe_orchestrator.processes.launches import (
    child_environment,
    launches,
    require_executables,
)
from rocsafe_orchestrator.processes.process_start import begin_as_fork, import_for
from rocsafe_orchestrator.processes.process_table import airsim_process, crew_of, process_table
from rocsafe_orchestrator.processes.ros_reach import stay_on_this_machine
from rocsafe_orchestrator.processes.scene_export import export_scenes
from rocsafe_orchestrator.processes.supervisor import Supervisor
from rocsafe_orchestrator.provenance import provenance, write_json
from rocsafe_orchestrator.run_directory import RunDirectory, create_run_directory, run_name
from rocsafe_orchestrator.watches.operator_watch import OnOperatorLost, OperatorWatch
from rocsafe_ros.control_lease import MISSION_VARIABLE
from rocsafe_ros.domain.mission_identity import new_identity
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_checks import flight_mistakes
from rocsafe_scenario.scenario_file import read_scenario
from rocsafe_view.formats import clock

# Real vehicles must be heard and ready within this time.
PREFLIGHT_S = 60.0
LOOPBACK = '127.0.0.1'
# Simulated seconds between two reports of the vehicles, with a margin.
BEATS_PERIOD_S = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRequest:
    """Arguments of the command; None means the value of the scenario."""

    scenario: Path
    parent: Path
    speed: float | None = None
    seed: int | None = None
    config: Path | None = None
    is_quiet: bool = False
    confirmed: frozenset[str] = frozenset()
    has_console: bool = False
    airsim_port: int | None = None


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
    if request.config is not None:
        require_parameter_file(request.config)
    stay_on_this_machine()
    require_space(request.parent, scenario)
    table = process_table(scenario, RunDirectory(request.parent))
    executables = require_executables(table)
    started = datetime.now().astimezone()
    mission = new_identity(run_name(scenario.name, started))
    holder = f'{mission.mission}, process {os.getpid()}'
    with (
        domain_lock(os.environ.get('ROS_DOMAIN_ID') or '0', holder),
        claimed(mission, needed_names(scenario, table), request.config) as claim,
    ):
        # The modules load while the claim looks.
        for executable in executables:
            import_for(executable)
        claim.require_alone()
        if scenario.linked:
            require_clean(request.parent, tuple(vehicle.name for vehicle in scenario.linked))
            scenario = cleared(scenario, PREFLIGHT_S, started)
        return _run(request, scenario, console, claim)


def _run(request: RunRequest, scenario: Scenario, console: Console, claim: Claim) -> int:
    interrupt = Interrupt()
    started = datetime.now().astimezone()
    directory = create_run_directory(request.parent, claim.mission.mission)
    source = f'# As flown: {request.scenario}, with every default written out.\n'
    directory.scenario.write_text(source + scenario.to_yaml(), encoding='utf-8')
    run_info = provenance(sys.argv, started)
    write_json(directory.run_info, run_info)
    _log_to(directory)
    terminal = Terminal(directory.log_of('terminal'))
    interrupt.on_hangup = terminal.close
    export_scenes(scenario, directory)
    plain = make_display(console, directory.name, is_quiet=request.is_quiet)
    display = SteadyDisplay(plain, terminal.close)
    flight = _Run(
        request=request,
        scenario=scenario,
        directory=directory,
        interrupt=interrupt,
        terminal=terminal,
        run_info=run_info,
        claim=claim,
    )
    display.say(f'run directory: {directory.path}')
    with flight.processes(), operators_page(request.has_console, directory), display:
        phase = flight.fly(display)
    seal(directory)
    if not request.is_quiet:
        closing = _closing(directory, flight.monitor, flight.text, phase)
        console.print(closing, soft_wrap=True)
    elif phase is not Phase.COMPLETE:
        print(f'rocsafe: mission {phase.name.lower()}: {flight.text}', file=sys.stderr)
    if interrupt.exit_code is not None:
        return interrupt.exit_code
    return EXIT_COMPLETE if phase is Phase.COMPLETE else EXIT_FAILED


@dataclass(kw_only=True)
class _Run:
    """Builds the parts of a run."""

    request: RunRequest
    scenario: Scenario
    directory: RunDirectory
    interrupt: Interrupt
    terminal: Terminal
    run_info: dict[str, object]
    claim: Claim
    text: str = ''

    def __post_init__(self) -> None:
        self.identity = replace(self.claim.mission, mission=self.directory.name)
        # Vehicles and orchestrator of a mission know each other by it.
        os.environ[MISSION_VARIABLE] = self.identity.token
        self.started_s = time.monotonic()
        levels = self.scenario.radiation.levels
        self.monitor = Monitor(
            self.scenario.vehicle_names, levels.contamination_usvh, self.scenario.driver_name
        )
        self.table = process_table(self.scenario, self.directory)
        if self.request.airsim_port is not None:
            server = airsim_process(self.scenario, LOOPBACK, self.request.airsim_port)
            self.table = (*self.table, server)
        self.supervisor = Supervisor(
            launches(self.table, self.directory, self.identity, self.request.config),
            child_environment(self.directory, has_agents=self.scenario.fleet.agents),
        )

    @contextmanager
    def processes(self) -> Iterator[None]:
        """Start every process before ROS: its threads would prevent forking."""
        try:
            for spec in self.table:
                self.supervisor.start(spec.name, begin_as_fork)
            yield
        finally:
            self.supervisor.stop(must_hurry=lambda: self.interrupt.is_urgent)

    def fly(self, display: Display) -> Phase:
        """Fly and return the outcome."""
        # Imported late: `rocsafe check` works without ROS.
        from rocsafe_orchestrator.orchestrator_node import OrchestratorNode, Spinner, ros_session

        with ros_session(self.identity, self.request.config):
            node = OrchestratorNode(self.scenario, self.monitor, self.identity)
            self.claim.close()
            speed = self.scenario.clock.speed
            mission = Mission(
                crew_of(self.scenario, self.table),
                node.deadlines,
                planning_budget_s=self.scenario.survey.effort.budget_s,
                slowest_beat_s=BEATS_PERIOD_S / speed if speed else 0.0,
                extra_rounds=self.scenario.extra_rounds,
                replans=self.scenario.replan == 'on_loss' and not self.scenario.fleet.agents,
                has_agents=self.scenario.fleet.agents,
            )
            parts = Parts(
                table=self.table,
                participants=tuple(world_parameters(self.scenario)['participants']),
                mission=mission,
                monitor=self.monitor,
                supervisor=self.supervisor,
                node=node,
                spinner=Spinner(node),
                display=display,
                interrupt=self.interrupt,
                terminal=self.terminal,
                operator=self._operator_watch(),
                confirmed=self.request.confirmed,
                directory=self.directory,
                run_info=self.run_info,
                crew_watch=CrewWatch(self.scenario, self.monitor),
                real=frozenset(vehicle.name for vehicle in self.scenario.linked),
            )
            try:
                run = MissionLoop(parts, node.deadlines.stop_s, self.started_s)
                return run.fly()
            finally:
                self.text = mission.text
                parts.spinner.close()

    def _operator_watch(self) -> OperatorWatch | None:
        policy = OnOperatorLost(self.scenario.on_operator_lost)
        return OperatorWatch(policy) if self.scenario.linked else None


def _log_to(directory: RunDirectory) -> None:
    """Write the log of the orchestrator to a file beside those of the processes."""
    handler = logging.FileHandler(directory.log_of('orchestrator'), encoding='utf-8')
    handler.setFormatter(logging.Formatter('%(asctime)s %(levelname)s %(message)s'))
    package = logging.getLogger('rocsafe_orchestrator')
    package.setLevel(logging.INFO)
    package.handlers = [handler]
    package.propagate = False
    # The mission reports a full disk once; without this, each line of a log would.
    logging.raiseExceptions = False


def _closing(directory: RunDirectory, monitor: Monitor, text: str, phase: Phase) -> Text:
    """Return the last lines of a run: the outcome and where to find the report or the logs."""
    style = 'bold green' if phase is Phase.COMPLETE else 'bold red'
    lines = Text.assemble((f'mission {phase.name.lower()}', style))
    if text:
        lines.append(f': {text}')
    images = f'{monitor.images_stored} images stored for {monitor.images_expected} viewpoints'
    lines.append(f'\n{images}, {clock(monitor.flight_time_s)} under way')
    if monitor.peak is not None:
        lines.append(f', highest reading {peak_text(monitor.peak)}')
    if directory.report.is_file():
        lines.append(f'\nreport: {directory.report}')
    elif phase is not Phase.COMPLETE:
        lines.append(f'\nlogs: {directory.logs}')
    return lines
