# SPDX-License-Identifier: Apache-2.0
"""A round trip through points with the least time, within budgets of dose, gas and time.

The dual prices dose and toxic load: at each price the cheapest ways between all pairs and the
cheapest order are exact, so that their cost is a lower bound. The ways found at all prices are
then combined along each order, exactly.
"""

import math
from collections.abc import Callable, Collection, Iterator, Sequence

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.errors import BeyondBudgetError
from rocsafe_ground.route.constrained import ROUNDING
from rocsafe_ground.route.edges import Searcher, Weights
from rocsafe_ground.route.prices import Costs, best_prices
from rocsafe_ground.tour.choice import Limit, candidates
from rocsafe_ground.tour.joining import Choices, Legs, joined
from rocsafe_ground.tour.orders import MOST_POINTS, Orders, members_of, orders_of
from rocsafe_ground.tour.trip import Budgets, Tour, TourPoint
from rocsafe_ground.tour.ways import CLEANEST, PUREST, QUICKEST, Ways

# Prices that are tried; four to seven are usual.
MOST_PRICES = 12
# Gap between bound and trip at which no further price is tried.
SMALL_GAP = 4e-3
# Part of the time within which the bound of new prices is that of the trips known.
SAME_LEVEL = 1e-7

Badness = Callable[[FloatArray], FloatArray]
"""Of rows of time, dose and toxic load with dwells, (n, 3): a number each."""


