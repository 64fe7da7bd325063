# SPDX-License-Identifier: Apache-2.0
"""The parts of a run in its directory, its flight and its end: for a new run and a resumed one."""

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.text import Text

from rocsafe_geo.evidence.evidence_log import LOG_NAME, Event, EvidenceError, EvidenceLog
from rocsafe_geo.evidence.place_marks import PlaceMark, read_marks
from rocsafe_orchestrator.company_node import Claim
from rocsafe_orchestrator.errors import EXIT_COMPLETE, EXIT_FAILED
from rocsafe_orchestrator.mission.mission import Mission
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
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.parameters.node_parameters import world_parameters
from rocsafe_orchestrator.process_table.console_process import OperatorsPage, seal
from rocsafe_orchestrator.process_table.launches import child_environment, launches
from rocsafe_orchestrator.process_table.table import ProcessSpec, airsim_process, crew_of
from rocsafe_orchestrator.processes.company import open_topics
from rocsafe_orchestrator.processes.domain_lock import file_lock
from rocsafe_orchestrator.processes.end_watch import EndWatch
from rocsafe_orchestrator.processes.hosts import (
    JOIN_PORT,
    HostServer,
    Welcome,
    write_photographs_token,
)
from rocsafe_orchestrator.processes.interrupt import Interrupt
from rocsafe_orchestrator.processes.process_start import begin_as_fork
from rocsafe_orchestrator.processes.session import Adopted, Session, write_session
from rocsafe_orchestrator.processes.supervisor import Supervisor
from rocsafe_orchestrator.products.photographs import read_photographs
from rocsafe_orchestrator.run_directory import RunDirectory, remove_parts
from rocsafe_orchestrator.watches.operator_watch import OnOperatorLost, OperatorWatch
from rocsafe_ros.domain.mission_partition import keep_to_mission
from rocsafe_ros.lease.control_lease import MISSION_VARIABLE
from rocsafe_scenario.scenario import Scenario
from rocsafe_view.formats import clock

log = logging.getLogger(__name__)

