# SPDX-License-Identifier: Apache-2.0
"""`rocsafe replay`: the nodes that estimate and map, fed from a recorded run."""

import os
import shutil
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_orchestrator.errors import EXIT_COMPLETE, EXIT_FAILED
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.process_table.launches import child_environment, launches
from rocsafe_orchestrator.process_table.scene_export import export_scenes
from rocsafe_orchestrator.process_table.table import process_table
from rocsafe_orchestrator.process_table.values import ProcessEventKind
from rocsafe_orchestrator.processes.domain_lock import domain_lock
from rocsafe_orchestrator.processes.interrupt import Interrupt
from rocsafe_orchestrator.processes.process_start import begin_as_fork
from rocsafe_orchestrator.processes.ros_reach import stay_on_this_machine
from rocsafe_orchestrator.processes.supervisor import Supervisor
from rocsafe_orchestrator.provenance import provenance, write_json
from rocsafe_orchestrator.recording.finalising import finalise
from rocsafe_orchestrator.replay.recorded_inputs import (
    RecordedInputs,
    ReplayError,
    read_inputs,
)
from rocsafe_orchestrator.run_directory import RunDirectory, create_run_directory, run_name
from rocsafe_ros.domain.mission_identity import MissionIdentity, new_identity
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario

if TYPE_CHECKING:
    from rocsafe_orchestrator.replay_node import ReplayNode

NODES = frozenset({'localizer', 'collector', 'mosaic'})
# Wall time within which the next input must be taken in, and the last readings be localized; a
# machine that is shared by 25 processes took more than 120 s for 6276 readings.
STANDSTILL_S = 60.0
LOCALIZE_S = 600.0
# Products are rounded to less than this.
SAME_M = 0.01


def replay(path: Path, parent: Path | None, console: Console) -> int:
    """Replay the run in `path` into a new run directory and return the exit code.

    Raises
    ------
    ScenarioError
        If `path` is no run directory with a recording.
    OrchestratorError
        If the nodes cannot be started.
    """
    run = RunDirectory(path.resolve())
    for needed in (run.run_info, run.scenario):
        if not needed.is_file():
            raise ScenarioError(f'{path}: is no run directory (it has no {needed.name})')
    # A run whose computer failed has segments only.
    finalise(run.path, [run.scenario, run.run_info, run.plan])
    scenario, inputs = read_scenario(run.scenario), read_inputs(run)
    stay_on_this_machine()
    now = datetime.now().astimezone()
    name = run_name(f'{scenario.name}-replay', now)
    with domain_lock(os.environ.get('ROS_DOMAIN_ID') or '0', name):
        out = create_run_directory(parent or run.path.parent, name)
        _copy(run, out, provenance(sys.argv, now))
        made = _Replay(
            scenario=scenario,
            inputs=inputs,
            directory=out,
            identity=new_identity(out.name),
            console=console,
        )
        interrupt = Interrupt()
        sources = made.feed(interrupt)
    if sources is None:
        return interrupt.exit_code or EXIT_FAILED
    from rocsafe_orchestrator.write_products import write_products

    write_products(out.path)
    console.print(_comparison(inputs.sources, sources), highlight=False, soft_wrap=True)
    console.print(str(out.report), highlight=False, soft_wrap=True)
    return EXIT_COMPLETE


def _copy(run: RunDirectory, out: RunDirectory, info: dict[str, object]) -> None:
    """Copy what the products are made from and the nodes do not make again."""
    for path in (run.scenario, run.run_info, run.plan, run.recording):
        if path.is_file():
            shutil.copyfile(path, out.path / path.name)
    for path in run.further_plans:
        (out.path / path.parent.name).mkdir()
        shutil.copyfile(path, out.path / path.parent.name / path.name)
    write_json(out.path / 'replay.json', {**info, 'replay_of': str(run.path)})


def _comparison(
    recorded: tuple[tuple[float, float, float], ...],
    found: tuple[tuple[float, float, float], ...],
) -> str:
    """Return in words how the sources found differ from those recorded."""
    if len(recorded) != len(found):
        return f'sources: {len(found)}, where {len(recorded)} were recorded'
    pairs = zip(recorded, found, strict=True)
    apart_m = max(
        (distance_m(GeoPosition(*a[:2]), GeoPosition(*b[:2])) for a, b in pairs), default=0.0
    )
    if apart_m <= SAME_M:
        return f'sources: {len(found)}, the same as recorded'
    return f'sources: {len(found)}, up to {apart_m:.2f} m from those recorded'


@dataclass(kw_only=True)
class _Replay:
    """The nodes of a replay and what feeds them."""

    scenario: Scenario
    inputs: RecordedInputs
    directory: RunDirectory
    identity: MissionIdentity
    console: Console

    def feed(self, interrupt: Interrupt) -> tuple[tuple[float, float, float], ...] | None:
        """Feed all inputs and return the sources found; None if interrupted.

        Raises
        ------
        ReplayError
            If the nodes do not take an input, or fail.
        """
        table = process_table(self.scenario, self.directory)
        table = tuple(spec for spec in table if spec.name in NODES)
        export_scenes(self.scenario, self.directory)
        supervisor = Supervisor(
            launches(table, self.directory, self.identity), child_environment(self.directory)
        )
        try:
            for spec in table:
                supervisor.start(spec.name, begin_as_fork)
            return self._fed(supervisor, interrupt)
        finally:
            supervisor.stop(must_hurry=lambda: interrupt.is_urgent)

    def _fed(
        self, supervisor: Supervisor, interrupt: Interrupt
    ) -> tuple[tuple[float, float, float], ...] | None:
        # Imported late, as in `rocsafe run`: the processes are forked before ROS starts.
        from rocsafe_orchestrator.orchestrator_node import ros_session
        from rocsafe_orchestrator.replay_node import ReplayNode, serving

        with ros_session(self.identity):
            node = ReplayNode(self.inputs, self.scenario.vehicle_names)
            with serving(node) as serve:
                waits = _Waits(serve=serve, supervisor=supervisor, interrupt=interrupt)
                if not self._done(node, waits):
                    return None
            for shot_id, why in node.rejected.items():
                self.console.print(f'{shot_id}: {why}', highlight=False)
            return node.sources

    def _done(self, node: 'ReplayNode', waits: '_Waits') -> bool:
        """Wait until all is fed, localized and mapped; return False if interrupted."""
        while left := node.feed.left:
            what = f'the next of {left} inputs was not taken in'
            if not waits.until(partial(node.feed.has_less_than, left), what, STANDSTILL_S):
                return False
        if not waits.until(node.is_localized, 'not localized', LOCALIZE_S):
            return False
        saved, limit_s = node.save(), Deadlines().map_timeout_s
        return waits.until(saved.done, 'the mosaic was not written', limit_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Waits:
    """Waits with deadlines, in which the node is served and the processes are watched."""

    serve: Callable[[], None]
    supervisor: Supervisor
    interrupt: Interrupt

    def until(self, is_so: Callable[[], bool], otherwise: str, limit_s: float) -> bool:
        """Return True when something is so, False if interrupted.

        Raises
        ------
        ReplayError
            If it is not so within `limit_s`, or a process failed for good.
        """
        end_s = time.monotonic() + limit_s
        while not is_so():
            self.serve()
            for event in self.supervisor.poll():
                if event.kind is ProcessEventKind.GAVE_UP:
                    raise ReplayError(f'{event.name} {event.text}')
            if self.interrupt.count:
                return False
            if time.monotonic() > end_s:
                raise ReplayError(f'{otherwise} within {limit_s:g} s')
        return True
