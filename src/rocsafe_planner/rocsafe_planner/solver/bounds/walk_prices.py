# SPDX-License-Identifier: Apache-2.0
"""A bound from prices: what the vehicles cannot collect within a time, no plan can serve by then.

Each customer is given a price. If all vehicles together, whatever walks they fly, cannot collect
the sum of all prices within a time, no plan is done by that time. What one vehicle can collect is
found by dynamic programming over steps of time, to which legs are rounded down. The prices are
those of the linear program that shares all customers among the walks found so far (column
generation), drawn towards the best prices so far, which keeps them from jumping (Pessoa, Sadykov,
Uchoa & Vanderbeck 2018, doi:10.1287/ijoc.2017.0784).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rocsafe_planner.solver.bounds.relaxation import end_stays, leg_tables
from rocsafe_planner.solver.bounds.walks import best_ends, collect, count_visits
from rocsafe_planner.solver.model.problem import RoutingProblem
from rocsafe_planner.solver.model.tables import Floats, Ints

ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class PriceOptions:
    """How prices are sought.

    Attributes
    ----------
    steps
        Steps of time that the known plan is divided into: first the coarse ones.
    work
        Most additions of the dynamic programs of each of them; a count, so that the bound is
        reproducible.
    fewest_rounds
        Where the work does not allow for so many rounds, there is no bound.
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

    steps: tuple[int, ...] = (500, 2500)
    work: float = 6e8
    fewest_rounds: int = 10
    walks: int = 40
    kept: float = 20.0
    pull: float = 0.9
    let_go: int = 8
    stalled: int = 20


