# SPDX-License-Identifier: Apache-2.0
"""The method `solver`: routes that a search improves from the best of the simple methods on."""

import math
import threading
from collections.abc import Callable, Sequence

from rocsafe_planner.plan.survey_options import PEAK_OBJECTIVES, Effort
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing.costs import Optimised, objective_value
from rocsafe_planner.routing.solver_problem import routing_problem
from rocsafe_planner.routing.tours.boustrophedon import (
    boustrophedon_equal,
    boustrophedon_minmax,
    grid_rows,
    serpentine,
    strips,
)
from rocsafe_planner.routing.tours.sensor_repair import with_sensors
from rocsafe_planner.solver import Bound, Progress, SearchOptions, solve

Watch = Callable[[float, float], bool]
"""Told value and lower bound so far; False stops the search, which keeps its best routes."""

# Of a search without a time limit: proposals a point, and at most.
_PROPOSALS_A_POINT = 60_000
_MOST_PROPOSALS = 24_000_000
# How often it is asked whether to go on.
_ASK_S = 0.05
# Vehicles that are tried alone.
_MOST_ALONE = 10


def optimised(
    problem: FleetProblem,
    effort: Effort,
    watch: Watch = lambda _value, _bound: True,
    known: Sequence[list[Order]] = (),
) -> Optimised:
    """Return routes that are no worse than those of any survey tool's method.

    They are no worse than those `known`, of which the first may be `boustrophedon_minmax`'s. The
    search knows corners that are flown round, and batteries that are changed, by estimates
    only: in the end all are compared as they are flown.
    """
    options = search_options(len(problem.points), effort)
    watcher = _Watcher(watch, options.clock)
    starts = [*known] or [boustrophedon_minmax(problem)]
    value = objective_value(problem, starts[0], effort.objective)
    if math.isfinite(value):  # tables of legs may take seconds: there is a plan already
        none = Bound(value=0.0, name='none')
        watcher.report(Progress(value=value, bound=none, elapsed_s=0.0))
    starts += [boustrophedon_equal(problem), strips(problem)]
    if effort.objective not in PEAK_OBJECTIVES:
        starts += _alone(problem)
    solution = solve(
        routing_problem(problem, effort.objective),
        options,
        watcher.report,
        watcher,
        [tuple(tuple(order) for order in orders) for orders in starts],
    )
    candidates = [[list(route) for route in solution.routes], *starts]
    return Optimised(
        orders=min(candidates, key=lambda one: objective_value(problem, one, effort.objective)),
        bound=solution.bound.value if _is_proof(problem, effort.objective) else math.nan,
        bound_name=solution.bound.name,
    )


def _alone(problem: FleetProblem) -> list[list[Order]]:
    """Return plans in which one vehicle does all it can: of a sum often the best."""
    tour = serpentine(grid_rows(problem))
    vehicles = range(min(len(problem.vehicles), _MOST_ALONE))
    every = range(len(problem.vehicles))
    return [with_sensors(problem, [tour if k == one else [] for k in every]) for one in vehicles]


def search_options(points: int, effort: Effort) -> SearchOptions:
    """Return how the solver is to search so many points."""
    # The solver's seeds are of 63 bits, a request's of 64.
    seed = effort.seed % 2**63
    if effort.budget_s > 0.0:
        return SearchOptions(budget_s=effort.budget_s, seed=seed)
    proposals = effort.proposals or min(_PROPOSALS_A_POINT * points, _MOST_PROPOSALS)
    return SearchOptions(proposals=proposals, seed=seed)


class _Watcher(threading.Event):
    """Passes on what the search has reached; is set when that is answered with False.

    The search asks it every few milliseconds whether to stop, from several threads.
    """

    def __init__(self, watch: Watch, clock: Callable[[], float]) -> None:
        super().__init__()
        self._watch, self._clock = watch, clock
        self._reached: tuple[float, float] | None = None
        self._asking = threading.Lock()
        self._next_s = 0.0

    def report(self, progress: Progress) -> None:
        """Take note of a better plan or bound."""
        with self._asking:
            self._reached = (progress.value, progress.bound.value)
            self._ask()

    def is_set(self) -> bool:
        """Return whether to stop, having asked if that was some time ago."""
        if self._clock() >= self._next_s and self._asking.acquire(blocking=False):
            try:
                self._ask()
            finally:
                self._asking.release()
        return super().is_set()

    def _ask(self) -> None:
        self._next_s = self._clock() + _ASK_S
        if self._reached is not None and not self._watch(*self._reached):
            self.set()


def _is_proof(problem: FleetProblem, objective: str) -> bool:
    """Return whether a bound for the legs' costs is one for the flights.

    Legs that share the corners between them cost the solver an estimate.
    """
    is_estimate = any(vehicle.hover_s == 0.0 for vehicle in problem.vehicles)
    return not is_estimate or objective.endswith('distance')