class TourSearch:
    """Round trips from a start through points, for any budget.

    Parameters
    ----------
    searcher
        Of the grid.
    start
        Cell.
    points
        Up to `MOST_POINTS`.
    end
        Cell in which a trip ends; None: at the start.
    """

    def __init__(
        self,
        searcher: Searcher,
        start: int,
        points: Sequence[TourPoint],
        end: int | None = None,
    ) -> None:
        if len(points) > MOST_POINTS:
            raise ValueError(f'{len(points)} evidence points: must be at most {MOST_POINTS}')
        self._points = tuple(points)
        self._made_of = (searcher, start, self._points, end)
        other = () if end in (None, start) else (end,)
        self._end = len(points) + 1 if other else 0
        self._ways = Ways(searcher, (start, *(point.cell for point in points), *other))
        self._orders: dict[Weights, Orders] = {}
        self._dwells = np.array([point.dwell for point in points]).reshape(-1, 3)
        # Orders of each set that were found at some prices.
        self._tried: dict[int, set[tuple[int, ...]]] = {}

    def renewed(self) -> 'TourSearch':
        """Return the same search, as it begins: it knows no ways."""
        return TourSearch(*self._made_of)

    def best(self, budgets: Budgets, refused: Collection[int] = ()) -> Tour:
        """Return the fastest trip within the budgets through the worthiest points that fit.

        Sets of points in `refused` are left out, see `Tour.chosen`.

        Raises
        ------
        BeyondBudgetError
            If not one point can be visited within the budgets.
        """
        for chosen in candidates(self._limits(budgets), self._points):
            found = None if chosen in refused else self._within(chosen, budgets)
            # A fast trip and a clean one may fit, each, but none that is both.
            if found is not None and found.time_s <= budgets.time_s * (1.0 + ROUNDING):
                return found
        raise BeyondBudgetError('the budgets are too small for any of the points')

    def within(self, chosen: int, budgets: Budgets) -> Tour:
        """Return the fastest trip through a set of points within budgets of dose and load.

        Raises
        ------
        BeyondBudgetError
            If none is found.
        """
        found = self._within(chosen, budgets)
        if found is None:
            raise BeyondBudgetError(
                f'the dose budget of {budgets.dose_usv:.4g} uSv is too small: the cleanest way '
                f'takes {self.cleanest_usv(chosen):.4g} uSv'
            )
        return found

    def fastest(self, chosen: int) -> Tour:
        """Return the trip through a set of points with the least time."""
        return self._pure(QUICKEST, chosen)

    def cleanest(self, chosen: int, load: float = math.inf) -> Tour | None:
        """Return the trip with the least dose through a set of points, within a toxic load.

        None if none is known within it.
        """
        if math.isinf(load):
            return self._pure(CLEANEST, chosen)
        room = (math.inf, load - self._dwell(chosen)[2])
        return self._picked(chosen, room, lambda costs: costs[:, 1])

    def cleanest_usv(self, chosen: int) -> float:
        """Return the least dose of a trip through a set of points."""
        return self._pure(CLEANEST, chosen).dose_usv

    def known(self, chosen: int, badness: Badness) -> Tour:
        """Return the trip with the least `badness` of the ways and orders that were found."""
        found = self._picked(chosen, (math.inf, math.inf), badness)
        assert found is not None  # noqa: S101 - there is always a fastest one
        return found

    def _picked(self, chosen: int, room: tuple[float, float], badness: Badness) -> Tour | None:
        """Return the known trip within the room that is least bad, None if none is."""
        for weights in (QUICKEST, CLEANEST, PUREST) if self._has_gas else (QUICKEST, CLEANEST):
            self._trip(weights, chosen)
        dwell = np.array(self._dwell(chosen))
        found: tuple[float, Legs, tuple[int, ...]] | None = None
        for order, choices in self._choices(chosen, room):
            if not len(choices.costs):
                continue
            values = badness(choices.costs + dwell)
            best = int(values.argmin())
            if found is None or values[best] < found[0]:
                found = float(values[best]), choices.legs(best), order
        if found is None:
            return None
        bound = self._orders_at(QUICKEST).bound(chosen)
        return self._tour(chosen, found[1], found[2], bound, 0.0)

    @property
    def _has_gas(self) -> bool:
        return self._ways.searcher.edges.loads is not None

    def _limits(self, budgets: Budgets) -> list[Limit]:
        """Return the budgets of time and dose, and of the load if there is one."""
        pure = (QUICKEST, CLEANEST, PUREST)[: 3 if math.isfinite(budgets.load) else 2]
        return [
            Limit(
                limit=budgets.limits[k], orders=self._orders_at(weights),
                costs=self._costs(weights), dwells=self._dwells[:, k],
            )
            for k, weights in enumerate(pure)
        ]  # fmt: skip

    def _costs(self, weights: Weights) -> FloatArray:
        """Return the costs between start and points; the way to the start is that to the end."""
        table = self._ways.costs(weights)
        count = len(self._points) + 1
        closed = table[:count, :count].copy()
        closed[1:, 0] = table[1:count, self._end]
        return closed

    def _orders_at(self, weights: Weights) -> Orders:
        if weights not in self._orders:
            self._orders[weights] = orders_of(self._costs(weights))
        return self._orders[weights]

    def _dwell(self, chosen: int) -> Costs:
        members = [k - 1 for k in members_of(chosen)]
        time, dose, load = self._dwells[members].sum(axis=0).tolist()
        return time, dose, load

    def _trip(self, weights: Weights, chosen: int) -> tuple[Legs, tuple[int, ...]]:
        """Return the cheapest trip through a set, and its order."""
        order = self._orders_at(weights).order(chosen)
        self._tried.setdefault(chosen, set()).add(order)
        return tuple(self._ways.way(weights, a, b) for a, b in self._legs(order)), order

    def _legs(self, order: tuple[int, ...]) -> list[tuple[int, int]]:
        return list(zip((0, *order), (*order, self._end), strict=True))

    def _pure(self, weights: Weights, chosen: int) -> Tour:
        """Return the cheapest trip with one weight; the fastest if several are equally cheap."""
        legs, order = self._trip(weights, chosen)
        orders = self._orders_at(weights)
        is_proven = orders.bound(chosen) >= orders.cost(chosen) * (1.0 - ROUNDING)
        quickest = _sums(legs)[0] if is_proven else self._orders_at(QUICKEST).bound(chosen)
        return self._tour(chosen, legs, order, quickest, 0.0)

    def _tour(
        self,
        chosen: int,
        legs: Legs,
        order: tuple[int, ...],
        bound_s: float,
        price_s_per_usv: float,
    ) -> Tour:
        time, dose, load = (a + b for a, b in zip(_sums(legs), self._dwell(chosen), strict=True))
        return Tour(
            order=tuple(k - 1 for k in order), legs=legs, time_s=time, dose_usv=dose,
            load=load, bound_s=min(time, bound_s + self._dwell(chosen)[0]),
            price_s_per_usv=price_s_per_usv,
            left_out=tuple(k for k in range(len(self._points)) if not chosen >> k & 1),
        )  # fmt: skip

    def _within(self, chosen: int, budgets: Budgets) -> Tour | None:
        """Return the fastest trip through a set within dose and load, None if none is found."""
        _, dwell_usv, dwell_load = self._dwell(chosen)
        room = (budgets.dose_usv - dwell_usv, budgets.load - dwell_load)
        quickest, order = self._trip(QUICKEST, chosen)
        bound, prices = self._orders_at(QUICKEST).bound(chosen), (0.0, 0.0)
        known = [_sums(quickest)]
        if known[0][1] <= room[0] and known[0][2] <= room[1]:
            return self._tour(chosen, quickest, order, bound, 0.0)
        for weights in (CLEANEST, PUREST)[: 2 if math.isfinite(budgets.load) else 1]:
            known.append(_sums(self._trip(weights, chosen)[0]))
        best = None
        for _ in range(MOST_PRICES):
            prices, level = best_prices(known, room)
            weights = (1.0, *prices)
            found, _ = self._trip(weights, chosen)
            orders = self._orders_at(weights)
            spent = sum(price * limit for price, limit in zip(prices, room, strict=True) if price)
            bound = max(bound, orders.bound(chosen) - spent)
            best = self._fastest(chosen, room)
            if orders.cost(chosen) - spent >= level - SAME_LEVEL * abs(level):
                break
            if best is not None and best[0] <= bound * (1.0 + SMALL_GAP):
                break
            known.append(_sums(found))
        return None if best is None else self._tour(chosen, best[1], best[2], bound, prices[0])

    def _fastest(
        self, chosen: int, room: tuple[float, float]
    ) -> tuple[float, Legs, tuple[int, ...]] | None:
        """Return time, ways and order of the fastest choice of the ways found within the room."""
        found = None
        for order, choices in self._choices(chosen, room):
            if len(choices.costs) and (found is None or choices.costs[0, 0] < found[0]):
                found = float(choices.costs[0, 0]), choices.legs(0), order
        return found

    def _choices(
        self, chosen: int, room: tuple[float, float]
    ) -> Iterator[tuple[tuple[int, ...], Choices]]:
        """Yield choices of the ways found along the orders tried."""
        for order in sorted(self._tried[chosen]):
            yield order, joined([self._ways.options(a, b) for a, b in self._legs(order)], room)


def _sums(legs: Legs) -> Costs:
    """Return time, dose and load of ways."""
    return (
        sum(leg.time_s for leg in legs),
        sum(leg.dose_usv for leg in legs),
        sum(leg.load for leg in legs),
    )
