# SPDX-License-Identifier: Apache-2.0
"""Schedule of the annealing: first plan, temperatures and length of each cycle of each lane.

Some cycles anneal a constructed plan, each longer than the one before. All others anneal crosses
of the best plans from a lower temperature: a genetic search whose mutation is annealing. Their
manner is drawn by what each manner has brought so far, and they grow when nothing better is found.
A longer annealing of the construction comes when crosses have had their share of the work so far.
Nothing depends on the length of the search: a longer one begins with all that a shorter one does,
and is never worse.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rocsafe_planner.solver.model.tables import Floats, Ints
from rocsafe_planner.solver.search.choosing import AdaptiveChoices
from rocsafe_planner.solver.search.giant_tour import braid, cut, tour_of
from rocsafe_planner.solver.search.outcome import SearchOptions
from rocsafe_planner.solver.search.population import Lane, Manner, Pacer, Plan
from rocsafe_planner.solver.search.tuning import USUAL, CycleTuning

REHEAT, ROUTES, TOURS = range(3)
"""Kinds of later cycles: from the best plan, from a cross by routes, from one by tours."""
RUINS_OF = 4096
"""Proposals of which `Manner.ruins` are ruin and recreate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """Next annealing run of a lane."""

    plan: Plan
    manner: Manner
    proposals: int
    other: Plan | None = None
    """Plan to cross `plan` with; None: `plan` is annealed without a cross."""
    chosen: tuple[int, ...] = ()
    """Routes of `plan` that a cross keeps unchanged."""
    tour: Ints | None = None
    """Sequence of all customers that is split among the vehicles, instead of a cross."""
    drawn: dict[str, int] = field(default_factory=dict)
    """What was drawn for the manner."""

    def begin(self, lane: Lane) -> None:
        """Set the routes of a lane to the first plan of this cycle."""
        if self.tour is not None:
            lane.begin(cut(lane.tables, self.tour))
        elif self.other is None:
            lane.begin(self.plan)
        else:
            lane.cross(self.plan, self.other, list(self.chosen), self.manner)


