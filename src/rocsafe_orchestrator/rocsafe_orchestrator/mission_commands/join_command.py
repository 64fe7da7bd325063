# SPDX-License-Identifier: Apache-2.0
"""`rocsafe join`: run the vehicles of this host for a mission whose head is on another."""

import logging
import os
import time
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from rocsafe_geo.storage.yaml_source import parse_yaml
from rocsafe_orchestrator.errors import EXIT_COMPLETE, EXIT_FAILED, SetupError
from rocsafe_orchestrator.mission_commands.mission_run import locked, log_to
from rocsafe_orchestrator.planning_commands.preflight_command import cleared
from rocsafe_orchestrator.process_table.launches import (
    child_environment,
    launches,
    require_executables,
)
from rocsafe_orchestrator.process_table.scene_export import export_scenes
from rocsafe_orchestrator.process_table.table import ProcessSpec, process_table
from rocsafe_orchestrator.process_table.values import ProcessEventKind
from rocsafe_orchestrator.processes.company import open_topics
from rocsafe_orchestrator.processes.domain_lock import domain_lock
from rocsafe_orchestrator.processes.hosts import (
    ALIVE_S,
    JOIN_PORT,
    Lines,
    LinkLostError,
    Welcome,
    join,
    write_photographs_token,
)
from rocsafe_orchestrator.processes.interrupt import Interrupt
from rocsafe_orchestrator.processes.process_start import begin_as_fork
from rocsafe_orchestrator.processes.ros_reach import reach
from rocsafe_orchestrator.processes.session import Session, read_session, write_session
from rocsafe_orchestrator.processes.supervisor import Supervisor
from rocsafe_orchestrator.run_directory import RunDirectory, create_run_directory
from rocsafe_ros.domain.mission_identity import MissionIdentity
from rocsafe_ros.domain.mission_partition import keep_to_mission
from rocsafe_ros.lease.control_lease import MISSION_VARIABLE
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_checks import flight_mistakes
from rocsafe_scenario.scenario_file import read_scenario, scenario_of

# The head is waited for, in the beginning, and asked again after it was lost, seconds.
JOIN_S = 600.0
AGAIN_S = 2.0
POLL_S = 0.1
PREFLIGHT_S = 60.0
# Keys that name files of a machine; the head may have them elsewhere.
FILE_KEYS = (
    ('camera', 'ground'), ('camera', 'scene_file'), ('survey', 'terrain_file'),
    ('radiation', 'scene_file'),
)  # fmt: skip


