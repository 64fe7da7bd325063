# SPDX-License-Identifier: Apache-2.0
"""A bound from prices: what the vehicles cannot collect within a time, no plan can serve by then.

Each customer is given a price. If all vehicles together, whatever walks they fly, cannot collect
the sum of all prices within a time, no plan is done by that time. What one vehicle can collect is
found by dynamic programming over steps of time, to which legs are rounded down. The prices are
those of the linear program that shares all customers among the walks found so far (column
generation), drawn towards the best prices so far, which keeps them from jumping (Pessoa, Sadykov,
Uchoa & Vanderbeck 2018, doi:10.1287/ijoc.2017.0784).

Vehicles that wait for each other have less time for their walks, see `waiting`.

Where a vehicle changes its battery its walks are flights, each as long as a battery lasts at most,
one after another with the changes between them: what it can collect by some time is found by a
second dynamic program, over its flights.
"""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_planner.solver.bounds.collected import Collected, Table
from rocsafe_planner.solver.bounds.stepped_flights import (
    ROUNDING,
    BatteryChanges,
    Walks,
    walks_of,
)
from rocsafe_planner.solver.bounds.waiting import Crew
from rocsafe_planner.solver.model.problem import RoutingProblem
from rocsafe_planner.solver.model.tables import Floats, Ints


@dataclass(frozen=True, slots=True, kw_only=True)
class PriceOptions:
    """How prices are sought.

    Attributes
    ----------
    work
        Most additions of the dynamic programs with steps of one length; a count, so that the bound
        is reproducible.
    finest
        Steps of a short leg at most: first coarse steps, then finer ones.
    rounds
        Steps are longer where the work would not allow for so many rounds.
    walks
        Walks of a vehicle that are taken from each round.
    kept
        Walks in the linear program, times the number of customers.
    pull
        Share of the best prices in the next ones.
    let_go
        Rounds without a better bound after which that share is 0.
    stalled
        Rounds without a better bound after which the next steps are used.
    """

    work: float = 6e8
    finest: tuple[float, ...] = (12.0, 60.0)
    rounds: tuple[int, ...] = (30, 8)
    walks: int = 40
    kept: float = 20.0
    pull: float = 0.9
    let_go: int = 8
    stalled: int = 20


def price_bounds(
    problem: RoutingProblem,
    known: float,
    options: PriceOptions | None = None,
    changes: Sequence[BatteryChanges | None] = (),
) -> Iterator[float]:
    """Yield ever better bounds of the costliest route.

    Parameters
    ----------
    problem
        With the objective `max`.
    known
        Value of a known plan: the length of the steps follows it. It proves nothing.
    options
        How prices are sought.
    changes
        For each vehicle, how it changes its battery, None: it does not; empty: no vehicle does.
    """
    options = options or PriceOptions()
    changes = changes or [None] * len(problem.vehicles)
    price: Floats = np.ones(problem.customers)
    best = 0.0
    for finest, rounds in zip(options.finest, options.rounds, strict=True):
        walks = walks_of(problem, known, changes, finest, options.work / rounds)
        if walks is None:
            continue
        ascent = _Ascent(walks, price, options)
        for _ in range(int(options.work / walks.work)):
            more = ascent.climb()
            best = max(best, ascent.bound)
            yield best
            if not more:
                break
        price = ascent.best_price


class _Ascent:
    """Rounds of pricing with steps of one length.

    Parameters
    ----------
    walks
        All kinds of vehicles.
    price
        Of each customer, to begin with.
    options
        How prices are sought.

    Attributes
    ----------
    bound
        What the costliest route costs at least.
    best_price
        Prices that prove it.
    """

    def __init__(self, walks: Walks, price: Floats, options: PriceOptions) -> None:
        self._walks, self._options = walks, options
        self.best_price = self._price = price
        self.bound = 0.0
        self._reached = self._stalled = 0
        most = max(len(kind.flights) for kind in walks.kinds)
        self._tables = [Table(len(price), walks.longest + 1) for _ in range(most)]
        self._visits: Floats = np.zeros((0, len(price)))
        self._owner: Ints = np.zeros(0, np.int64)
        self._lasting: Ints = np.zeros(0, np.int64)
        self._crews: list[Crew] = []

    def climb(self) -> bool:
        """Price all walks once; return whether there is more to come."""
        kinds, price, last = self._walks.kinds, self._price, self._walks.steps
        self._crews = []
        for number, kind in enumerate(kinds):
            collected = Collected(kind, price * kind.allowed, self._tables, last)
            crew = Crew(collected.whole, kind.count, self._walks.apart)
            self._crews.append(crew)
            moments = crew.moments(min(self._reached, last))
            for moment in moments:
                visits = collected.visits(moment, self._options.walks // len(moments))
                self._visits = np.vstack([self._visits, visits * kind.allowed])
                self._owner = np.concatenate([self._owner, np.full(len(visits), number)])
                self._lasting = np.concatenate([self._lasting, np.full(len(visits), moment)])
        enough = price.sum() * (1.0 - ROUNDING)
        reached = self._reached + bisect_left(
            range(self._reached, last + 1),
            enough,
            key=lambda moment: sum(crew.collected(moment) for crew in self._crews),
        )
        self._stalled += 1
        if reached > self._reached:
            self._reached, self.best_price, self._stalled = reached, price, 0
            self.bound = reached * self._walks.unit * (1.0 - ROUNDING)
        return self._stalled < self._options.stalled and self._reprice()

    def _reprice(self) -> bool:
        """Set the next prices; return False if walks share all customers: nothing is refuted."""
        # Loaded here: it takes longer than many a plan.
        from scipy.optimize import linprog
        from scipy.sparse import csc_matrix, hstack, identity, vstack

        walks, n = self._visits.shape
        counts = np.array([kind.count for kind in self._walks.kinds], float)
        is_own = np.arange(len(counts))[:, None] == self._owner
        limits, most = is_own.astype(float), counts
        if self._walks.apart > 0.0:
            # Times beyond the shortest one, of which the vehicles share half of the longest.
            span = self._walks.apart * (counts[0] - 1.0)
            beyond = np.maximum(0.0, (self._lasting - self._reached) / span + 1.0)
            limits, most = np.vstack([limits, beyond]), np.append(counts, 0.5 * counts[0])
        rows = vstack([-csc_matrix(self._visits.T), csc_matrix(limits)])
        unserved = vstack([-identity(n), csc_matrix((len(most), n))])
        found = linprog(
            np.concatenate([np.zeros(walks), np.ones(n)]),
            A_ub=hstack([rows, unserved]).tocsc(),
            b_ub=np.concatenate([-np.ones(n), most]),
            method='highs-ds',
        )
        if not found.success or found.fun < ROUNDING * n:
            return False
        price, tolls = -found.ineqlin.marginals[:n], -found.ineqlin.marginals[n:]
        self._forget(found.x[:walks], tolls @ limits - self._visits @ price)
        pull = self._options.pull if self._stalled < self._options.let_go else 0.0
        mixed = (1.0 - pull) * price / price.max() + pull * self.best_price / self.best_price.max()
        self._price = np.maximum(mixed, 0.0)
        return True

    def _forget(self, shares: Floats, reduced: Floats) -> None:
        """Keep walks that are flown, and the most promising others."""
        most = int(self._options.kept * self._visits.shape[1])
        if len(shares) <= most:
            return
        kept = shares > ROUNDING
        kept[np.argsort(reduced, kind='stable')[: int(0.7 * most)]] = True
        self._visits, self._owner = self._visits[kept], self._owner[kept]
        self._lasting = self._lasting[kept]
