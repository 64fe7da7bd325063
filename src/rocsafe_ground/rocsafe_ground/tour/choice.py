# SPDX-License-Identifier: Apache-2.0
"""Sets of points that may fit into the budgets, the worthiest first."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.route.constrained import ROUNDING
from rocsafe_ground.tour.orders import ExactOrders, Orders, members_of, trip_cost
from rocsafe_ground.tour.trip import TourPoint


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Limit:
    """One budget: its limit, the cheapest trips by it alone, and what dwells take of it.

    Attributes
    ----------
    limit
        With dwells.
    orders
        The cheapest trips by what is limited alone.
    costs : (points + 1, points + 1)
        Of the ways between points.
    dwells : (points,)
        Of the points.
    """

    limit: float
    orders: Orders
    costs: FloatArray
    dwells: FloatArray

    def least(self, chosen: int) -> float:
        """Return the least that a trip through a set takes."""
        return self.orders.cost(chosen) + sum(self.dwells[k - 1] for k in members_of(chosen))

    def fits(self, chosen: int) -> bool:
        """Return whether some trip through a set keeps this limit."""
        return self.least(chosen) <= self.limit * (1.0 + ROUNDING)


def candidates(limits: Sequence[Limit], points: Sequence[TourPoint]) -> Iterator[int]:
    """Yield sets that fit each limit by itself; the first limit is that of time."""
    if isinstance(limits[0].orders, ExactOrders):
        yield from _all_sets(limits, points)
    else:
        yield from _by_greed(limits, points)


def _all_sets(limits: Sequence[Limit], points: Sequence[TourPoint]) -> Iterator[int]:
    """Yield all sets that fit: the largest sum of priorities first, of equal ones the quickest."""
    sets = np.arange(1 << len(points))
    bits = (sets[:, None] >> np.arange(len(points)) & 1).astype(np.float64)
    least = []
    for one in limits:
        assert isinstance(one.orders, ExactOrders)  # noqa: S101 - all have the same points
        least.append(one.orders.costs + bits @ one.dwells)
    fits = np.all(
        [sums <= one.limit * (1.0 + ROUNDING) for sums, one in zip(least, limits, strict=True)],
        axis=0,
    )
    fits[0] = False
    worth = bits @ np.array([point.priority for point in points])
    by_worth = np.lexsort((least[0], -np.round(worth / worth.max(), 9)))
    yield from (int(one) for one in by_worth if fits[one])


def _by_greed(limits: Sequence[Limit], points: Sequence[TourPoint]) -> Iterator[int]:
    """Yield a set that fits, and ever smaller ones.

    Points are dropped that relieve the limit the most for their priority; then those are added
    again that still fit, the worthiest first.
    """
    chosen = (1 << len(points)) - 1
    while chosen:
        broken = next((one for one in limits if not one.fits(chosen)), None)
        if broken is not None:
            chosen = _relieved(chosen, broken, points)
            continue
        more = _refilled(chosen, limits, points)
        yield more
        if more != chosen:
            yield chosen
        chosen = _without(chosen, limits[0], points)


def _relieved(chosen: int, broken: Limit, points: Sequence[TourPoint]) -> int:
    """Return the set without as many points as the limit asks for by the order there is."""
    target = broken.limit * (1.0 + ROUNDING)
    order = broken.orders.order(chosen)
    total = broken.least(chosen)
    while total > target and order:
        k, relief = _best_relief(order, broken, points)
        order = tuple(one for one in order if one != k)
        chosen &= ~(1 << k - 1)
        total -= relief
    return chosen


def _without(chosen: int, limit: Limit, points: Sequence[TourPoint]) -> int:
    k, _ = _best_relief(limit.orders.order(chosen), limit, points)
    return chosen & ~(1 << k - 1)


def _best_relief(
    order: tuple[int, ...], limit: Limit, points: Sequence[TourPoint]
) -> tuple[int, float]:
    """Return the point to leave out, which saves most relative to its priority, and the saving."""
    whole = trip_cost(limit.costs, order)
    saved = [
        whole
        - trip_cost(limit.costs, tuple(one for one in order if one != k))
        + float(limit.dwells[k - 1])
        for k in order
    ]
    best = max(range(len(order)), key=lambda n: saved[n] / points[order[n] - 1].priority)
    return order[best], saved[best]


def _refilled(chosen: int, limits: Sequence[Limit], points: Sequence[TourPoint]) -> int:
    """Return the set with the points that fit in addition, the worthiest first."""
    missing = [k for k in range(len(points)) if not chosen >> k & 1]
    for k in sorted(missing, key=lambda one: -points[one].priority):
        if all(one.fits(chosen | 1 << k) for one in limits):
            chosen |= 1 << k
    return chosen