class Schedule:
    """Cycles of the lanes, round by round, until proposals or time are used up.

    Parameters
    ----------
    options
        Length of the search.
    customers
        Number of customers.
    first
        Plan from which the first cycles start.
    away : (n, 2)
        Places of the customers relative to the common home of equal vehicles: plans are also
        crossed as tours. None: they are not.
    tuning
        Numbers of the schedule.
    """

    def __init__(
        self,
        options: SearchOptions,
        customers: int,
        first: Plan,
        away: Floats | None = None,
        tuning: CycleTuning = USUAL,
    ) -> None:
        self.options = options
        self.tuning = tuning
        self.first = first
        self.away = away
        self.customers = customers
        self.members: list[tuple[float, Plan]] = []
        self.best = np.inf
        self.made = 0
        self.rung = 0
        self.began = options.clock()
        self.draws = np.random.Generator(np.random.PCG64(options.seed))
        self.choices = AdaptiveChoices(
            {
                'kind': tuple(float(kind) for kind in (REHEAT, ROUTES, TOURS)),
                'ruins': tuning.ruins,
                'floor': tuning.floors,
                'hot': tuning.crossed_hots,
                'sharper': tuning.sharper,
                'width': tuning.widths,
                'long': tuning.longs,
            },
            tuning,
            self.draws,
        )
        self.work = float(tuning.crossed)
        self.idle_rounds = 0
        self.stagnations = 0
        self.is_restart = False

    def more(self) -> bool:
        """Return whether proposals or time are left for another round."""
        if self.options.proposals is not None:
            return self.made < self.options.proposals
        return self.is_in_time()

    def is_in_time(self) -> bool:
        """Return whether time is left, if the search has a time."""
        spent_s = self.options.clock() - self.began
        return self.options.proposals is not None or spent_s < self.options.budget_s

    def next_round(self) -> list[Cycle]:
        """Return one cycle for each lane."""
        lanes = range(self.options.lanes)
        if (work := self._next_rung()) is not None:
            self.rung += 1
            return [self._founder(work) for _ in lanes]
        if self.is_restart or len(self.members) < 2:
            self.is_restart = False
            return [self._founder(2.0 * self.work) for _ in lanes]
        return [self._crossed() for _ in lanes]

    def _next_rung(self) -> int | None:
        """Return the work of the next cycle of the ladder if it is its turn."""
        ladder = self.tuning.ladder
        if self.rung == len(ladder):
            return None
        work = ladder[self.rung]
        is_due = self.made >= self.tuning.crosses * work * self.customers
        return work if is_due or self.rung == 0 else None

    def _founder(self, work: float) -> Cycle:
        """Return a cycle that begins with the construction."""
        tuning, drawn = self.tuning, self.choices.draw()
        is_brief = work < tuning.brief
        for name in ('hot', 'ruins', 'kind'):
            del drawn[name]
        manner = self._manner(
            drawn, tuning.brief_hot if is_brief else tuning.first_hot, tuning.first_ruins
        )
        return Cycle(
            plan=self.first, manner=manner, proposals=self._proposals(work, manner), drawn=drawn
        )

    def _crossed(self) -> Cycle:
        """Return a cycle that begins with the best plan, or with a cross of two plans."""
        drawn = self.choices.draw()
        manner = self._manner(
            drawn, self.choices.value('hot', drawn), int(self.choices.value('ruins', drawn))
        )
        proposals = self._proposals(self.work, manner)
        if drawn['kind'] == REHEAT:
            best = self.members[0][1]
            return Cycle(plan=best, manner=manner, proposals=proposals, drawn=drawn)
        one, other = self._parents()
        if drawn['kind'] == TOURS and self.away is not None:
            tours = [tour_of(plan, self.away, self.draws) for plan in (one, other)]
            tour = braid(tours[0], tours[1], self.draws)
            return Cycle(plan=one, manner=manner, proposals=proposals, tour=tour, drawn=drawn)
        vehicles = len(one[1])
        count = int(self.draws.integers(1, max(2, vehicles)))
        chosen = self.draws.permutation(vehicles)[:count]
        return Cycle(
            plan=one,
            other=other,
            chosen=tuple(int(r) for r in chosen),
            manner=manner,
            proposals=proposals,
            drawn=drawn,
        )

    def _parents(self) -> tuple[Plan, Plan]:
        """Draw two different plans, the better ones more often."""
        size = len(self.members)
        ranks = [int(self.draws.integers(size, size=2).min()) for _ in range(2)]
        if ranks[0] == ranks[1]:
            ranks[1] = (ranks[0] + 1 + int(self.draws.integers(size - 1))) % size
        return self.members[ranks[0]][1], self.members[ranks[1]][1]

    def _manner(self, drawn: dict[str, int], hot: float, ruins: int) -> Manner:
        """Return the parameters of an annealing that starts at the temperature `hot`."""
        value = self.choices.value
        return Manner(
            hot=hot,
            cold=self.tuning.cold,
            floor=value('floor', drawn),
            width=value('width', drawn),
            sharper=value('sharper', drawn),
            ruins=ruins,
            long=int(value('long', drawn)),
        )

    def _proposals(self, work: float, manner: Manner) -> int:
        """Return how many proposals of a manner take so much work a customer."""
        return max(1, int(work * self.customers / self._effort(manner)))

    def _effort(self, manner: Manner) -> float:
        """Return the work of a mean proposal of a manner."""
        route = self.customers / len(self.first[1])
        ruin = self.tuning.ruin_cost + self.tuning.ruin_slot_cost * route
        return 1.0 + ruin * manner.ruins / RUINS_OF

    def pacer(self, cycle: Cycle, keep_on: Callable[[Lane], bool]) -> Pacer:
        """Return the pacer of a cycle of the current round."""
        left = cycle.proposals
        if self.options.proposals is not None:
            left = max(1, int((self.options.proposals - self.made) / self._effort(cycle.manner)))
        return Pacer(
            chunk=self.tuning.chunk,
            proposals=cycle.proposals,
            most=left,
            keep_on=lambda lane: keep_on(lane) and self.is_in_time(),
        )

    def finished(self, cycle: Cycle, value: float, plan: Plan) -> None:
        """Add the best plan of a cycle to the members, and score what was drawn for it."""
        tuning = self.tuning
        if not np.isfinite(value):
            return
        good = self.members[len(self.members) // 2][0] if self.members else np.inf
        score = tuning.good_score if value < good else tuning.poor_score
        if value < self.best * (1.0 - 1e-9):
            self.best, score, self.idle_rounds = value, tuning.best_score, -1
        self.choices.reward(cycle.drawn, score)
        if any(abs(value - v) <= 1e-9 * v for v, _ in self.members):
            return
        self.members.append((value, plan))
        self.members.sort(key=lambda member: member[0])
        del self.members[tuning.members :]

    def advance(self, cycles: list[Cycle]) -> None:
        """Count the work of a round, the same in each lane; grow if the search stagnates."""
        self.made += max(int(c.proposals * self._effort(c.manner)) + 1 for c in cycles)
        self.idle_rounds += 1
        if self.idle_rounds < self.tuning.patience:
            return
        self.idle_rounds = 0
        self.stagnations += 1
        self.work *= self.tuning.longer
        self.is_restart = self.stagnations % self.tuning.restarts == 0
