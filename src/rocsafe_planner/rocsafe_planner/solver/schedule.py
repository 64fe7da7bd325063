# SPDX-License-Identifier: Apache-2.0
"""What each cycle of each lane starts from, and how hot and how long it anneals."""

from collections.abc import Callable

import numpy as np

from rocsafe_planner.solver.outcome import SearchOptions
from rocsafe_planner.solver.search import Lane, Manner, Pacer, Plan

CHUNK = 16384
"""Proposals between two looks at the clock."""
PER_CUSTOMER = 20_000
"""Proposals a customer that make a full cycle of annealing."""
USUAL_RATE = 5e6
"""Proposals a second that are counted on when cycles are planned."""


class Schedule:
    """Hands out cycles until proposals or time are spent."""

    def __init__(self, options: SearchOptions, customers: int, first: Plan) -> None:
        self.options = options
        self.first = first
        self.best: tuple[float, Plan] = (np.inf, first)
        total = options.proposals or options.budget_s * USUAL_RATE
        self.cycles = max(1, round(total / (PER_CUSTOMER * customers)))
        self.per_customer = total / self.cycles / customers
        self.done = 0
        self.began = options.clock()
        self.choices = np.random.Generator(np.random.PCG64(options.seed))

    def more(self) -> bool:
        """Answer whether another round is due."""
        if self.options.proposals is not None:
            return self.done < self.cycles * self.options.lanes
        return self._left_s() > 0.01 * self.options.budget_s

    def _left_s(self) -> float:
        """Return how much of the budget is left."""
        return self.options.budget_s - (self.options.clock() - self.began)

    def next_cycle(self) -> tuple[Plan, Manner]:
        """Return where the next cycle starts and how it anneals."""
        again = self.done >= self.options.lanes and bool(self.choices.integers(2))
        plan = self.best[1] if again else self.first
        hot = 0.0 if self.per_customer > 2000 else -2.0
        manner = Manner(
            hot=hot - (1.7 if again else 0.0),
            cold=-5.5,
            floor=float(self.choices.choice([0.1, 0.2, 0.4])),
            width=float(self.choices.choice([0.01, 0.02, 0.05])),
            ruins=0,
            long=0,
        )
        self.done += 1
        return plan, manner

    def pacer(self, keep_on: Callable[[Lane], bool]) -> Pacer:
        """Return the pacer of a cycle of the present round."""
        lanes = self.options.lanes
        rounds_left = max(1, self.cycles - (self.done - 1) // lanes)
        proposals = self.options.proposals
        return Pacer(
            chunk=CHUNK,
            proposals=None if proposals is None else max(CHUNK, proposals // self.cycles),
            clock=self.options.clock,
            duration_s=max(self._left_s(), 1e-3) / rounds_left,
            keep_on=keep_on,
        )

    def finished(self, value: float, plan: Plan) -> None:
        """Take note of the best plan of a cycle."""
        if value < self.best[0]:
            self.best = (value, plan)
