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

CHUNK = 16384
"""Proposals between two looks at the clock."""
LEAST_CYCLE, MIDDLE_CYCLE = 5_000, 20_000
"""Proposals a customer of a cycle from hot to cold: least and most."""
LARGE_LEAST_CYCLE, MOST_CYCLE = 30_000, 120_000
"""The same of large problems."""
MANY_CYCLES, FEW_CYCLES = 12, 4
"""Into how many a search is divided where it is long enough: small problems gain by crosses, large
ones by cooling slowly."""
LARGE, LONG = 500, 100
"""Customers in all, and of each vehicle, from which on a problem is large: nearly that of one
traveller, whose way is found by many cheap moves."""
SHORT_CYCLE, LONGER_CYCLE = 2_500, 25
"""Most of a small problem, and how many more for each customer: few customers settle soon, and
crosses then find more than longer cycles would."""
FOUNDERS = 4
"""Cycles from a construction before plans are crossed."""
MEMBERS = 10
"""Plans that are kept for crossing."""
TOURS = 0.5
"""How often they are crossed as tours instead of route by route."""
SMALL_RUINS = (600, 1500)
"""Of 4096 proposals, how many are ruin and recreate in cycles where there is a table of legs."""
LARGE_RUINS = (40, 120)
"""How many where there are many customers besides: ten times the proposals do more."""
HASTY_RUINS, HASTE = 200, 5000
"""How many where there are fewer than so many proposals a customer in all."""
PATIENCE = 100_000
"""Proposals a customer in all from which on cycles become sharper."""
FLOORS, PATIENT_FLOORS = (0.1, 0.2), (0.01, 0.03, 0.1)
"""Worths of short routes. The less they are worth, the nearer comes the longest route to the
least, and the longer the others stay hot."""
SHARPER, PATIENT_SHARPER = (3.0,), (3.0, 4.0)
"""Power of two by which the width of a cycle shrinks."""
RATES = (6e6, 2.5e6)
"""Proposals a second that are counted on before any were made: with a table of legs, without."""


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
    """

    def __init__(
        self, options: SearchOptions, customers: int, first: Plan, away: Floats | None = None
    ) -> None:
        self.options = options
        self.first = first
        self.away = away
        self.members: list[tuple[float, Plan]] = []
        self.customers = customers
        self.done = 0
        self.made = 0
        self.began = options.clock()
        self.choices = np.random.Generator(np.random.PCG64(options.seed))
        self.usual_rate = RATES[customers > DENSE_SITES]
        total = options.proposals or options.budget_s * self.usual_rate
        share = total / customers
        self.is_large = customers >= max(LARGE, LONG * len(first[1]))
        least = LARGE_LEAST_CYCLE if self.is_large else LEAST_CYCLE
        self.is_single = share < 4 * least
        self.hot_start = share > 2000
        self.has_time = share > HASTE
        is_patient = share > PATIENCE
        self.floors = PATIENT_FLOORS if is_patient else FLOORS
        self.sharper = PATIENT_SHARPER if is_patient else SHARPER
        most = (
            MOST_CYCLE
            if self.is_large
            else min(MIDDLE_CYCLE, SHORT_CYCLE + LONGER_CYCLE * customers)
        )
        cycles = FEW_CYCLES if self.is_large else MANY_CYCLES
        cycle = min(max(share / cycles, least), most)
        self.full = total if self.is_single else customers * cycle

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
        crosses = self.done >= FOUNDERS and len(self.members) >= 2
        wanted = self.full / 2 if crosses else self.full
        left = self._left()
        proposals = left if left < 1.5 * wanted else wanted
        return [self._cycle(int(proposals), crosses) for _ in range(self.options.lanes)]

    def _cycle(self, proposals: int, crosses: bool) -> Cycle:
        """Return one cycle."""
        self.done += 1
        hot = 0.0 if self.hot_start else -2.0
        if not crosses:
            return Cycle(plan=self.first, manner=self._manner(hot), proposals=proposals)
        one, other = self._parents()
        manner = self._manner(float(self.choices.choice([-1.0, -2.0, -3.0])))
        if self.away is not None and self.choices.random() < TOURS:
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
        return Manner(
            hot=hot,
            cold=-5.5,
            floor=float(self.choices.choice(self.floors)),
            width=float(self.choices.choice([0.01, 0.02])),
            sharper=float(self.choices.choice(self.sharper)),
            ruins=self._ruins(),
            long=int(self.choices.choice([0, 3])),
        )

    def _ruins(self) -> int:
        """Return how many of 4096 proposals are to be ruin and recreate.

        One takes the time of some thirty others. They lead out of the traps of small and
        clustered problems; large ones need the others first.
        """
        if self.customers > DENSE_SITES:
            return 10 if self.is_single else 40
        if self.is_large:
            return int(self.choices.choice(LARGE_RUINS))
        return int(self.choices.choice(SMALL_RUINS)) if self.has_time else HASTY_RUINS

    def pacer(self, cycle: Cycle, keep_on: Callable[[Lane], bool]) -> Pacer:
        """Return the pacer of a cycle of the present round."""
        counted = self.options.proposals is not None
        return Pacer(
            chunk=min(CHUNK, cycle.proposals),
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
        del self.members[MEMBERS:]

    def advance(self, proposals: int) -> None:
        """Take note of how many proposals each lane has made so far."""
        self.made = proposals
