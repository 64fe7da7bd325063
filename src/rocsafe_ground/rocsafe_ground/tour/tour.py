# SPDX-License-Identifier: Apache-2.0
"""A round trip through points with the least time, within budgets of dose and time.

The dual prices the dose: at each price the cheapest ways between all pairs and the cheapest order
are exact, so that their cost is a lower bound. The ways found at all prices are then combined
along each order, exactly.
"""

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.limits import require_not_negative, require_positive
from rocsafe_ground.errors import BeyondBudgetError
from rocsafe_ground.route.constrained import ROUNDING, GridPath
from rocsafe_ground.route.edges import Searcher
from rocsafe_ground.tour.orders import RoundTrips, round_trips
from rocsafe_ground.tour.ways import DOSE_ONLY, Ways

# Prices that are tried; four to seven are usual.
MOST_PRICES = 12
# Gap between bound and trip at which no further price is tried.
SMALL_GAP = 4e-3
# No limit of time.
AMPLE_S = 1e12


@dataclass(frozen=True, slots=True, kw_only=True)
class TourPoint:
    """A point to visit: its cell, time and dose of standing there, weight against others."""

    cell: int
    dwell_s: float = 0.0
    dwell_usv: float = 0.0
    priority: float = 1.0

    def __post_init__(self) -> None:
        require_not_negative('dwell_s', self.dwell_s, 's')
        require_not_negative('dwell_usv', self.dwell_usv, 'uSv')
        require_positive('priority', self.priority)


