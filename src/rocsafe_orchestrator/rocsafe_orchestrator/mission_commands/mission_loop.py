# SPDX-License-Identifier: Apache-2.0
"""The main loop of a run: supervises processes, advances the mission, shows its state."""

import signal
import time
from collections import deque
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from rocsafe_orchestrator.contamination import mark
from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.mission.closing import REPORT
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.status import FlightState, Monitor, Pace, RunStatus
from rocsafe_orchestrator.mission_commands.confirmation import DRIVE, PLAN, Confirmation
from rocsafe_orchestrator.mission_commands.crew_watch import CrewWatch
from rocsafe_orchestrator.mission_commands.progress import Display
from rocsafe_orchestrator.mission_commands.terminal import Terminal
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Situation
from rocsafe_orchestrator.process_table.table import ProcessSpec
from rocsafe_orchestrator.process_table.values import ProcessEvent, ProcessEventKind
from rocsafe_orchestrator.processes.disk_space import shortage
from rocsafe_orchestrator.processes.hosts import HostServer
from rocsafe_orchestrator.processes.interrupt import Interrupt
from rocsafe_orchestrator.processes.supervisor import Supervisor
from rocsafe_orchestrator.provenance import write_json
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_orchestrator.watches.decisions import ERROR, WARN, Decision, Decisions
from rocsafe_orchestrator.watches.operator_watch import (
    LONGEST_S,
    OperatorNews,
    OperatorWatch,
    addressees,
)

if TYPE_CHECKING:  # the loop is tested without ROS
    from rocsafe_orchestrator.orchestrator_node import OrchestratorNode, Spinner

TICK_S = 0.05
# Pause between two looks at which processes are ready, as a multiple of the time of a look.
LOOK_PAUSE = 4.0
SHOW_PERIOD_S = 0.25
PUBLISH_PERIOD_S = 0.5
DISK_PERIOD_S = 1.0
# If simulated time stands still for longer, the participants are asked which one is late.
STALL_WATCH_S = 1.0
# The end of a run does not wait for the landing of a vehicle that is silent for longer.
LONGEST_SILENCE_S = 15.0
# The phases after the flights.
AFTER_FLIGHT = frozenset({Phase.MAPPING, Phase.DRIVING, Phase.REPORTING})
# States of a ground vehicle that stands and has no drive.
DRIVER_HOME = frozenset({FlightState.DISARMED, FlightState.LANDED, FlightState.CRASHED})
AFTER_INTERRUPT = 'map and report of what there is are made; the third ends at once without them'
# How bad the end of a process is for the mission.
_SEVERITIES = {ProcessEventKind.ENDED: WARN, ProcessEventKind.GAVE_UP: ERROR}


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """The parts of a run.

    Attributes
    ----------
    operator
        Watched where real vehicles fly.
    confirmed
        Hashes of plans by which real vehicles may take off.
    hosts
        Welcomes the other hosts of the mission; None: there are none.
    """

    table: tuple[ProcessSpec, ...]
    participants: tuple[str, ...]
    mission: Mission
    monitor: Monitor
    supervisor: Supervisor
    node: 'OrchestratorNode'
    spinner: 'Spinner'
    display: Display
    interrupt: Interrupt
    terminal: Terminal
    operator: OperatorWatch | None
    confirmed: frozenset[str]
    directory: RunDirectory
    run_info: dict[str, Any]
    crew_watch: CrewWatch
    real: frozenset[str]
    hosts: HostServer | None = None


