# SPDX-License-Identifier: Apache-2.0
"""The cheapest round trip through every set of points, exactly."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_ground.tour.order_kernels import best_orders

MOST_POINTS = 12
"""More points take tables of more than 2 ** 12 sets: another method."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RoundTrips:
    """The cheapest round trip through each set of points; bit k of a set is point k + 1.

    Attributes
    ----------
    costs, times_s, doses_usv : (sets,)
        Infinite where there is none; set 0 costs nothing.
    """

    costs: FloatArray
    times_s: FloatArray
    doses_usv: FloatArray
    _last: IndexArray
    _before: IndexArray

    def order(self, chosen: int) -> tuple[int, ...]:
        """Return the points of the trip through a set, from 1, in their order."""
        found, last = [], int(self._last[chosen])
        while chosen:
            found.append(last + 1)
            before = int(self._before[chosen, last])
            chosen, last = chosen & ~(1 << last), before
        return tuple(reversed(found))


def round_trips(times_s: FloatArray, doses_usv: FloatArray, price: float) -> RoundTrips:
    """Return the round trips with the least time and price times dose.

    Parameters
    ----------
    times_s, doses_usv : (points + 1, points + 1)
        Of the way from row to column, 0 is the start; infinite where there is none.
    price
        Seconds a microsievert; infinite: only dose counts.
    """
    points = len(times_s) - 1
    if points > MOST_POINTS:
        raise ValueError(f'points = {points}: must be at most {MOST_POINTS}')
    costs = doses_usv if math.isinf(price) else times_s + price * doses_usv
    shape = (1 << points, points)
    table = (
        np.full(shape, math.inf), np.full(shape, math.inf), np.full(shape, math.inf),
        np.full(shape, -1, np.int64),
    )  # fmt: skip
    best_orders(np.ascontiguousarray(costs), (times_s, doses_usv), table)
    closed = table[0] + costs[1:, 0]
    last = closed.argmin(axis=1)
    sets = np.arange(1 << points)
    total = [
        closed[sets, last],
        table[1][sets, last] + times_s[last + 1, 0],
        table[2][sets, last] + doses_usv[last + 1, 0],
    ]
    for values in total:
        values[0] = 0.0
    return RoundTrips(
        costs=total[0], times_s=total[1], doses_usv=total[2], _last=last, _before=table[3]
    )
