# SPDX-License-Identifier: Apache-2.0
"""The fastest path within a budget of dose: Lagrangian dual, then exact labels.

The dual (Handler & Zang 1980) gives a path within the budget, the trade-off between time and dose
near the budget, and a lower bound on the time of every path within it. The label search closes
what is left between the two.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import IndexArray
from rocsafe_geo.limits import (
    require_between,
    require_count,
    require_not_negative,
    require_positive,
)
from rocsafe_ground.errors import BeyondBudgetError, NoWayError
from rocsafe_ground.route.corridor import Corridor
from rocsafe_ground.route.edges import Edges, GridPath, Searcher
from rocsafe_ground.route.route_kernels import FOUND, NONE_FOUND, label_search

# Two costs whose relative difference is smaller are equal; the rest is rounding.
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchEffort:
    """How much work a route is worth.

    Attributes
    ----------
    is_exact
        Whether labels follow the dual.
    most_labels
        Labels after which the exact search gives up, in about a second; a label takes 40 bytes.
    few_labels
        Labels that are tried in each round but the last.
    most_duals
        Steps of the dual; 5 to 9 are usual.
    prices
        Prices of dose, as multiples of that of the dual, of which paths are joined and by whose
        bounds cells and labels are dropped; none: the dual is the whole search, the fastest.
    turns
        Factors of the prices, one for each round in which cells are dropped by all prices: further
        prices give further bounds.
    enough_gap
        Proven gap at which the search ends; 0: at the optimum. Paths that are not better than the
        best one by so much are not looked for.
    """

    is_exact: bool = True
    most_labels: int = 3_000_000
    few_labels: int = 200_000
    most_duals: int = 40
    prices: tuple[float, ...] = (1.0, 0.5, 2.0, 0.2, 5.0)
    turns: tuple[float, ...] = (1.0, 1.4, 0.7, 1.2, 0.85)
    enough_gap: float = 0.0

    def __post_init__(self) -> None:
        require_count('most_labels', self.most_labels, 16, 1_000_000_000)
        require_count('most_duals', self.most_duals, 1, 1000)
        require_between('enough_gap', self.enough_gap, 0.0, 1.0)
        if self.is_exact and not self.prices:
            raise ValueError('prices is empty: an exact search needs at least one')


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoundedPath:
    """A path within a budget, and how good it is.

    Attributes
    ----------
    path
        The fastest path found.
    bound_s
        No path on this grid within the budget takes less.
    price_s_per_usv
        Seconds that one more microsievert saves, about (multiplier of the dual).
    label_count
        Labels that the exact search made; 0: the dual was enough.
    """

    path: GridPath
    bound_s: float
    price_s_per_usv: float
    label_count: int

    @property
    def gap_fraction(self) -> float:
        """Upper bound of the relative excess of the time of the path over the optimum."""
        if self.path.time_s <= 0.0:
            return 0.0
        return max(0.0, 1.0 - self.bound_s / self.path.time_s)


class RouteSearch:
    """Routes between two cells of a grid, for any budget.

    Raises
    ------
    NoWayError
        If no free cells lead from one to the other.
    """

    def __init__(self, searcher: Searcher, start: int, goal: int) -> None:
        self._searcher, self._start, self._goal = searcher, start, goal
        self._quick = searcher.tree(goal, (1.0, 0.0, 0.0))
        if math.isinf(self._quick.costs[start]):
            raise NoWayError('no drivable ground leads from the start to the goal')
        self._clean = searcher.tree(goal, (0.0, 1.0, 0.0))
        self.fastest = self._reversed(self._quick.path_to(start))
        self.cleanest = self._reversed(self._clean.path_to(start))

    @property
    def _edges(self) -> Edges:
        return self._searcher.edges

    def _reversed(self, path: IndexArray) -> GridPath:
        return self._edges.path_of(path[::-1].copy())

    def within(self, budget_usv: float, effort: SearchEffort | None = None) -> BoundedPath:
        """Return the fastest path with a dose within a budget.

        Raises
        ------
        BeyondBudgetError
            If the cleanest path has a higher dose.
        """
        effort = effort or SearchEffort()
        require_not_negative('budget_usv', budget_usv, 'uSv')
        if self.cleanest.dose_usv > budget_usv * (1.0 + ROUNDING):
            raise BeyondBudgetError(
                f'the dose budget of {budget_usv:.4g} uSv is too small: the cleanest way takes '
                f'{self.cleanest.dose_usv:.4g} uSv'
            )
        if self.fastest.dose_usv <= budget_usv:
            return _proven(self.fastest, 0.0)
        dual = self._dual(budget_usv, effort)
        if dual.gap_fraction <= ROUNDING:
            return _proven(dual.path, dual.price_s_per_usv)
        if _is_enough(dual, effort):
            return dual
        return self._closed(budget_usv, dual, effort)

    def _closed(self, budget: float, dual: BoundedPath, effort: SearchEffort) -> BoundedPath:
        """Return the optimum, or the best path that the effort finds, with its bound.

        Round by round a corridor of cells is narrowed, and a few labels are tried in it; in the
        last one all labels that the effort allows.
        """
        known, corridor = dual, Corridor(self._quick.costs, self._clean.costs)
        for turn in effort.turns if effort.prices else ():
            for share in effort.prices:
                price = turn * share * dual.price_s_per_usv
                known = self._one_price(budget, price, known, corridor, effort)
                if known.gap_fraction > ROUNDING and _is_enough(known, effort):
                    return known
            if known.gap_fraction > ROUNDING and effort.is_exact:
                few = replace(effort, most_labels=min(effort.few_labels, effort.most_labels))
                known = self._exact(budget, known, corridor, few)
            if known.gap_fraction <= ROUNDING:
                return replace(known, bound_s=known.path.time_s)
            if _is_enough(known, effort):
                return known
            if not corridor.has_narrowed():
                break
        if effort.is_exact and effort.most_labels > effort.few_labels:
            return self._exact(budget, known, corridor, effort)
        return known

    def _dual(self, budget: float, effort: SearchEffort) -> BoundedPath:
        """Return the best path on the convex hull of time and dose, with the dual's bound."""
        over, under = self.fastest, self.cleanest
        bound, price = over.time_s, 0.0
        for _ in range(effort.most_duals):
            price = (under.time_s - over.time_s) / max(over.dose_usv - under.dose_usv, 1e-300)
            line = over.time_s + price * over.dose_usv
            cells = self._searcher.path(
                self._start, self._goal, (1.0, price), (self._quick, self._clean)
            )
            assert cells is not None  # noqa: S101 - the ends are connected, see __init__
            found = self._edges.path_of(cells)
            lagrangian = found.time_s + price * found.dose_usv
            bound = max(bound, lagrangian - price * budget)
            if lagrangian >= line * (1.0 - ROUNDING):
                break
            if found.dose_usv > budget:
                over = found
            else:
                under = found
        return BoundedPath(
            path=under, bound_s=min(bound, under.time_s), price_s_per_usv=price, label_count=0
        )

    def _one_price(
        self,
        budget: float,
        price: float,
        known: BoundedPath,
        corridor: 'Corridor',
        effort: SearchEffort,
    ) -> BoundedPath:
        """Narrow the corridor by one price; return a better path or bound, if there is one.

        A cell whose cheapest path through it is above what a better path may cost is left out
        (Beasley & Christofides 1989). What is left has tighter bounds. Two prices on one path, up
        to some cell and from there on, come closer to the budget than one.
        """
        wanted = _wanted_s(known, effort)
        limit = wanted * (1.0 + ROUNDING) + price * budget
        weights = (1.0, price, 0.0)
        there = self._searcher.tree_within(self._start, weights, corridor.to_come(price), limit)
        back = self._searcher.tree_within(self._goal, weights, there.costs, limit)
        through = there.costs + back.costs
        corridor.keep(through <= limit, price, there, back)
        # Paths that were left out are no better than what is wanted.
        least = min(float(through[self._start]) - price * budget, wanted)
        bound = max(known.bound_s, least)
        path = self._better(budget, known.path, corridor)
        return replace(known, path=path, bound_s=min(bound, path.time_s))

    def _better(self, budget: float, best: GridPath, corridor: 'Corridor') -> GridPath:
        """Return the best path of two prices, one of which is the newest."""
        places = np.flatnonzero(corridor.is_open)
        for first, last in corridor.pairs() if len(places) else ():
            seconds = np.where(
                first.doses_usv[places] + last.doses_usv[places] <= budget,
                first.times_s[places] + last.times_s[places],
                math.inf,
            )
            found = int(seconds.argmin())
            if seconds[found] < best.time_s * (1.0 - ROUNDING):
                middle = int(places[found])
                cells = [first.path_to(middle), last.path_to(middle)[-2::-1]]
                best = self._edges.path_of(np.concatenate(cells))
        return best

    def _exact(
        self, budget: float, known: BoundedPath, corridor: 'Corridor', effort: SearchEffort
    ) -> BoundedPath:
        """Return the optimum, or the best known if none is better by enough, or labels run out."""
        room, wanted = effort.most_labels, _wanted_s(known, effort)
        labels = (
            np.empty(room, np.int64), np.empty(room, np.int64), np.empty(room), np.empty(room)
        )  # fmt: skip
        # Within the corridor the least time and dose to the goal are larger.
        quick, clean = (
            self._searcher.tree_within(self._goal, weights, corridor.wall, 0.0).costs
            for weights in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        )
        status, last, count, reached = label_search(
            (self._edges.times_s, self._edges.doses_usv),
            self._edges.offsets,
            (self._start, self._goal),
            (budget * (1.0 + ROUNDING), wanted * (1.0 + ROUNDING)),
            (quick, clean),
            corridor.bounds(),
            np.where(corridor.is_open, math.inf, 0.0),
            labels,
            (np.empty(room), np.empty(room, np.int64)),
        )
        price, path = known.price_s_per_usv, known.path
        if status == FOUND:
            best = self._edges.path_of(path_of_labels(labels[0], labels[1], last))
            return _proven(min(best, path, key=lambda one: one.time_s), price, int(count))
        bound = max(known.bound_s, wanted if status == NONE_FOUND else min(float(reached), wanted))
        return BoundedPath(
            path=path, bound_s=min(bound, path.time_s), price_s_per_usv=price,
            label_count=int(count),
        )  # fmt: skip

    def trade_off(self, count: int) -> tuple[tuple[float, BoundedPath], ...]:
        """Return budgets from the cleanest to the fastest path with the best path of each.

        The budgets are spaced evenly in logarithm. The dual is enough: its gap is mostly below a
        percent.
        """
        require_count('count', count, 2, 1000)
        low, high = self.cleanest.dose_usv, self.fastest.dose_usv
        require_positive('dose of the cleanest path', low, 'uSv')
        effort = SearchEffort(is_exact=False)
        budgets = np.geomspace(low, max(low, high), count) * (1.0 + ROUNDING)
        return tuple((float(one), self.within(float(one), effort)) for one in budgets)


def _is_enough(found: BoundedPath, effort: SearchEffort) -> bool:
    return found.gap_fraction <= effort.enough_gap + ROUNDING


def _wanted_s(known: BoundedPath, effort: SearchEffort) -> float:
    """Return the time below which a path is better by enough."""
    return known.path.time_s * (1.0 - effort.enough_gap)


def _proven(path: GridPath, price: float, labels: int = 0) -> BoundedPath:
    return BoundedPath(path=path, bound_s=path.time_s, price_s_per_usv=price, label_count=labels)


def path_of_labels(cells: IndexArray, befores: IndexArray, last: int) -> IndexArray:
    """Return the cells of a label and of those before it, the first one first."""
    path = []
    while last >= 0:
        path.append(int(cells[last]))
        last = int(befores[last])
    return np.array(path[::-1], np.int64)
