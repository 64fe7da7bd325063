# SPDX-License-Identifier: Apache-2.0
"""State machine of a mission: its phases and their conditions. Time is an argument.

`Mission.advance` returns orders; the caller carries them out and reports with `accepted`,
`answered` and `refused`. A failure ends the present phase only: the mosaic and the products are
still made from what was recorded.
"""

from collections.abc import Callable, Iterable

from rocsafe_orchestrator.mission.closing import MOSAIC, REPORT, Closing
from rocsafe_orchestrator.mission.driving import DriveEnd, Driving
from rocsafe_orchestrator.mission.landing import Landing
from rocsafe_orchestrator.mission.losses import PLANNER, WORLD, Losses
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission.rounds import Rounds
from rocsafe_orchestrator.mission.takeover import AGENTS, Takeover
from rocsafe_orchestrator.mission.time_watch import TimeWatch
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.phase_record import PhaseRecord
from rocsafe_orchestrator.mission_state.request import Order, OrderKind, Status
from rocsafe_orchestrator.mission_state.request_book import RequestBook
from rocsafe_orchestrator.mission_state.situation import Crew, Situation


class Mission(PhaseRecord):
    """One mission from the start of its processes to its report.

    Parameters
    ----------
    crew
        Vehicles and processes that take part.
    deadlines
        Limits of all waits.
    planning_budget_s
        Wall time that the planner may use.
    slowest_beat_s
        Wall time between two reports of the vehicles in normal operation, seconds.
    extra_rounds
        Largest number of further flights to the places where readings are most informative.
    replans
        Whether the other vehicles take over the viewpoints of a lost one.
    has_agents
        Whether agents of the vehicles do that by themselves.
    first
        Phase that follows the start of the processes: a resumed mission is beyond its plan.

    Attributes
    ----------
    fleet
        Presence of the vehicles, and the replanning after losses.
    takeover
        How others take over from a vehicle.
    rounds
        Further flights after the survey.
    """

    def __init__(
        self,
        crew: Crew,
        deadlines: Deadlines,
        *,
        planning_budget_s: float = 0.0,
        slowest_beat_s: float = 0.0,
        extra_rounds: int = 0,
        replans: bool = False,
        has_agents: bool = False,
        first: Phase = Phase.PLANNING,
    ) -> None:
        super().__init__()
        self._first = first
        self._crew = crew
        self._deadlines = deadlines
        vehicles_s = deadlines.plan_vehicle_s * len(crew.vehicle_processes)
        self._plan_timeout_s = deadlines.plan_s + planning_budget_s + vehicles_s
        self._stall_timeout_s = deadlines.stall_timeout_s + slowest_beat_s
        self._requests = RequestBook(deadlines.repeat_s)
        self.fleet = Losses(
            crew,
            self._requests,
            deadlines.lease(slowest_beat_s),
            is_replaced=replans,
        )
        self._time = TimeWatch(self._requests)
        self.takeover = Takeover(
            self, self._requests, self.fleet, self._time, has_agents=has_agents
        )
        self._landing = Landing(self, deadlines.homecoming_s)
        self._driving = Driving(self, self._requests, deadlines, crew.driver)
        self._closing = Closing(self, self._requests, deadlines, self._after_map)
        self.rounds = Rounds(self, self._requests, self._closing, self._time, extra_rounds)
        self._shots_before, self._has_images = 0, False
        self._agents_plan_s = 0.0

    @property
    def text(self) -> str:
        """Why the mission failed or was cancelled; empty if all is well."""
        return '; '.join(self.faults)

    @property
    def stalled_s(self) -> float:
        """Wall time for which simulated time has stood still, seconds."""
        return self._time.stalled_s

    def advance(self, now_s: float, situation: Situation) -> list[Order]:
        """Enter the next phase if this one is over, and return the orders to send now."""
        self.passed_s(now_s)
        self._has_images = situation.images_stored > 0
        step: Callable[[float, Situation], None] | None = {
            Phase.STARTING: self._start,
            Phase.PLANNING: self._plan,
            Phase.FLYING: self._fly,
            Phase.COLLECTING: self._closing.collect,
            Phase.MAPPING: self._closing.save_map,
            Phase.DRIVING: self._drive,
            Phase.REPORTING: self._closing.write_products,
        }.get(self.phase)
        if step is not None:
            step(now_s, situation)
        return [] if self.phase.is_over else self._requests.due(now_s)

    # Reports of the caller.

    def accepted(self, order: Order) -> bool:
        """Note that the server has accepted `order`; its answer comes later.

        Returns whether the mission waited for that: not if the order was sent twice and the
        acceptance came before.
        """
        request = self._requests.of(order)
        return request is not None and request.accept()

    def answered(self, order: Order) -> None:
        """Note that `order` was carried out."""
        self._requests.finish(order.kind, order.vehicle)

    def refused(self, order: Order, text: str) -> None:
        """Note that `order` cannot be carried out, and why."""
        request = self._requests.of(order)
        if request is None or request.status is Status.DONE:
            return
        request.finish()
        if self.phase is Phase.DRIVING:
            self.fault(text)
            self._driving.give_up()
            return
        if order.kind in (OrderKind.HOLD, OrderKind.RETURN):
            return  # it is on the ground or landing
        if order.kind is OrderKind.RETREAT:
            self.remarks.append(f'{text}: it is told to return home')
            self._requests.renew(OrderKind.RETURN, request.server, order.vehicle)
            return
        if order.kind is OrderKind.RESUME:
            self.fault(text)
            self.fleet.withdraw(order.vehicle, text)
        elif self.fleet.is_gathering and order.kind is OrderKind.PLAN:
            self.fault(f'no plan for the rest: {text}')
            self.fleet.go_on()
            self.enter(Phase.FLYING)
        elif self.rounds.is_further and self.phase is Phase.PLANNING:
            self.rounds.end(f'no further round: {text}')
        else:
            self.fault(text)

    def planned(self, routed: Iterable[str], visited: int = 0) -> None:
        """Note the plan: the vehicles named have viewpoints to visit.

        `visited` is the number of viewpoints of the previous plan that it leaves out because they
        are photographed.
        """
        plan = self._requests.get(OrderKind.PLAN)
        if plan is None or plan.status is Status.DONE or self.phase is not Phase.PLANNING:
            return
        plan.finish()
        if self.fleet.is_gathering:
            self._closing.shots = self._shots_before = self._shots_before + visited
            self.fleet.go_on(routed)
            self.enter(Phase.FLYING)
            return
        self._shots_before = self._closing.shots
        for vehicle in routed:
            self._requests.add(OrderKind.FLY, self._crew.vehicle_processes[vehicle], vehicle)

    def nothing_left(self) -> None:
        """Note that a lost vehicle has left nothing to photograph: the others fly on."""
        self.fleet.go_on()
        self.enter(Phase.FLYING)

    def flown(
        self, vehicle: str, shots: int, fault: str = '', *, is_refused: bool = False
    ) -> None:
        """Note that `vehicle` has ended its flight with `shots` photographs.

        `fault` says why if not as planned. A vehicle that refused its route in the air is told
        to return home.
        """
        request = self._requests.get(OrderKind.FLY, vehicle)
        if request is None or request.status is Status.DONE:
            return
        request.finish()
        if self.takeover.has_agents:
            # The image store counts: agents give vehicles other routes meanwhile.
            return
        self._closing.shots += shots
        if not fault:
            return
        if not self.takeover.replaced([vehicle], fault):
            self.fault(f'{vehicle}: {fault}')
        if is_refused:
            self.fleet.withdraw(vehicle, fault)

    def drive_planned(self) -> None:
        """Note that the drive of the ground vehicle is planned."""
        if self.phase is Phase.DRIVING:
            self._driving.planned()

    def driven(self, text: str, ending: DriveEnd = DriveEnd.AT_HOME) -> None:
        """Note that the ground vehicle has ended its drive; `text` says why if not as planned."""
        if self.phase is Phase.DRIVING:
            self._driving.driven(text, ending)

    def restarted(self, process: str, now_s: float) -> None:
        """Repeat the requests to `process`, which has lost them by its restart."""
        self._time.rest(now_s)
        self._closing.restarted(now_s)
        for request in self._requests:
            if request.server == process:
                request.reset()
        if process == WORLD:
            self.fleet.dismiss_again()
        clock = self._requests.get(OrderKind.RUN_CLOCK)
        if clock is not None and (
            process == WORLD or process in self._crew.vehicle_processes.values()
        ):
            # The clock may have been paused while the process was not running.
            clock.status = Status.WAITING
            clock.reset()

    def gave_up(self, process: str, text: str) -> None:
        """Note that `process` is not started again."""
        if process == REPORT:
            self.refused(Order(kind=OrderKind.WRITE_PRODUCTS), f'the products: {text}')
        elif self.phase is Phase.MAPPING and process != MOSAIC:
            self.fault(f'{process} {text}')
        elif self.phase is Phase.DRIVING:
            self._fail(f'{process} {text}')
        elif process == AGENTS and self.phase < Phase.MAPPING:
            self.takeover.do_without_agents(text)
        elif self.takeover.replaced(self.fleet.of_process(process), text, is_gone=True):
            return
        elif self.phase < Phase.REPORTING:
            self._fail(f'{process} {text}', has_mosaic=process != MOSAIC)

    def cancel(self, text: str) -> None:
        """Cancel the mission: time stops, map and products are made within a short time."""
        if self.phase.is_over or self.is_cancelled:
            return
        super().cancel(text)
        if self.phase is Phase.DRIVING:
            self.enter(Phase.REPORTING)
        elif self.phase >= Phase.MAPPING:
            super().enter(self.phase)
        elif self._has_images:
            self.enter(Phase.MAPPING)
            self._requests.add(OrderKind.PAUSE_CLOCK, WORLD)
        else:
            self.enter(Phase.REPORTING)

    def break_off(self, text: str) -> None:
        """End the flight for a reason outside of it; map and products are made."""
        if self.phase < Phase.MAPPING or self.phase is Phase.DRIVING:
            self._fail(text)

    def abandon(self) -> None:
        """End at once, without products."""
        self.enter(self.outcome if self.is_cancelled else Phase.CANCELLED)

    # The phases.

    def _start(self, now_s: float, situation: Situation) -> None:
        missing = sorted(self._crew.processes - situation.ready)
        if not missing:
            self._begin(situation)
        elif self.passed_s(now_s) > self._deadlines.start_timeout_s:
            limit = self._deadlines.start_timeout_s
            self._fail(f'{", ".join(missing)}: not ready within {limit:g} s')

    def _begin(self, situation: Situation) -> None:
        """Enter the phase that follows the start of the processes."""
        self.enter(self._first)
        if self._first is Phase.PLANNING:
            self._requests.add(OrderKind.PLAN, PLANNER)
        elif self._first is Phase.FLYING:
            self._requests.add(OrderKind.RUN_CLOCK, WORLD)
        elif situation.images_stored < situation.images_expected:
            count = f'{situation.images_stored} of {situation.images_expected}'
            self.fault(f'only {count} photographs are stored')

    def _plan(self, now_s: float, situation: Situation) -> None:
        if self.fleet.is_gathering:
            self._gather(now_s, situation)
        elif self.faults:
            self._fail()
        elif self._requests.all_done(OrderKind.PLAN):
            self.enter(Phase.FLYING)
        elif self.rounds.is_further and self.passed_s(now_s) > self._plan_timeout_s:
            self.rounds.end(f'no further round planned within {self._plan_timeout_s:g} s')
        elif self.passed_s(now_s) > self._plan_timeout_s:
            self._fail(f'{PLANNER}: no plan within {self._plan_timeout_s:g} s')

    def _gather(self, now_s: float, situation: Situation) -> None:
        """Let the vehicles that are not lost hold, and plan the rest for them."""
        if self.takeover.watch(situation):
            return
        self.fleet.advance(now_s, situation)
        if self.fleet.is_paused:
            self._time.rest(now_s)
        else:
            self._watch_time(now_s, situation)
        if self.fleet.is_gathering and self.passed_s(now_s) > self._plan_timeout_s:
            moving = ', '.join(self.fleet.moving(situation))
            why = f': {moving} did not stop' if moving else ''
            self.fault(f'the rest was not planned within {self._plan_timeout_s:g} s{why}')
            self.fleet.go_on()
            self.enter(Phase.FLYING)

    def _after_map(self) -> None:
        if self.is_cancelled:
            self.enter(Phase.REPORTING)
            return
        self._time.begin()
        self._driving.begin()

    def _drive(self, now_s: float, situation: Situation) -> None:
        self._driving.advance(now_s, situation)
        if self.phase is not Phase.DRIVING or self._driving.is_waiting:
            self._time.rest(now_s)
        else:
            self._watch_time(now_s, situation)

    def _fly(self, now_s: float, situation: Situation) -> None:
        if self.takeover.watch(situation):
            return
        routes = self._requests.of_kind(OrderKind.FLY)
        is_flying = bool(situation.aloft) or not self._requests.all_done(OrderKind.FLY)
        if is_flying and all(request.status is not Status.WAITING for request in routes):
            self._requests.add(OrderKind.RUN_CLOCK, WORLD)
        if self._requests.all_done(OrderKind.FLY) and self._are_over(now_s, situation):
            self.rounds.go_on_or_collect()
            return
        is_running = self._time.is_begun or self._requests.all_done(OrderKind.RUN_CLOCK)
        if not self._are_late(now_s) and is_running:
            self._watch_time(now_s, situation)

    def _are_over(self, now_s: float, situation: Situation) -> bool:
        """Return whether all flights are over: with agents when these have nothing left."""
        if not self.takeover.has_agents:
            return self._landing.are_down(now_s, situation)
        if situation.agents_are_done:
            self._closing.shots = situation.images_expected
        return self._landing.is_agreed(now_s, situation)

    def _are_late(self, now_s: float) -> bool:
        """Return whether a node did not accept a request in time; a vehicle is lost then."""
        limit = self._deadlines.accept_s
        homeward = (OrderKind.RETURN, OrderKind.RETREAT)
        orders = (r for r in self._requests if r.order.kind not in homeward)
        late = [request for request in orders if request.waited_s(now_s) > limit]
        if not late:
            return False
        what = f'did not accept to {late[0].order.kind.value} within {limit:g} s'
        if late[0].order.kind is OrderKind.RESUME:
            self.refused(late[0].order, f'{late[0].order.vehicle}: {what}')
            return True
        vehicles = [r.order.vehicle for r in late if r.order.kind is OrderKind.FLY]
        if not self.takeover.replaced(vehicles, what, is_gone=True):
            names = ', '.join(dict.fromkeys(request.server for request in late))
            self._fail(f'{names}: {what}')
        return True

    def _watch_time(self, now_s: float, situation: Situation) -> None:
        if self._agents_plan(now_s, situation):
            self._time.rest(now_s)
            return
        self._time.look(now_s, situation.simulated_s)
        if self.fleet.lets_time_run or not self.fleet.is_gathering:
            self._time.run_again(now_s, is_answered=self.fleet.is_gathering)
        if self.stalled_s > self._stall_timeout_s:
            names = ', '.join(situation.waiting_for) or 'an unknown node'
            text = f'simulated time stands still for {self.stalled_s:.0f} s'
            self._fail(f'{text}: waits for {names}')

    def _agents_plan(self, now_s: float, situation: Situation) -> bool:
        """Return whether time stands still for agents that plan, as long as a plan may take."""
        if not situation.agents_plan:
            self._agents_plan_s = now_s
        return now_s - self._agents_plan_s < self._plan_timeout_s and situation.agents_plan

    # State.

    def _fail(self, text: str = '', *, has_mosaic: bool = True) -> None:
        """End this phase; map and products are made from what was recorded."""
        if text:
            self.fault(text)
        is_extra = self.rounds.is_further and self.phase is not Phase.DRIVING
        has_images = self.phase in (Phase.FLYING, Phase.COLLECTING) or is_extra
        self.enter(Phase.MAPPING if has_images and has_mosaic else Phase.REPORTING)

    def enter(self, phase: Phase) -> None:
        """Begin a phase, or the present one again."""
        super().enter(phase)
        self._time.stalled_s = 0.0
        if phase >= Phase.MAPPING:
            self._requests.forget()