def join_scenario(path: Path, host: str, parent: Path, console: Console) -> int:
    """Run the processes of a host until the mission is over; return the exit code.

    Raises
    ------
    OrchestratorError
        If the host cannot take part.
    """
    own = read_scenario(path)
    addresses = {one.name: one.address for one in own.hosts}
    _require_host(own, host, path)
    head = (addresses[own.head], JOIN_PORT)
    console.print(f'{host}: waits for {own.head} at {head[0]}', soft_wrap=True)
    lines, welcome = _joined(host, head, addresses[host])
    scenario = _scenario_of_head(own, welcome, path)
    reach(scenario, host)
    holder = f'{welcome.mission}, process {os.getpid()}'
    try:
        with domain_lock(os.environ.get('ROS_DOMAIN_ID') or '0', holder):
            if scenario.linked_on(host):
                cleared(scenario, PREFLIGHT_S, scenario.clock.start, host)
            place = Place(host=host, address=addresses[host], head=head)
            return HostRun(place, scenario, welcome, parent, console).run(lines)
    finally:
        lines.close()


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Name and address of this host, and where the head is."""

    host: str
    address: str
    head: tuple[str, int]


class HostRun:
    """The processes of one host of a mission.

    When the head is lost its processes are left to their agents: they end when nothing is left to
    fly, or the head is heard again.
    """

    def __init__(
        self, place: Place, scenario: Scenario, welcome: Welcome, parent: Path, console: Console
    ) -> None:
        self._place, self._welcome, self._console = place, welcome, console
        identity = MissionIdentity(mission=welcome.mission, token=welcome.token)
        self._run = _directory(parent, welcome)
        self._run.scenario.write_text(scenario.to_yaml(), encoding='utf-8')
        write_photographs_token(self._run, welcome.token)
        export_scenes(scenario, self._run)
        table = process_table(scenario, self._run, place.host)
        self._table: tuple[ProcessSpec, ...] = tuple(spec for spec in table if spec.is_here)
        require_executables(self._table)
        os.environ[MISSION_VARIABLE] = welcome.token
        topics = open_topics(scenario)
        keep_to_mission(os.environ, self._run.parameters, welcome.token, topics)
        self._session = Session(mission=welcome.mission, token=welcome.token)
        # Without a head a process ends by itself, with exit code 0, when it is not needed.
        tasks = [replace(one, is_task=True) for one in launches(self._table, self._run, identity)]
        self._supervisor = Supervisor(
            tasks,
            child_environment(self._run, has_agents=True),
            on_start=self._note_process,
        )
        self._is_real = bool(scenario.linked_on(place.host))
        self._lock = ExitStack()
        self._interrupt = Interrupt()
        self._alive_s = self._again_s = 0.0
        self._failed = False

    def run(self, lines: Lines) -> int:
        """Run the processes to the end of the mission."""
        log_to(self._run)
        link: Lines | None = lines
        self._say(f'run directory: {self._run.path}')
        self._lock.enter_context(locked(self._run))
        try:
            self._start()
            while not self._is_over(link):
                link = self._attend(link) if link is not None else self._seek()
                self._watch(link)
        except _EndError:
            self._say('the mission is over')
        finally:
            self._supervisor.stop()
            self._lock.close()
            self._run.photographs_token.unlink(missing_ok=True)
            self._run.session.unlink(missing_ok=True)
        return EXIT_FAILED if self._failed or self._interrupt.count else EXIT_COMPLETE

    def _say(self, text: str) -> None:
        self._console.print(text, soft_wrap=True)

    def _start(self) -> None:
        living = {}
        if self._run.session.is_file():
            living = read_session(self._run.session).living()
        for spec in self._table:
            if spec.name in living:
                self._supervisor.adopt(spec.name, living[spec.name])
                self._note_process(spec.name, living[spec.name].pid)
        for spec in self._table:
            self._supervisor.start(spec.name, begin_as_fork)

    def _note_process(self, name: str, pid: int) -> None:
        self._session = self._session.with_process(name, pid)
        write_session(self._run.session, self._session)

    def _is_over(self, link: Lines | None) -> bool:
        """Return whether nothing is left to run, or the user ends it."""
        if self._interrupt.count == 1 and self._is_real:
            self._interrupt.withdraw()
            self._is_real = False
            self._say(
                'the vehicles of this host are real: rocsafe fleet return lands them; '
                'Ctrl-C again ends their bridge'
            )
        return self._interrupt.count > 0 or (link is None and not self._supervisor.running)

    def _attend(self, link: Lines) -> Lines | None:
        """Hear the head for a while; return the connection, None if it is lost."""
        try:
            if time.monotonic() >= self._alive_s:
                self._alive_s = time.monotonic() + ALIVE_S
                link.send(alive=True)
            message = link.receive(POLL_S)
        except LinkLostError as error:
            link.close()
            text = 'the vehicles here go on by themselves'
            self._say(f'the head is not heard any more ({error}): {text}')
            self._lock.close()
            return None
        if message.get('end'):
            raise _EndError
        if 'plan' in message and not self._run.plan.is_file():
            scratch = self._run.plan.with_suffix('.part')
            scratch.write_text(str(message['plan']), encoding='utf-8')
            scratch.replace(self._run.plan)
        return link

    def _seek(self) -> Lines | None:
        """Try to reach the head again; return the connection."""
        if time.monotonic() < self._again_s:
            time.sleep(POLL_S)
            return None
        self._again_s = time.monotonic() + AGAIN_S
        try:
            link, welcome = join(self._place.host, self._place.head, self._place.address)
        except (LinkLostError, SetupError):
            return None
        if welcome.token != self._welcome.token:
            link.close()
            return None
        self._say('the head is heard again')
        self._lock.enter_context(locked(self._run))
        return link

    def _watch(self, link: Lines | None) -> None:
        """Start processes again that have failed, and tell the head."""
        for event in self._supervisor.poll():
            text = f'{self._place.host}: {event.name} {event.text}'
            self._say(text)
            self._failed = self._failed or event.kind is ProcessEventKind.GAVE_UP
            restarted = event.name if event.kind is ProcessEventKind.RESTARTED else ''
            if link is not None:
                try:
                    link.send(text=text, restarted=restarted)
                except LinkLostError as error:
                    logging.getLogger(__name__).warning('the head was not told: %s', error)


class _EndError(Exception):
    """The head says that the mission is over."""


def _require_host(scenario: Scenario, host: str, path: Path) -> None:
    names = [one.name for one in scenario.hosts]
    if host not in names:
        known = ', '.join(names[1:]) or 'none: it has no hosts'
        raise ScenarioError(f'{path.name}: --host {host}: must be one of {known}')
    if host == scenario.head:
        raise ScenarioError(f'{path.name}: {host} is the first host: rocsafe run {path.name}')
    lines = flight_mistakes(scenario)
    if lines:
        raise ScenarioError('\n'.join(f'{path.name}: {line}' for line in lines))


def _joined(host: str, head: tuple[str, int], own: str) -> tuple[Lines, Welcome]:
    """Wait for the head and join it."""
    end_s = time.monotonic() + JOIN_S
    while True:
        try:
            return join(host, head, own)
        except LinkLostError as error:
            if time.monotonic() >= end_s:
                text = f'not reached within {JOIN_S:g} s: {error}'
                raise SetupError(f'{head[0]}:{head[1]}: {text}') from error
            time.sleep(AGAIN_S)


def _directory(parent: Path, welcome: Welcome) -> RunDirectory:
    """Return the directory of the mission on this host: that of an earlier start, or a new one."""
    run = RunDirectory((parent / welcome.mission).resolve())
    if run.session.is_file() and read_session(run.session).token == welcome.token:
        return run
    return create_run_directory(parent, welcome.mission)


def _scenario_of_head(own: Scenario, welcome: Welcome, path: Path) -> Scenario:
    """Return the scenario as the head flies it, with the files of this machine.

    Raises
    ------
    SetupError
        Naming what differs between the files of the hosts.
    """
    told: dict[str, Any] = parse_yaml(welcome.scenario, own.head)
    mine: dict[str, Any] = parse_yaml(own.to_yaml(), path.name)
    for block, key in FILE_KEYS:
        if key in mine.get(block, {}):
            told.get(block, {})[key] = mine[block][key]
    scenario = scenario_of(told, path)
    # The head's command line, its clock and the homes that its vehicles report.
    theirs = {**told, 'seed': own.seed, 'clock': mine['clock'], 'vehicles': mine['vehicles']}
    different = [key for key in mine if mine[key] != theirs.get(key)]
    if different or [v.name for v in own.vehicles] != [v.name for v in scenario.vehicles]:
        key = different[0] if different else 'vehicles'
        raise SetupError(f'{path.name}: {key} is not as on {own.head}: use the same file')
    return scenario
