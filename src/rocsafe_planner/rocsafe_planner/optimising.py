# SPDX-License-Identifier: Apache-2.0
"""The method `solver`: routes that a search improves from the best of the simple methods on."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

from rocsafe_planner.boustrophedon import (
    boustrophedon_equal,
    boustrophedon_minmax,
    grid_rows,
    serpentine,
    strips,
)
from rocsafe_planner.fleet_problem import FleetProblem, Order
from rocsafe_planner.routing_task import PEAK_OBJECTIVES, routing_problem
from rocsafe_planner.sensor_repair import with_sensors
from rocsafe_planner.solver import Progress, SearchOptions, solve

Watch = Callable[[float, float], bool]
"""Told value and lower bound so far; False stops the search, which keeps its best routes."""

# Of a search without a time limit: proposals a point, and at most.
_PROPOSALS_A_POINT = 20_000
_MOST_PROPOSALS = 4_000_000
# Vehicles that are tried alone.
_MOST_ALONE = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Optimised:
    """Routes, and a value that no routes undercut, with the argument that proves it."""

    orders: list[Order]
    bound: float
    bound_name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """How hard to try.

    Attributes
    ----------
    objective
        What is to be small, see `request.OBJECTIVES`.
    budget_s
        Wall-clock time. 0: a number of proposals that only the number of points decides, so that
        the same problem has the same routes on every machine.
    proposals
        Without a budget: so many a lane instead of that number.
    seed
        Of all that is drawn.
    """

    objective: str = 'longest_time'
    budget_s: float = 0.0
    proposals: int = 0
    seed: int = 0


def optimised(
    problem: FleetProblem, effort: Effort, watch: Watch = lambda _value, _bound: True
) -> Optimised:
    """Return routes that are no worse than those of any survey tool's method."""
    reporter = _Reporter(watch)
    options = _options(len(problem.points), effort, reporter)
    starts = [method(problem) for method in (boustrophedon_minmax, boustrophedon_equal, strips)]
    if effort.objective not in PEAK_OBJECTIVES:
        starts += _alone(problem)
    solution = solve(
        routing_problem(problem, effort.objective),
        options,
        reporter.report,
        reporter.stop,
        [tuple(tuple(order) for order in orders) for orders in starts],
    )
    return Optimised(
        orders=[list(route) for route in solution.routes],
        bound=solution.bound.value,
        bound_name=solution.bound.name,
    )


def _alone(problem: FleetProblem) -> list[list[Order]]:
    """Return plans in which one vehicle does all it can: of a sum often the best."""
    tour = serpentine(grid_rows(problem))
    vehicles = range(min(len(problem.vehicles), _MOST_ALONE))
    every = range(len(problem.vehicles))
    return [with_sensors(problem, [tour if k == one else [] for k in every]) for one in vehicles]


def _options(points: int, effort: Effort, reporter: '_Reporter') -> SearchOptions:
    # The solver's seeds are of 63 bits, a request's of 64.
    seed = effort.seed % 2**63
    if effort.budget_s > 0.0:
        # Lanes look at the clock every few milliseconds: at the watch too.
        clock = reporter.watched(SearchOptions().clock)
        return SearchOptions(budget_s=effort.budget_s, seed=seed, clock=clock)
    proposals = effort.proposals or min(_PROPOSALS_A_POINT * points, _MOST_PROPOSALS)
    return SearchOptions(proposals=proposals, seed=seed, bound_share=0.0)


class _Reporter:
    """Passes on what the search has reached, and stops it when told to."""

    def __init__(self, watch: Watch) -> None:
        self.stop = threading.Event()
        self._watch = watch
        self._reached: tuple[float, float] | None = None

    def report(self, progress: Progress) -> None:
        """Take note of a better plan or bound."""
        self._reached = (progress.value, progress.bound.value)
        self._look()

    def watched(self, clock: Callable[[], float]) -> Callable[[], float]:
        """Return a clock that looks at the watch whenever it is read."""

        def read() -> float:
            self._look()
            return clock()

        return read

    def _look(self) -> None:
        if self._reached is not None and not self._watch(*self._reached):
            self.stop.set()
