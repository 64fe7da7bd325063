# SPDX-License-Identifier: Apache-2.0
"""One lane of the search: cycles of annealing with its own routes and random numbers."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rocsafe_planner.solver.model.randomness import acceptance_thresholds, seed_word
from rocsafe_planner.solver.model.tables import Ints, Tables, flown_costs
from rocsafe_planner.solver.search.anneal import Aim, Best, Dice, Heat, anneal
from rocsafe_planner.solver.search.crossover import complete, mix
from rocsafe_planner.solver.search.moves import Goal
from rocsafe_planner.solver.search.state import empty_state, load

Plan = tuple[Ints, Ints]
"""Customers route after route, and the length of each route."""

THRESHOLDS = acceptance_thresholds()
STEP = 256
"""Proposals between two changes of temperature (as in `anneal`)."""

STRICTNESS = 100.0
"""Penalty for each unit of consumption above a limit: dearer than what it saves the longest route,
or a search over small batteries settles on plans that no battery lasts for."""
SHARPENING_FROM = 0.5
"""Part of a cycle after which the width begins to shrink."""


def power_of_two(exponent: float) -> float:
    """Return 2**exponent by sums and products only, so that it is equal on all machines.

    Accurate to 2e-8; `math.pow` may differ in the last digit from machine to machine.
    """
    whole = int(np.floor(exponent))
    x = (exponent - whole) * 0.6931471805599453
    total = 1.0
    for k in range(9, 0, -1):
        total = 1.0 + total * x / k
    return float(np.ldexp(total, whole))


@dataclass(frozen=True, slots=True, kw_only=True)
class Manner:
    """Parameters of a cycle; temperatures in mean distances between near neighbours."""

    hot: float
    """Temperature at the start, as a power of two."""
    cold: float
    """Temperature at the end, as a power of two."""
    floor: float
    """Worth of a unit of cost in a short route, against 1 in the longest."""
    width: float
    """Share of the target cost over which the worth rises from `floor` to 1."""
    sharper: float
    """Power of two by which the width has shrunk in the end."""
    ruins: int
    """Of 4096 proposals, how many are ruin and recreate."""
    long: int
    """Of 16 segments, how many may be long."""


class Lane:
    """Routes under search, with random numbers of their own."""

    def __init__(self, tables: Tables, peak: float, seed: int, lane: int, far: float) -> None:
        self.tables = tables
        self.peak = peak
        self.share = 1e-7 if peak else 1.0
        self.far = far
        self.state = empty_state(tables)
        n, m = len(tables.needs), len(tables.first)
        self.best = Best(np.zeros(n, np.int32), np.zeros(m, np.int32), np.array([np.inf]))
        self.random = np.array([seed_word(seed, lane)], np.uint64)
        self.proposals = 0
        self.alike = alike_vehicles(tables)
        self.scale = typical_leg(tables)

    def begin(self, plan: Plan) -> None:
        """Continue from a plan, forgetting the best routes of the last cycle."""
        load(self.tables, self.state, plan[0], plan[1])
        self.best.value[0] = np.inf

    def worth(self) -> float:
        """Return the value of the present routes, as the best routes are ranked."""
        cost, load = self.state.cost, self.state.load
        breach = 0.0
        if self.tables.limited:
            breach = float(np.maximum(0.0, load - self.tables.limit * (1 + 1e-9)).sum())
        return float(self.peak * cost.max() + self.share * cost.sum()) + 1e4 * breach

    def plan(self) -> Plan:
        """Return the best routes since `begin`."""
        return self.best.order.copy(), self.best.lengths.copy()

    def goal(self, manner: Manner, progress: float) -> Goal:
        """Return the energy: routes above the mean weigh more, up to twice at `width`.

        In the end only the longest route counts. At high temperature that would hinder the search,
        since no customer could change routes: the width shrinks with the last temperatures only.
        """
        if self.peak == 0:
            return Goal(
                target=0.0,
                floor=1.0,
                steepness=0.0,
                curvature=0.0,
                vacancy=0.0,
                strictness=STRICTNESS,
            )
        late = max(0.0, (progress - SHARPENING_FROM) / (1 - SHARPENING_FROM))
        width = manner.width * power_of_two(-manner.sharper * late)
        target = max(float(self.state.cost.mean()), self.far)
        spare = len(self.tables.needs) < len(self.tables.first)
        vacancy = 4 * target if self.alike and not spare else 0.0
        return Goal(
            target=target,
            floor=manner.floor,
            steepness=0.0,
            curvature=(1 - manner.floor) / (2 * width * max(target, 1e-12)),
            vacancy=vacancy,
            strictness=STRICTNESS,
        )

    def cross(self, one: Plan, other: Plan, chosen: list[int], manner: Manner) -> None:
        """Continue from a mix of two plans, forgetting the best routes of the last cycle."""
        order, lengths, missing = mix(one, other, chosen, self.alike)
        goal = self.goal(manner, 0.0)
        complete(self.tables, self.state, goal, order, lengths, missing, self.random)
        self.best.value[0] = np.inf

    def anneal(self, manner: Manner, progress: float, proposals: int, rate: float) -> None:
        """Make some proposals; each adds `rate` to the `progress` of the cycle."""
        exponent = manner.hot + (manner.cold - manner.hot) * progress
        ratio = power_of_two((manner.cold - manner.hot) * rate * STEP)
        heat = Heat(
            temperature=self.scale * power_of_two(exponent),
            ratio=ratio,
            proposals=proposals,
            ruins=manner.ruins,
            long=manner.long,
        )
        # The colder, the narrower: a cycle that begins cold goes on where a longer one would be.
        coolness = max(0.0, exponent / manner.cold)
        aim = Aim(self.goal(manner, coolness), self.peak, self.share)
        anneal(self.tables, self.state, aim, self.best, Dice(self.random, THRESHOLDS), heat)
        self.proposals += proposals

    def cycle(self, manner: Manner, pacer: 'Pacer') -> None:
        """Anneal until the end of the cycle, or of the search."""
        while pacer.next_chunk() > 0:
            self.anneal(manner, pacer.progress, pacer.next_chunk(), 1.0 / pacer.proposals)
            if not pacer.advance(self):
                return


class Pacer:
    """Progress of a cycle by proposals.

    Parameters
    ----------
    chunk
        Proposals between two questions whether to go on.
    proposals
        Of the whole cycle, from hot to cold.
    most
        Proposals after which the search ends, even within a cycle.
    keep_on
        Answers whether to go on.
    """

    def __init__(
        self, chunk: int, proposals: int, most: int, keep_on: Callable[[Lane], bool]
    ) -> None:
        self.chunk, self.proposals = chunk, proposals
        self._end = min(proposals, most)
        self._keep_on = keep_on
        self._made = 0

    @property
    def progress(self) -> float:
        """Part of the cycle that is over."""
        return self._made / self.proposals

    def next_chunk(self) -> int:
        """Return the number of proposals until the next question; 0 at the end."""
        return min(self.chunk, self._end - self._made)

    def advance(self, lane: Lane) -> bool:
        """Count a chunk; return whether to continue."""
        self._made += self.next_chunk()
        return self._keep_on(lane)


def typical_leg(tables: Tables) -> float:
    """Return the mean cost of a leg from a customer to its nearest places, without stays."""
    n, near = tables.near.shape
    some = np.arange(0, n, max(1, n // 500))
    flown = flown_costs(tables, some[:, None], tables.near[some, : min(near, 3)])
    if not (flown > 0).any():
        flown = flown_costs(tables, tables.first[:1], np.arange(n))
    return max(float(flown[flown > 0].mean()) if (flown > 0).any() else 1.0, 1e-9)


def alike_vehicles(tables: Tables) -> bool:
    """Return whether each vehicle could fly each other's route at the same cost."""
    return all(
        bool((column == column[0]).all())
        for column in (
            tables.first,
            tables.last,
            tables.measure,
            tables.limit_measure,
            tables.fixed,
            tables.idle,
            tables.limit,
            tables.ability,
        )
    )