LOOPBACK = '127.0.0.1'
# Simulated seconds between two reports of the vehicles, with a margin.
BEATS_PERIOD_S = 2.0
# Processes look at the lock of a run for some microseconds; a resumed run waits for them.
LOCK_WAIT_S = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Extras:
    """What is wanted of a run beside its mission."""

    config: Path | None = None
    is_quiet: bool = False
    confirmed: frozenset[str] = frozenset()
    page: OperatorsPage = field(default_factory=lambda: OperatorsPage(is_wanted=False))
    airsim_port: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What a resumed run has found of the mission.

    Attributes
    ----------
    first
        Phase to go on with.
    living
        Processes that still run.
    lost
        Simulated vehicles whose process has ended.
    """

    first: Phase
    living: Mapping[str, Adopted] = field(default_factory=dict)
    lost: tuple[str, ...] = ()


@dataclass(kw_only=True)
class MissionRun:
    """Builds the parts of a run.

    Attributes
    ----------
    table
        Processes that it needs.
    run_info
        Content of ``run.json`` as known before the flight.
    found
        What there is of the mission already; None: a new run.
    """

    extras: Extras
    scenario: Scenario
    directory: RunDirectory
    claim: Claim
    table: tuple[ProcessSpec, ...]
    run_info: dict[str, Any]
    found: Found | None = None
    text: str = ''

    def __post_init__(self) -> None:
        self.interrupt = Interrupt()
        self.terminal = Terminal(self.directory.log_of('terminal'))
        self.interrupt.on_hangup = self.terminal.close
        self.identity = replace(self.claim.mission, mission=self.directory.name)
        # Vehicles and orchestrator of a mission know each other by it.
        os.environ[MISSION_VARIABLE] = token = self.identity.token
        topics = open_topics(self.scenario)
        keep_to_mission(os.environ, self.directory.parameters, token, topics)
        self.started_s = time.monotonic()
        levels = self.scenario.radiation.levels
        self.monitor = Monitor(
            self.scenario.vehicle_names, levels.contamination_usvh, self.scenario.driver_name
        )
        self.monitor.marks = partial(_marks, self.directory)
        if self.scenario.hosts:
            write_photographs_token(self.directory, self.identity.token)
        if self.extras.airsim_port is not None:
            server = airsim_process(self.scenario, LOOPBACK, self.extras.airsim_port)
            self.table = (*self.table, server)
        config = self.extras.config
        self.session = Session(
            mission=self.identity.mission,
            token=self.identity.token,
            config=str(config.resolve()) if config else '',
        )
        self.supervisor = Supervisor(
            launches(self.table, self.directory, self.identity, config),
            child_environment(self.directory, has_agents=self.scenario.fleet.agents),
            on_start=self._note_process,
        )

    def run(self, console: Console) -> int:
        """Fly, and return the exit code."""
        log_to(self.directory)
        plain = make_display(console, self.directory.name, is_quiet=self.extras.is_quiet)
        display = SteadyDisplay(plain, self.terminal.close)
        display.say(f'run directory: {self.directory.path}')
        with self.processes(), display:
            self.extras.page.begin(self.directory)
            phase = self.fly(display, lambda phase: self._finish(console, phase))
        return self._finish(console, phase)

    def _finish(self, console: Console, phase: Phase) -> int:
        """Say how the mission ended, when all is done, and return the exit code."""
        self.directory.session.unlink(missing_ok=True)
        self.directory.photographs_token.unlink(missing_ok=True)
        remove_parts(self.directory)
        _log_end(self.directory, phase, self.text)
        seal(self.directory)
        if not self.extras.is_quiet:
            closing = _closing(self.directory, self.monitor, self.text, phase)
            console.print(closing, soft_wrap=True)
        elif phase is not Phase.COMPLETE:
            print(f'rocsafe: mission {phase.name.lower()}: {self.text}', file=sys.stderr)
        if self.interrupt.exit_code is not None:
            return self.interrupt.exit_code
        return EXIT_COMPLETE if phase is Phase.COMPLETE else EXIT_FAILED

    def _note_process(self, name: str, pid: int) -> None:
        """Write down a process for a run that is resumed after the death of this one."""
        self.session = self.session.with_process(name, pid)
        if not self.scenario.fleet.agents:
            return
        try:
            write_session(self.directory.session, self.session)
        except OSError as error:
            # A process is also started again in flight, which goes on.
            log.warning('%s: %s is not in it: %s', self.directory.session, name, error)

    @contextmanager
    def processes(self) -> Iterator[None]:
        """Start every process before ROS: its threads would prevent forking."""
        living = self.found.living if self.found else {}
        try:
            for name, process in living.items():
                self.supervisor.adopt(name, process)
                self.session = self.session.with_process(name, process.pid)
            for spec in self.table:
                if spec.is_here:
                    self.supervisor.start(spec.name, begin_as_fork)
            yield
        finally:
            self.supervisor.stop(must_hurry=lambda: self.interrupt.is_urgent)

    def fly(self, display: Display, finish: Callable[[Phase], int]) -> Phase:
        """Fly and return the outcome; `finish` is called instead if ROS cannot be shut down."""
        # Imported late: `rocsafe check` works without ROS.
        from rocsafe_orchestrator.orchestrator_node import OrchestratorNode, Spinner, ros_session

        with (
            ExitStack() as end,
            ros_session(self.identity, self.extras.config),
            self._hosts() as hosts,
        ):
            node = OrchestratorNode(self.scenario, self.monitor, self.identity)
            self.claim.close()
            mission = self._mission(node)
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
                confirmed=self.extras.confirmed,
                directory=self.directory,
                run_info=self.run_info,
                crew_watch=CrewWatch(self.scenario, self.monitor),
                real=frozenset(self.scenario.real_names),
                hosts=hosts,
            )
            try:
                run = MissionLoop(parts, node.deadlines.stop_s, self.started_s)
                return run.fly()
            finally:
                self.text, phase = mission.text, mission.phase
                watch = EndWatch(lambda: finish(phase), self.directory.log_of('end'))
                end.callback(watch.cancel)
                parts.spinner.close()

    @contextmanager
    def _hosts(self) -> Iterator[HostServer | None]:
        """Welcome the other hosts of the mission, if it has any; they end with it."""
        if not self.scenario.hosts:
            yield None
            return
        head, *others = self.scenario.hosts
        welcome = Welcome(
            mission=self.identity.mission,
            token=self.identity.token,
            scenario=self.scenario.to_yaml(),
        )
        addresses = {host.name: host.address for host in others}
        server = HostServer((head.address, JOIN_PORT), addresses, welcome, self.directory.plan)
        try:
            yield server
        finally:
            server.close()

    def _mission(self, node: Any) -> Mission:
        """Return the mission; of a resumed one, what was done is known."""
        speed, found = self.scenario.clock.speed, self.found
        mission = Mission(
            crew_of(self.scenario, self.table),
            node.deadlines,
            planning_budget_s=self.scenario.survey.effort.budget_s,
            slowest_beat_s=BEATS_PERIOD_S / speed if speed else 0.0,
            # Agents decide on rounds by themselves.
            extra_rounds=0 if found or self.scenario.fleet.agents else self.scenario.extra_rounds,
            replans=self.scenario.replan == 'on_loss' and not self.scenario.fleet.agents,
            has_agents=self.scenario.fleet.agents,
            first=found.first if found else Phase.PLANNING,
        )
        if found:
            node.requests.plans.resume(self.directory.plan)
            for shot in read_photographs(self.directory.images):
                self.monitor.on_stored(shot.shot_id)
            why = 'its process ended while nobody watched it'
            mission.fleet.note(found.lost, why, is_gone=True)
            mission.remarks.append(_found_text(found, self.monitor, self.table))
        return mission

    def _operator_watch(self) -> OperatorWatch | None:
        policy = OnOperatorLost(self.scenario.on_operator_lost)
        return OperatorWatch(policy) if self.scenario.real_names else None


def _marks(directory: RunDirectory) -> Sequence[PlaceMark]:
    """Return the places that operators have marked so far."""
    try:
        return read_marks(directory.path / LOG_NAME)
    except (EvidenceError, OSError) as error:
        log.warning('no marks of operators: %s', error)
        return ()


def _log_end(directory: RunDirectory, phase: Phase, text: str) -> None:
    """Write how the run has ended to its evidence log; the recorder ends before."""
    what = {'phase': phase.name.lower(), 'text': text}
    event = Event(time_s=time.time(), kind='end', by='orchestrator', what=what)
    try:
        with closing(EvidenceLog(directory.path / LOG_NAME)) as evidence:
            evidence.add([event])
    except OSError as error:
        log.warning('the evidence log has no end: %s', error)


@contextmanager
def locked(run: RunDirectory) -> Iterator[None]:
    """Lock a run: one process flies it, and its nodes see by the lock that it lives.

    Raises
    ------
    SetupError
        If another process flies it.
    """

    def refusal(holder: str) -> str:
        return f'{run.path} is being flown ({holder})'

    with file_lock(run.lock, f'process {os.getpid()}', refusal, LOCK_WAIT_S):
        yield


def _found_text(found: Found, monitor: Monitor, table: tuple[ProcessSpec, ...]) -> str:
    """Return what a resumed run has found, for people."""
    started = [spec.name for spec in table if spec.is_here and spec.name not in found.living]
    names = f', started again: {", ".join(started)}' if started else ''
    lost = f', lost: {", ".join(found.lost)}' if found.lost else ''
    count = f'{monitor.images_stored} of {monitor.images_expected} photographs are stored'
    return f'resumed: {count}, {len(found.living)} processes run{names}{lost}'


def log_to(directory: RunDirectory) -> None:
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
    seen = f'{monitor.viewpoints_visited} viewpoints visited'
    if monitor.images_expected:
        seen = f'{monitor.images_stored} images stored for {monitor.images_expected} viewpoints'
    lines.append(f'\n{seen}, {clock(monitor.flight_time_s)} under way')
    if monitor.peak is not None:
        lines.append(f', highest reading {peak_text(monitor.peak)}')
    if directory.report.is_file():
        lines.append(f'\nreport: {directory.report}')
    else:
        lines.append(f'\nno report was made: rocsafe report {directory.path}')
        lines.append(f'\nlogs: {directory.logs}')
    return lines
