# SPDX-License-Identifier: Apache-2.0
"""The solver: rounds of annealing in parallel lanes, with a proven bound beside them."""

import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from rocsafe_planner.solver.bounds.certificate import Bound, improving_bounds
from rocsafe_planner.solver.bounds.relaxation import relax
from rocsafe_planner.solver.model.compiled import IS_COMPILED
from rocsafe_planner.solver.model.flatten import tables_of
from rocsafe_planner.solver.model.problem import Routes, RoutingProblem, route_cost, route_load
from rocsafe_planner.solver.model.tables import Floats
from rocsafe_planner.solver.plain import improve, recut
from rocsafe_planner.solver.search.outcome import Progress, SearchOptions, Solution
from rocsafe_planner.solver.search.population import Lane, Plan
from rocsafe_planner.solver.search.schedule import Schedule
from rocsafe_planner.solver.search.starts import first_plans, sector_plan, seen_from_home

POLL_S = 0.02
UNKNOWN = Bound(value=0.0, name='none')
PLAIN_ROUNDS = 4
CHEAP_BOUNDS = 3
"""Number of bounds that need no compiled loops."""
SECTORS_UP_TO = 1.1
"""A plan by sectors is used up to this multiple of the value of the best first plan."""
SURE_BOUNDS = 12
"""Bounds computed after a search by number of proposals, so that the bound is reproducible."""

Report = Callable[[Progress], None]


@dataclass(slots=True, kw_only=True)
class Incumbent:
    """The best plan of all lanes; behind a lock, because lanes offer plans from their threads."""

    plan: Plan = field(default_factory=lambda: plan_of(()))
    value: float = np.inf
    lock: threading.Lock = field(default_factory=threading.Lock)

    def offer(self, value: float, plan: Plan) -> None:
        """Keep a plan if it is better than the best so far."""
        with self.lock:
            if value < self.value:
                self.value, self.plan = value, plan


class _Search:
    """One run of the solver."""

    def __init__(
        self,
        problem: RoutingProblem,
        options: SearchOptions,
        report: Report | None,
        stop: threading.Event,
    ) -> None:
        self.problem = problem
        self.options = options
        self.report = report
        self.stop = stop
        self.began = options.clock()
        self.tables = tables_of(problem)
        self.bound = UNKNOWN
        self.reported = (np.inf, -np.inf)
        self.bounds: Iterator[Bound] = iter(())
        self.bound_spent_s = 0.0

    def run(self, starts: tuple[Routes, ...]) -> Solution:
        """Search until the budget is used up, the gap is closed or a stop is requested."""
        options = self.options
        peak = 1.0 if self.problem.objective == 'max' else 0.0
        far = float(relax_far(self.problem)) if peak else 0.0
        lanes = [Lane(self.tables, peak, options.seed, k, far) for k in range(options.lanes)]
        self._begin(lanes[0], starts)
        if options.bound_share > 0:
            self.bounds = improving_bounds(self.problem, self.incumbent.value)
        away = seen_from_home(self.problem) if peak and lanes[0].alike else None
        first = self._construction(lanes[0], away)
        schedule = Schedule(options, self.problem.customers, first, away)
        if IS_COMPILED:
            with ThreadPoolExecutor(max_workers=options.threads) as pool:
                while schedule.more() and not self.stop.is_set() and not self._closed():
                    self._round(pool, lanes, schedule)
        else:
            self._improve_plainly(lanes[0])
        if options.proposals is not None and IS_COMPILED:
            self._bound_surely()
        routes = routes_of(self.incumbent.plan)
        made = sum(lane.proposals for lane in lanes)
        return solution(self.problem, routes, self.bound, self.options.clock() - self.began, made)

    def _bound_surely(self) -> None:
        """Compute a fixed number of bounds, unless a stop is requested."""
        for _ in range(SURE_BOUNDS):
            if self.stop.is_set() or next(self._next_bounds(), None) is None:
                return
            self._tell()

    def _begin(self, lane: Lane, starts: tuple[Routes, ...]) -> None:
        """Take the best of the constructed plans and those given."""
        given = (plan_of(routes) for routes in starts)
        incumbent = Incumbent()
        for plan in chain(first_plans(self.problem, self.tables), given):
            lane.begin(plan)
            incumbent.offer(lane.worth(), plan)
            self.incumbent = incumbent
            self._tell()

    def _construction(self, lane: Lane, away: Floats | None) -> Plan:
        """Return what cycles begin with: sectors, unless the best plan is far shorter."""
        vehicles = len(self.problem.vehicles)
        if away is None or not 1 < vehicles <= len(away) // 4:
            return self.incumbent.plan
        plan = sector_plan(away, vehicles)
        lane.begin(plan)
        value = lane.worth()
        self.incumbent.offer(value, plan)
        return plan if value <= SECTORS_UP_TO * self.incumbent.value else self.incumbent.plan

    def _improve_plainly(self, lane: Lane) -> None:
        """Do what can be done without compiled loops."""
        for _ in range(PLAIN_ROUNDS):
            before = self.incumbent.value
            plan = improve(self.problem, self.tables, self.incumbent.plan)
            for candidate in (plan, recut(self.problem, self.tables, plan)):
                lane.begin(candidate)
                self.incumbent.offer(lane.worth(), candidate)
            if self.incumbent.value >= before or self.stop.is_set():
                break
        if self.options.bound_share > 0:
            for _ in zip(range(CHEAP_BOUNDS), self._next_bounds(), strict=False):
                self._tell()

    def _round(self, pool: ThreadPoolExecutor, lanes: list[Lane], schedule: Schedule) -> None:
        """Let every lane do one cycle; look after bound and reports meanwhile."""
        running: list[Future[None]] = []
        cycles = schedule.next_round()
        for lane, cycle in zip(lanes, cycles, strict=True):
            cycle.begin(lane)
            pacer = schedule.pacer(cycle, self._keep_on)
            running.append(pool.submit(lane.cycle, cycle.manner, pacer))
        while wait(running, timeout=POLL_S, return_when=FIRST_EXCEPTION).not_done:
            self._watch()
        for lane, cycle, future in zip(lanes, cycles, running, strict=True):
            future.result()
            self._publish(lane)
            schedule.finished(cycle, float(lane.best.value[0]), lane.plan())
        schedule.advance(cycles)
        self._tell()

    def _keep_on(self, lane: Lane) -> bool:
        """Publish what a lane has found; answer whether it should go on.

        A search that counts proposals publishes between rounds only: which of two equally good
        plans came first is then the same on every machine.
        """
        if self.options.proposals is None:
            self._publish(lane)
        return not self.stop.is_set()

    def _publish(self, lane: Lane) -> None:
        """Offer the best plan of a lane to all."""
        value = float(lane.best.value[0])
        if value < self.incumbent.value:
            self.incumbent.offer(value, lane.plan())

    def _watch(self) -> None:
        """Report, improve the bound within its share of the time, stop when the gap is closed."""
        self._tell()
        if self.options.proposals is not None:
            return
        elapsed = self.options.clock() - self.began
        if self.bound_spent_s < self.options.bound_share * elapsed:
            next(self._next_bounds(), None)
        if self._closed():
            self.stop.set()

    def _next_bounds(self) -> Iterator[Bound]:
        """Yield bounds, timing them and keeping the best."""
        while True:
            began = self.options.clock()
            bound = next(self.bounds, None)
            self.bound_spent_s += self.options.clock() - began
            if bound is None:
                return
            if bound.value > self.bound.value:
                self.bound = bound
            yield bound

    def _closed(self) -> bool:
        """Answer whether the plan is proven close enough to the optimum."""
        value = self.incumbent.value
        return value <= self.bound.value * (1 + self.options.close_enough + 1e-6)

    def _tell(self) -> None:
        """Report if plan or bound have improved."""
        now = (self.incumbent.value, self.bound.value)
        if self.report is None or now == self.reported:
            return
        self.reported = now
        elapsed = self.options.clock() - self.began
        self.report(Progress(value=now[0], bound=self.bound, elapsed_s=elapsed))