@dataclass(frozen=True, slots=True, kw_only=True)
class Budgets:
    """What a trip may take: dose in microsievert, time in seconds."""

    dose_usv: float
    time_s: float

    def __post_init__(self) -> None:
        if not self.dose_usv >= 0.0:
            raise ValueError(f'dose_usv is {self.dose_usv:g} uSv: must be 0 or above')
        require_positive('time_s', self.time_s, 's')


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tour:
    """A round trip.

    Attributes
    ----------
    order
        Numbers of the points visited, from 0.
    legs
        Ways: start to first point, and so on, and back to the start.
    time_s, dose_usv
        With dwells.
    bound_s
        No trip on this grid through these points within the budget of dose takes less.
    price_s_per_usv
        Seconds that one more microsievert saves, about.
    left_out
        Points that do not fit.
    """

    order: tuple[int, ...]
    legs: tuple[GridPath, ...]
    time_s: float
    dose_usv: float
    bound_s: float
    price_s_per_usv: float
    left_out: tuple[int, ...]

    @property
    def chosen(self) -> int:
        """The points visited as a set: bit k is point k."""
        return sum(1 << k for k in self.order)

    @property
    def gap_fraction(self) -> float:
        """Bound of the share by which the time of the trip is above the optimum."""
        return max(0.0, 1.0 - self.bound_s / self.time_s) if self.time_s > 0.0 else 0.0


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
        self._points = tuple(points)
        other = () if end in (None, start) else (end,)
        self._end = len(points) + 1 if other else 0
        self._ways = Ways(searcher, (start, *(point.cell for point in points), *other))
        sets = np.arange(1 << len(points))
        bits = (sets[:, None] >> np.arange(len(points)) & 1).astype(np.float64)
        self._dwell_s = bits @ np.array([point.dwell_s for point in points])
        self._dwell_usv = bits @ np.array([point.dwell_usv for point in points])
        self._worth = bits @ np.array([point.priority for point in points])

    def trips(self, price: float) -> RoundTrips:
        """Return the cheapest trips through all sets of points, without dwells."""
        times, doses = (self._closed(table) for table in self._ways.tables(price))
        return round_trips(times, doses, price)

    def _closed(self, table: FloatArray) -> FloatArray:
        """Return a table whose way from a point to the start is that to the end."""
        count = len(self._points) + 1
        closed = table[:count, :count].copy()
        closed[1:, 0] = table[1:count, self._end]
        return closed

    def best(self, budgets: Budgets, refused: Collection[int] = ()) -> Tour:
        """Return the fastest trip within the budgets through the worthiest points that fit.

        Sets of points in `refused` are left out, see `Tour.chosen`.

        Raises
        ------
        BeyondBudgetError
            If not one point can be visited within the budgets.
        """
        fits = self._fitting(budgets)
        fits[list(refused)] = False
        while True:
            chosen = self._worthiest(fits, budgets)
            legs, order, bound, price = self._within(chosen, budgets)
            time = float(self._dwell_s[chosen]) + sum(leg.time_s for leg in legs)
            if time <= budgets.time_s * (1.0 + ROUNDING):
                break
            # A fast trip and a clean one may fit, each, but none that is both.
            fits[chosen] = False
        return self._tour(chosen, (legs, order, bound, price))

    def of(self, tour: Tour, dose_usv: float) -> Tour:
        """Return the fastest trip through the points of another within a dose.

        Raises
        ------
        BeyondBudgetError
            If there is none.
        """
        least = self.least_dose(tour.chosen)
        if least > dose_usv * (1.0 + ROUNDING):
            raise BeyondBudgetError(
                f'the dose budget of {dose_usv:.4g} uSv is too small: the cleanest way takes '
                f'{least:.4g} uSv'
            )
        budgets = Budgets(dose_usv=dose_usv, time_s=AMPLE_S)
        return self._tour(tour.chosen, self._within(tour.chosen, budgets))

    def least_dose(self, chosen: int) -> float:
        """Return the dose of the cleanest trip through a set of points, uSv."""
        return float(self._doses(self.trips(DOSE_ONLY))[chosen])

    def cleanest(self, chosen: int) -> Tour:
        """Return the trip through a set of points with the least dose."""
        budgets = Budgets(dose_usv=self.least_dose(chosen), time_s=AMPLE_S)
        return self._tour(chosen, self._within(chosen, budgets))

    def _tour(self, chosen: int, found: 'Found') -> Tour:
        legs, order, bound, price = found
        time = float(self._dwell_s[chosen]) + sum(leg.time_s for leg in legs)
        dose = float(self._dwell_usv[chosen]) + sum(leg.dose_usv for leg in legs)
        return Tour(
            order=tuple(k - 1 for k in order), legs=legs, time_s=time, dose_usv=dose,
            bound_s=min(time, bound + float(self._dwell_s[chosen])), price_s_per_usv=price,
            left_out=tuple(k for k in range(len(self._points)) if not chosen >> k & 1),
        )  # fmt: skip

    def _doses(self, trips: RoundTrips) -> FloatArray:
        return trips.doses_usv + self._dwell_usv

    def _times(self, trips: RoundTrips) -> FloatArray:
        return trips.times_s + self._dwell_s

    def _fitting(self, budgets: Budgets) -> BoolArray:
        """Return which sets have trips clean enough, and trips fast enough."""
        clean, quick = self.trips(DOSE_ONLY), self.trips(0.0)
        fits = (self._doses(clean) <= budgets.dose_usv * (1.0 + ROUNDING)) & (
            self._times(quick) <= budgets.time_s * (1.0 + ROUNDING)
        )
        fits[0] = False
        return np.asarray(fits)

    def _worthiest(self, fits: BoolArray, budgets: Budgets) -> int:
        """Return the set with the largest priority of those that fit."""
        if not fits.any():
            raise BeyondBudgetError(self._least_text(budgets))
        worth = np.where(fits, self._worth, -1.0)
        best = np.flatnonzero(worth >= worth.max() * (1.0 - ROUNDING))
        return int(best[self._times(self.trips(0.0))[best].argmin()])

    def _least_text(self, budgets: Budgets) -> str:
        """Return what the smallest trip to a point and back takes."""
        clean, quick = self.trips(DOSE_ONLY), self.trips(0.0)
        dose, time = self._doses(clean)[1:], self._times(quick)[1:]
        if dose.min() > budgets.dose_usv:
            return (
                f'the dose budget of {budgets.dose_usv:.4g} uSv is too small: the cleanest way '
                f'to one point and back takes {dose.min():.4g} uSv'
            )
        if time.min() > budgets.time_s:
            return (
                f'the endurance of {budgets.time_s:.4g} s is too short: the fastest way to one '
                f'point and back takes {time.min():.4g} s'
            )
        return (
            f'no way to one point and back was found within both {budgets.dose_usv:.4g} uSv and '
            f'{budgets.time_s:.4g} s: the cleanest takes {dose.min():.4g} uSv and '
            f'{self._times(clean)[1:][dose.argmin()]:.4g} s'
        )

    def least_time(self, chosen: int) -> float:
        """Return the time of the fastest trip through a set of points, s."""
        return float(self._times(self.trips(0.0))[chosen])

    def _within(self, chosen: int, budgets: Budgets) -> 'Found':
        """Return legs, order, bound without dwells and price of the trip through a set."""
        room = budgets.dose_usv - float(self._dwell_usv[chosen])
        over, under = self.trips(0.0), self.trips(DOSE_ONLY)
        orders = [over.order(chosen), under.order(chosen)]
        bound, price = float(over.times_s[chosen]), 0.0
        if over.doses_usv[chosen] <= room:
            return self._combined(orders[0], room), orders[0], bound, price
        for _ in range(MOST_PRICES):
            drop = float(over.doses_usv[chosen] - under.doses_usv[chosen])
            price = float(under.times_s[chosen] - over.times_s[chosen]) / max(drop, 1e-300)
            trips = self.trips(price)
            orders.append(trips.order(chosen))
            bound = max(bound, float(trips.costs[chosen]) - price * room)
            line = float(over.times_s[chosen] + price * over.doses_usv[chosen])
            if trips.costs[chosen] >= line * (1.0 - ROUNDING):
                break
            legs = min((self._combined(one, room) for one in set(orders)), key=_time)
            if _time(legs) <= bound * (1.0 + SMALL_GAP):
                break
            if trips.doses_usv[chosen] > room:
                over = trips
            else:
                under = trips
        best = min(set(orders), key=lambda one: _time(self._combined(one, room)))
        return self._combined(best, room), best, bound, price

    def _combined(self, order: tuple[int, ...], room_usv: float) -> tuple[GridPath, ...]:
        """Return the fastest choice of the ways found along an order, within a dose; or ().

        Partial choices that another is no worse than in time and dose are dropped.
        """
        stops = (0, *order, self._end)
        partial: list[tuple[float, float, tuple[GridPath, ...]]] = [(0.0, 0.0, ())]
        for a, b in itertools.pairwise(stops):
            longer = [
                (time + way.time_s, dose + way.dose_usv, (*legs, way))
                for time, dose, legs in partial
                for way in self._ways.options(a, b)
                if dose + way.dose_usv <= room_usv * (1.0 + ROUNDING)
            ]
            partial = _undominated(longer)
        return partial[0][2] if partial else ()


Found = tuple[tuple[GridPath, ...], tuple[int, ...], float, float]
Partial = tuple[float, float, tuple[GridPath, ...]]


def _undominated(choices: list[Partial]) -> list[Partial]:
    """Return those that no other is as fast and as clean as, the fastest first."""
    kept: list[Partial] = []
    for choice in sorted(choices, key=lambda one: one[:2]):
        if not kept or choice[1] < kept[-1][1]:
            kept.append(choice)
    return kept


def _time(legs: tuple[GridPath, ...]) -> float:
    return sum(leg.time_s for leg in legs) if legs else math.inf
