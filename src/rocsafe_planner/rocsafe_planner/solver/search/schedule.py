# SPDX-License-Identifier: Apache-2.0
"""What each cycle of each lane starts from, and how hot and how long it anneals.

First a few cycles from a construction, from hot to cold; then, if there is time, crosses of the
best plans, annealed from warm to cold: a genetic search whose mutation is annealing. Small
problems live on the crosses, large ones on one long cycle.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rocsafe_planner.solver.model.flatten import DENSE_SITES
from rocsafe_planner.solver.model.tables import Floats, Ints
from rocsafe_planner.solver.search.giant_tour import braid, cut, tour_of
from rocsafe_planner.solver.search.outcome import SearchOptions
from rocsafe_planner.solver.search.population import Lane, Manner, Pacer, Plan
from rocsafe_planner.solver.search.tuning import USUAL, CycleTuning


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """What a lane is to do next."""

    plan: Plan
    manner: Manner
    proposals: int
    other: Plan | None = None
    """Plan to cross with; none: annealed as it is."""
    chosen: tuple[int, ...] = ()
    """Routes of `plan` that a cross keeps whole."""
    tour: Ints | None = None
    """All customers in an order that is to be cut among the vehicles."""

    def begin(self, lane: Lane) -> None:
        """Set the routes of a lane to what this cycle starts from."""
        if self.tour is not None:
            lane.begin(cut(lane.tables, self.tour))
        elif self.other is None:
            lane.begin(self.plan)
        else:
            lane.cross(self.plan, self.other, list(self.chosen), self.manner)


class Schedule:
    """Hands out cycles until proposals or time are spent.

    Parameters
    ----------
    options
        How long to search.
    customers
        How many there are.
    first
        What cycles from hot to cold begin with.
    away
        (n, 2) where customers are, seen from the home of all vehicles, if these are alike: then
        plans are also crossed as tours.
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
        self.members: list[tuple[float, Plan]] = []
        self.customers = customers
        self.done = 0
        self.made = 0
        self.began = options.clock()
        self.choices = np.random.Generator(np.random.PCG64(options.seed))
        self.usual_rate = tuning.sparse_rate if customers > DENSE_SITES else tuning.rate
        total = options.proposals or options.budget_s * self.usual_rate
        self.share = total / customers
        self.is_large = customers >= max(
            tuning.large_customers, tuning.large_route * len(first[1])
        )
        least = tuning.large_least_cycle if self.is_large else tuning.least_cycle
        self.is_single = self.share < tuning.single_cycles * least
        cycles = tuning.large_cycles if self.is_large else tuning.cycles
        cycle = min(max(self.share / cycles, least), self._most_cycle())
        self.full = total if self.is_single else customers * cycle

    def _most_cycle(self) -> int:
        """Return the most proposals a customer of a cycle."""
        tuning = self.tuning
        if self.is_large:
            return tuning.large_most_cycle
        longest = tuning.short_cycle + tuning.longer_cycle * self.customers
        return min(tuning.middle_cycle, longest)

    def more(self) -> bool:
        """Answer whether another round is due."""
        if self.options.proposals is not None:
            return self.made < self.options.proposals
        return self._left_s() > 0.01 * self.options.budget_s

    def _left_s(self) -> float:
        """Return how much of the budget is left."""
        return self.options.budget_s - (self.options.clock() - self.began)

    def _left(self) -> float:
        """Return how many proposals a lane can still make."""
        if self.options.proposals is not None:
            return self.options.proposals - self.made
        return self._left_s() * self._rate()

    def _rate(self) -> float:
        """Return proposals a second and lane."""
        elapsed = self.options.clock() - self.began
        return self.made / elapsed if self.made and elapsed > 0 else self.usual_rate

    def next_round(self) -> list[Cycle]:
        """Return a cycle for each lane, equally long."""
        crosses = self.done >= self.tuning.founders and len(self.members) >= 2
        wanted = self.full / 2 if crosses else self.full
        left = self._left()
        proposals = left if left < 1.5 * wanted else wanted
        return [self._cycle(int(proposals), crosses) for _ in range(self.options.lanes)]

    def _cycle(self, proposals: int, crosses: bool) -> Cycle:
        """Return one cycle."""
        self.done += 1
        tuning = self.tuning
        hot = tuning.first_hot if self.share > tuning.hot_share else tuning.later_hot
        if not crosses:
            return Cycle(plan=self.first, manner=self._manner(hot), proposals=proposals)
        one, other = self._parents()
        manner = self._manner(float(self.choices.choice(tuning.crossed_hots)))
        if self.away is not None and self.choices.random() < tuning.tours:
            tours = [tour_of(plan, self.away, self.choices) for plan in (one, other)]
            tour = braid(tours[0], tours[1], self.choices)
            return Cycle(plan=one, manner=manner, proposals=proposals, tour=tour)
        vehicles = len(one[1])
        count = int(self.choices.integers(1, max(2, vehicles)))
        chosen = self.choices.permutation(vehicles)[:count]
        return Cycle(
            plan=one,
            other=other,
            chosen=tuple(int(r) for r in chosen),
            manner=manner,
            proposals=proposals,
        )

    def _parents(self) -> tuple[Plan, Plan]:
        """Draw two different plans, the better ones more often."""
        size = len(self.members)
        ranks = [int(self.choices.integers(size, size=2).min()) for _ in range(2)]
        if ranks[0] == ranks[1]:
            ranks[1] = (ranks[0] + 1 + int(self.choices.integers(size - 1))) % size
        return self.members[ranks[0]][1], self.members[ranks[1]][1]

    def _manner(self, hot: float) -> Manner:
        """Return how to anneal from a temperature on."""
        tuning = self.tuning
        is_long = self.share > tuning.long_share
        return Manner(
            hot=hot,
            cold=tuning.cold,
            floor=float(self.choices.choice(tuning.long_floors if is_long else tuning.floors)),
            width=float(self.choices.choice(tuning.widths)),
            sharper=float(self.choices.choice(tuning.long_sharper if is_long else tuning.sharper)),
            ruins=self._ruins(),
            long=int(self.choices.choice(tuning.longs)),
        )

    def _ruins(self) -> int:
        """Return how many of 4096 proposals are ruin and recreate.

        They lead out of the local optima of small and clustered problems; large ones need the
        other moves first.
        """
        tuning = self.tuning
        if self.customers > DENSE_SITES:
            return tuning.sparse_single_ruins if self.is_single else tuning.sparse_ruins
        if self.is_large:
            return int(self.choices.choice(tuning.large_ruins))
        if self.share > tuning.hasty_share:
            return int(self.choices.choice(tuning.ruins))
        return tuning.hasty_ruins

    def pacer(self, cycle: Cycle, keep_on: Callable[[Lane], bool]) -> Pacer:
        """Return the pacer of a cycle of the present round."""
        counted = self.options.proposals is not None
        return Pacer(
            chunk=min(self.tuning.chunk, cycle.proposals),
            proposals=cycle.proposals if counted else None,
            clock=self.options.clock,
            duration_s=max(min(cycle.proposals / self._rate(), self._left_s()), 1e-3),
            keep_on=keep_on,
        )

    def finished(self, value: float, plan: Plan) -> None:
        """Take note of the best plan of a cycle."""
        if not np.isfinite(value) or any(abs(value - v) <= 1e-9 * v for v, _ in self.members):
            return
        self.members.append((value, plan))
        self.members.sort(key=lambda member: member[0])
        del self.members[self.tuning.members :]

    def advance(self, proposals: int) -> None:
        """Take note of how many proposals each lane has made so far."""
        self.made = proposals