def relax_far(problem: RoutingProblem) -> float:
    """Return the cost of the dearest customer's own route."""
    crew = tuple(range(len(problem.vehicles)))
    return float(relax(problem, crew).around.max(initial=0.0))


def plan_of(routes: Routes) -> Plan:
    """Return routes as flat arrays."""
    flat = [customer for route in routes for customer in route]
    return np.array(flat, np.int32), np.array([len(route) for route in routes], np.int32)


def routes_of(plan: Plan) -> Routes:
    """Return flat arrays as routes."""
    ends = np.cumsum(plan[1])
    parts = np.split(plan[0], ends[:-1])
    return tuple(tuple(int(customer) for customer in part) for part in parts)


def solution(
    problem: RoutingProblem, routes: Routes, bound: Bound, elapsed_s: float, proposals: int
) -> Solution:
    """Return routes with their costs, recomputed from the problem."""
    costs = tuple(route_cost(problem, v, route) for v, route in enumerate(routes))
    loads = tuple(route_load(problem, v, route) for v, route in enumerate(routes))
    limits = [vehicle.limit for vehicle in problem.vehicles]
    return Solution(
        routes=routes,
        costs=costs,
        loads=loads,
        value=max(costs) if problem.objective == 'max' else sum(costs),
        feasible=all(x <= cap * (1 + 1e-6) for x, cap in zip(loads, limits, strict=True)),
        bound=bound,
        elapsed_s=elapsed_s,
        proposals=proposals,
    )


def solve(
    problem: RoutingProblem,
    options: SearchOptions | None = None,
    report: Report | None = None,
    stop: threading.Event | None = None,
    starts: Iterable[Routes] = (),
) -> Solution:
    """Return the best routes found within a budget.

    Parameters
    ----------
    problem
        What is to be routed.
    options
        Budget, seed, lanes.
    report
        Called with each better plan or bound, from this thread.
    stop
        Ends the search when set; the best plan so far is returned.
    starts
        Plans that the result must not be worse than.
    """
    options = options or SearchOptions()
    if problem.customers == 0:
        bound = next(improving_bounds(problem, 0.0))
        return solution(problem, ((),) * len(problem.vehicles), bound, 0.0, 0)
    return _Search(problem, options, report, stop or threading.Event()).run(tuple(starts))