class MissionLoop:
    """Flies one mission from the start of its processes to their end.

    Parameters
    ----------
    parts
        The parts of the run.
    stop_s
        Time within which a process must end when asked, seconds.
    started_s
        When the run began, by `time.monotonic`.
    """

    def __init__(self, parts: Parts, stop_s: float, started_s: float) -> None:
        self._parts = parts
        self._stop_s = stop_s
        self._started_s = started_s
        self._pace = Pace()
        self._ready: frozenset[str] = frozenset()
        self._next_look_s = 0.0
        self._show_at_s = self._publish_at_s = self._look_at_disk_s = 0.0
        self._is_shortage_told = False
        self._lands_by_s: float | None = None
        self._shown_phase: Phase | None = None
        self._interrupted_by: signal.Signals | None = None
        requests = parts.node.requests
        self._confirmations = [
            Confirmation(waiting, parts.terminal, parts.display, parts.confirmed, subject)
            for waiting, subject in ((requests.plans, PLAN), (requests.drives, DRIVE))
            if waiting is not None
        ]
        self._marked: dict[str, str] = {}
        self._decisions = Decisions()
        self._own = [spec.name for spec in parts.table if spec.is_here]

    def fly(self) -> Phase:
        """Run the mission to its end and return how it ended; no process is left."""
        parts = self._parts
        parts.directory.flown.unlink(missing_ok=True)
        try:
            parts.node.requests.begin(parts.mission)
            parts.node.publish_region()
            while not parts.mission.phase.is_over and not parts.interrupt.is_urgent:
                parts.spinner.spin_for(TICK_S)
                self._tick(time.monotonic())
            if not parts.mission.phase.is_over:
                parts.mission.cancel(parts.interrupt.text)
                parts.mission.abandon()
            self._show(time.monotonic())
        finally:
            self._stop([*self._own, REPORT])
            self._write_outcome(is_over=True)
        return parts.mission.phase

    def _tick(self, now_s: float) -> None:
        parts = self._parts
        may_order = self._watch_operator(now_s)
        for one in self._confirmations:
            if digest := one.watch(now_s):
                parts.run_info[f'confirmed_{one.subject.what}'] = digest
                self._say(f'{one.subject.what} {digest} is confirmed')
        if parts.interrupt.count and not parts.mission.is_cancelled:
            parts.mission.cancel(parts.interrupt.text)
            self._say(f'{parts.interrupt.text}: {AFTER_INTERRUPT}')
        self._watch_disk(now_s)
        for event in parts.supervisor.poll():
            self._on_event(event, now_s)
        self._hear_hosts(now_s)
        for vehicle, why in parts.monitor.turned_back.items():
            seen = parts.monitor.vehicle(vehicle)
            if seen.may_turn_back:
                parts.mission.takeover.turn_back(vehicle, why, is_waiting=seen.is_waiting)
        parts.mission.remarks += parts.crew_watch.advance()
        self._mark_contaminated()
        if may_order and not self._waits_for_landing(now_s):
            for order in parts.mission.advance(now_s, self._situation(now_s)):
                self._tell(self._decisions.of_order(order))
                self._carry_out(order)
        parts.node.requests.ask_again()
        self._tell(self._decisions.of_mission(parts.mission))
        while parts.mission.remarks:
            self._say(parts.mission.remarks.pop(0))
        parts.node.watch_steps(parts.mission.stalled_s > STALL_WATCH_S)
        self._show(now_s)

    def _watch_operator(self, now_s: float) -> bool:
        """Let no signal end a flight of real vehicles; return whether orders may be sent."""
        watch, interrupt = self._parts.operator, self._parts.interrupt
        if watch is None:
            return True
        found = {vehicle.name: vehicle.state for vehicle in self._parts.monitor.vehicles}
        states = found.values()
        interrupt.is_guarded = not watch.may_end(now_s, states)
        if not interrupt.is_guarded:
            if watch.ends and self._interrupted_by is not None:
                interrupt.end(self._interrupted_by)
            return True
        news = OperatorNews(
            is_interrupted=interrupt.count > 0,
            has_terminal=self._parts.terminal.is_there and interrupt.first is signal.SIGINT,
            answer=self._parts.terminal.typed(),
        )
        if interrupt.count:
            self._interrupted_by = interrupt.first
            interrupt.withdraw()
        requests = self._parts.node.requests
        ours = {name: at for name, at in found.items() if name not in requests.led_by_others}
        if self._parts.mission.phase in AFTER_FLIGHT:
            ours = {name: at for name, at in ours.items() if name in self._parts.real}
            watch.end_flight(now_s, ours.values())
        verb = watch.advance(now_s, news, ours.values())
        if verb is not None:
            requests.command_fleet(verb, addressees(ours))
        while watch.remarks:
            self._say(watch.remarks.pop(0))
        return not watch.ends

    def _waits_for_landing(self, now_s: float) -> bool:
        """Return whether the report waits, whose begin ends the bridge, for a real vehicle."""
        parts = self._parts
        aloft = [
            status.name
            for status in parts.monitor.vehicles
            if status.name in parts.real
            and status.is_aloft
            and parts.monitor.heard_ago_s(status.name, now_s) < LONGEST_SILENCE_S
        ]
        if parts.mission.phase is not Phase.REPORTING or not aloft:
            return False
        if self._lands_by_s is None:
            self._lands_by_s = now_s + LONGEST_S
            self._say(f'{", ".join(aloft)}: in the air, the report waits for its landing')
        return now_s < self._lands_by_s

    def _say(self, remark: str) -> None:
        self._tell([Decision(kind='remark', text=remark)])
        self._parts.display.say(remark)

    def _mark_contaminated(self) -> None:
        """Report the vehicles that may be contaminated; write the real ones to a file."""
        parts = self._parts
        news = {n: w for n, w in parts.monitor.contaminated.items() if n not in self._marked}
        if not news:
            return
        self._marked.update(news)
        parts.mission.remarks += [f'{n}: may be contaminated, {why}' for n, why in news.items()]
        run = parts.directory
        real = {n: f'{why} in {run.name}' for n, why in news.items() if n in parts.real}
        parts.mission.remarks += filter(None, [mark(run.path.parent, real)])

    def _tell(self, decisions: list[Decision]) -> None:
        for decision in decisions:
            self._parts.node.tell(decision, time.monotonic() - self._started_s)

    def _on_event(self, event: ProcessEvent, now_s: float) -> None:
        mission = self._parts.mission
        if event.kind is ProcessEventKind.DONE and event.name == REPORT:
            mission.answered(Order(kind=OrderKind.WRITE_PRODUCTS))
            return
        self._parts.display.say(f'{event.name} {event.text}')
        if (severity := _SEVERITIES.get(event.kind)) is not None:
            text = f'process {event.name} {event.text}'
            self._tell([Decision(kind='restart', text=text, severity=severity)])
        if event.kind is ProcessEventKind.RESTARTED:
            mission.restarted(event.name, now_s)
        elif event.kind is ProcessEventKind.GAVE_UP:
            mission.gave_up(event.name, event.text)

    def _hear_hosts(self, now_s: float) -> None:
        """Take what other hosts tell: who has joined, is lost, or started a process again."""
        news = self._parts.hosts.news if self._parts.hosts else deque()
        while news:
            one = news.popleft()
            self._say(one.text)
            if one.restarted:
                self._parts.mission.restarted(one.restarted, now_s)

    def _situation(self, now_s: float) -> Situation:
        parts = self._parts
        if parts.mission.phase is Phase.STARTING and now_s >= self._next_look_s:
            self._ready = parts.node.ready(parts.table)
            # A look at a hundred vehicles takes a second of the processor that they start on.
            self._next_look_s = now_s + LOOK_PAUSE * (time.monotonic() - now_s)
        self._pace.note(now_s, parts.monitor.flight_time_s)
        waiting_for = parts.node.waiting_for(parts.participants)
        silences_s = parts.mission.fleet.silences_s(
            parts.mission.stalled_s, waiting_for, partial(parts.monitor.heard_ago_s, now_s=now_s)
        )
        return Situation(
            ready=self._ready,
            simulated_s=parts.monitor.time_s,
            waiting_for=waiting_for,
            images_stored=parts.monitor.images_stored,
            images_rejected=len(parts.monitor.rejections),
            images_expected=parts.monitor.images_expected,
            still=parts.monitor.still,
            aloft=frozenset(
                status.name
                for status in parts.monitor.vehicles
                if status.is_aloft and silences_s[status.name] < LONGEST_SILENCE_S
            ),
            unsettled=parts.monitor.unsettled,
            is_driver_home=parts.monitor.driver.state in DRIVER_HOME,
            is_driver_unsettled=parts.monitor.driver.shots_pending > 0,
            agents_are_done=parts.node.agents_are_done,
            agents_plan=parts.node.agents_plan,
            sightings={
                name: parts.monitor.sighting(
                    name,
                    now_s,
                    silent_s,
                    is_led_by_others=name in parts.node.requests.led_by_others,
                    is_left_out=parts.node.steps.is_left_out(
                        parts.mission.fleet.process_of(name),
                        now_s - parts.monitor.heard_ago_s(name, now_s),
                    ),
                )
                for name, silent_s in silences_s.items()
            },
        )

    def _carry_out(self, order: Order) -> None:
        if order.kind is not OrderKind.WRITE_PRODUCTS:
            self._parts.node.requests.send(order)
            if order.kind is OrderKind.SAVE_MOSAIC and not self._parts.monitor.driver.name:
                # All is measured: sources are estimated while the map is written.
                self._start_report()
            return
        self._parts.mission.accepted(order)
        self._show(time.monotonic())
        # Only after the nodes have ended is the recording complete and no image being written.
        self._stop(self._own)
        self._write_outcome(is_over=False)
        if self._parts.interrupt.is_urgent:
            return
        self._parts.directory.flown.touch()
        self._start_report()

    def _start_report(self) -> None:
        """Start the process that makes the products, unless it runs."""
        try:
            self._parts.supervisor.start(REPORT)
        except SetupError as error:
            self._parts.mission.gave_up(REPORT, str(error))

    def _stop(self, names: list[str]) -> None:
        interrupt = self._parts.interrupt
        self._parts.supervisor.stop(
            names, deadline_s=self._stop_s, must_hurry=lambda: interrupt.is_urgent
        )

    def _write_outcome(self, *, is_over: bool) -> None:
        """Write the outcome to ``run.json``; before the products are made it is preliminary."""
        mission = self._parts.mission
        self._parts.run_info.update(
            outcome=(mission.phase if is_over else mission.outcome).name.lower(),
            outcome_text=mission.text,
            wall_time_s=round(time.monotonic() - self._started_s, 3),
            restarts=self._parts.supervisor.restarts,
            lost_vehicles=dict(mission.fleet.lost),
            may_be_contaminated=self._parts.monitor.contaminated,
            expected_crew_doses_usv=self._parts.crew_watch.doses_usv,
            rejected_images=self._parts.monitor.rejections,
        )
        try:
            write_json(self._parts.directory.run_info, self._parts.run_info)
        except OSError as error:
            self._parts.display.say(f'{self._parts.directory.run_info}: {error.strerror}')

    def _watch_disk(self, now_s: float) -> None:
        """Break off while there is room for what was measured; real vehicles land first."""
        if now_s < self._look_at_disk_s:
            return
        self._look_at_disk_s = now_s + DISK_PERIOD_S
        text = shortage(self._parts.directory.path)
        if text and not self._parts.interrupt.is_guarded:
            self._parts.mission.break_off(text)
        elif text and not self._is_shortage_told:
            self._is_shortage_told = True
            self._say(text)

    def _show(self, now_s: float) -> None:
        mission = self._parts.mission
        is_news = mission.phase is not self._shown_phase
        self._shown_phase = mission.phase
        status = None
        if is_news or now_s >= self._publish_at_s:
            self._publish_at_s = now_s + PUBLISH_PERIOD_S
            status = self._status(now_s)
            self._parts.node.publish(status)
        if is_news or now_s >= self._show_at_s:
            self._show_at_s = now_s + SHOW_PERIOD_S
            self._parts.display.show(status or self._status(now_s))

    def _status(self, now_s: float) -> RunStatus:
        mission, monitor = self._parts.mission, self._parts.monitor
        return RunStatus(
            phase=mission.phase,
            text=mission.text,
            vehicles=monitor.vehicles,
            driver=monitor.driver if monitor.driver.name else None,
            images_stored=monitor.images_stored,
            images_expected=monitor.images_expected,
            viewpoints_planned=monitor.viewpoints_planned,
            viewpoints_visited=monitor.viewpoints_visited,
            peak=monitor.peak,
            flight_time_s=monitor.flight_time_s,
            wall_time_s=now_s - self._started_s,
            real_time_factor=self._pace.factor,
            restarts=self._parts.supervisor.restarts,
        )