def price_bounds(
    problem: RoutingProblem, known: float, options: PriceOptions | None = None
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
    """
    options = options or PriceOptions()
    price: Floats = np.ones(problem.customers)
    best = 0.0
    for steps in options.steps:
        walks = _walks_of(problem, known, steps)
        if walks is None or options.work / walks.work < options.fewest_rounds:
            return
        ascent = _Ascent(walks, price, options)
        for _ in range(int(options.work / walks.work)):
            more = ascent.climb()
            best = max(best, ascent.bound)
            yield best
            if not more:
                break
        price = ascent.best_price


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Kind:
    """Vehicles that fly alike: their legs in steps, and whom they may serve."""

    legs: Ints
    first: Ints
    last: Ints
    allowed: Floats
    count: int
    longest: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Walks:
    """All kinds of vehicles, the length of a step and their number."""

    kinds: tuple[_Kind, ...]
    unit: float
    steps: int

    @property
    def work(self) -> float:
        """Additions of a round."""
        return float(sum(kind.legs.size for kind in self.kinds) * self.steps)


def _walks_of(problem: RoutingProblem, known: float, steps: int) -> _Walks | None:
    """Return the walks in at most `steps` steps, None if a leg is shorter than a step."""
    n = problem.customers
    tables, _ = leg_tables(problem)
    between = [table[:n, :n] for table in tables]
    unit = _unit(between, known, steps)
    if unit is None:
        return None
    alike: dict[tuple[object, ...], list[int]] = {}
    for k, vehicle in enumerate(problem.vehicles):
        who = b'' if problem.allowed is None else problem.allowed[k].tobytes()
        ends = (vehicle.legs, vehicle.start, vehicle.end, vehicle.fixed_cost)
        alike.setdefault((*ends, _longest(problem, k), who), []).append(k)
    stays = end_stays(problem)
    kinds = []
    for members in alike.values():
        vehicle = problem.vehicles[members[0]]
        table = tables[vehicle.legs]
        home = stays[vehicle.legs] if vehicle.end is None else table[:n, vehicle.end]
        longest = _longest(problem, members[0])
        allowed = np.ones(n) if problem.allowed is None else problem.allowed[members[0]]
        kinds.append(
            _Kind(
                legs=_in_steps(between[vehicle.legs], unit),
                first=_in_steps(vehicle.fixed_cost + table[vehicle.start, :n], unit),
                last=_in_steps(home, unit),
                allowed=allowed.astype(np.float64),
                count=len(members),
                longest=int(min(longest / unit * (1.0 + ROUNDING) + ROUNDING, 2**30)),
            )
        )
    return _Walks(kinds=tuple(kinds), unit=unit, steps=int(known / unit) + 1)


def _longest(problem: RoutingProblem, k: int) -> float:
    """Return the most that a route of a vehicle may cost by its limit."""
    vehicle = problem.vehicles[k]
    is_same = vehicle.limiting_legs == vehicle.legs
    return vehicle.fixed_cost + vehicle.limit if is_same else np.inf


def _in_steps(costs: Floats, unit: float) -> Ints:
    return np.floor(costs / unit + ROUNDING).astype(np.int32)


def _unit(between: list[Floats], known: float, steps: int) -> float | None:
    """Return the length of a step, for which short legs lose least by rounding; None: too long."""
    n = len(between[0])
    if known <= 0.0:
        return None
    if n == 1:
        return known / steps
    near = np.concatenate([np.sort(table, axis=1)[:, 1:5].ravel() for table in between])
    units = known / np.linspace(0.5 * steps, steps, 400)
    lost = [float((near - unit * np.floor(near / unit + ROUNDING)).mean()) for unit in units]
    unit = float(units[int(np.argmin(lost))])
    return unit if near.min() >= unit else None


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

    def __init__(self, walks: _Walks, price: Floats, options: PriceOptions) -> None:
        self._walks, self._options = walks, options
        self.best_price = self._price = price
        self.bound = 0.0
        self._reached = self._stalled = 0
        n, moments = len(price), walks.steps + 1
        self._prizes = np.empty((2, moments, n))
        self._before = np.empty((2, moments, n), np.int32)
        self._visits: Floats = np.zeros((0, n))
        self._owner: Ints = np.zeros(0, np.int64)

    def climb(self) -> bool:
        """Price all walks once; return whether there is more to come."""
        kinds, price = self._walks.kinds, self._price
        total = np.zeros(self._walks.steps + 1)
        for number, kind in enumerate(kinds):
            total += kind.count * self._collected(kind)
            steps = min(self._reached, self._walks.steps, kind.longest)
            ends, times = best_ends(self._prizes[0], kind.last, steps, self._options.walks)
            self._take_walks(number, ends, times)
        refuted = np.flatnonzero(total < price.sum() * (1.0 - ROUNDING))
        reached = int(refuted[-1]) + 1 if len(refuted) else 0
        self._stalled += 1
        if reached > self._reached:
            self._reached, self.best_price, self._stalled = reached, price, 0
            self.bound = reached * self._walks.unit * (1.0 - ROUNDING)
        return self._stalled < self._options.stalled and self._reprice()

    def _collected(self, kind: _Kind) -> Floats:
        """Return what one vehicle collects by each moment at most."""
        collected = np.empty(self._walks.steps + 1)
        (best, second), (before, before_second) = self._prizes, self._before
        collect(
            kind.legs, kind.first, kind.last, self._price * kind.allowed,
            best, before, second, before_second, collected,
        )  # fmt: skip
        if kind.longest < len(collected):
            collected[kind.longest :] = collected[kind.longest]
        return collected

    def _take_walks(self, number: int, ends: Ints, times: Ints) -> None:
        """Take walks of a kind of vehicle into the linear program."""
        kind = self._walks.kinds[number]
        visits = np.empty((len(ends), len(kind.first)), np.int32)
        count_visits(kind.legs, self._before[0], self._before[1], ends, times, visits)
        self._visits = np.vstack([self._visits, visits * kind.allowed])
        self._owner = np.concatenate([self._owner, np.full(len(ends), number)])

    def _reprice(self) -> bool:
        """Set the next prices; return False if walks share all customers: nothing is refuted."""
        # Loaded here: it takes longer than many a plan.
        from scipy.optimize import linprog
        from scipy.sparse import csc_matrix, hstack, identity, vstack

        walks, n = self._visits.shape
        counts = np.array([kind.count for kind in self._walks.kinds], float)
        owners = csc_matrix((np.arange(len(counts))[:, None] == self._owner).astype(float))
        rows = vstack([-csc_matrix(self._visits.T), owners])
        unserved = vstack([-identity(n), csc_matrix((len(counts), n))])
        found = linprog(
            np.concatenate([np.zeros(walks), np.ones(n)]),
            A_ub=hstack([rows, unserved]).tocsc(),
            b_ub=np.concatenate([-np.ones(n), counts]),
            method='highs-ds',
        )
        if not found.success or found.fun < ROUNDING * n:
            return False
        price, tolls = -found.ineqlin.marginals[:n], -found.ineqlin.marginals[n:]
        self._forget(found.x[:walks], tolls[self._owner] - self._visits @ price)
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
