# SPDX-License-Identifier: Apache-2.0
"""Pareto-optimal choices of ways along an order of points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_ground.route.constrained import ROUNDING
from rocsafe_ground.route.edges import GridPath

# More partial choices are thinned out: the fastest and the cleanest stay.
MOST_CHOICES = 1000

Legs = tuple[GridPath, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Choices:
    """Choices of a way for each leg of an order.

    Attributes
    ----------
    costs : (n, 3)
        Time, dose and load, the fastest first.
    options
        Ways of each leg.
    steps
        For each leg, the choice of the legs before it and the way taken, (n,) each.
    """

    costs: FloatArray
    options: Sequence[Sequence[GridPath]]
    steps: Sequence[tuple[IndexArray, IndexArray]]

    def legs(self, number: int) -> Legs:
        """Return the ways of a choice, the first one first."""
        found = []
        for (before, way), ways in zip(reversed(self.steps), reversed(self.options), strict=True):
            found.append(ways[int(way[number])])
            number = int(before[number])
        return tuple(reversed(found))


def joined(options: Sequence[Sequence[GridPath]], room: tuple[float, float]) -> Choices:
    """Return choices of a way for each leg within the room for dose and load, the fastest first.

    Choices that another is no worse than in time, dose and load are dropped.
    """
    limits = np.array([np.inf, *room]) * (1.0 + ROUNDING)
    costs = np.zeros((1, 3))
    steps = []
    for ways in options:
        own = np.array([(way.time_s, way.dose_usv, way.load) for way in ways])
        sums = (costs[:, None] + own[None]).reshape(-1, 3)
        fitting = np.flatnonzero((sums <= limits).all(axis=1))
        kept = fitting[_undominated(sums[fitting])]
        if len(kept) > MOST_CHOICES:
            kept = kept[np.linspace(0, len(kept) - 1, MOST_CHOICES).round().astype(np.int64)]
        costs = sums[kept]
        steps.append((kept // len(ways), kept % len(ways)))
    return Choices(costs=costs, options=options, steps=steps)


def _undominated(costs: FloatArray) -> IndexArray:
    """Return the numbers of rows that no other row is as good as in everything, fastest first."""
    order = np.lexsort((costs[:, 2], costs[:, 1], costs[:, 0]))
    doses, loads = costs[order, 1], costs[order, 2]
    if not loads.any():
        before = np.minimum.accumulate(np.concatenate([[np.inf], doses]))[:-1]
        return np.asarray(order[doses < before])
    front: list[tuple[float, float]] = []
    kept = []
    for number, dose, load in zip(order.tolist(), doses.tolist(), loads.tolist(), strict=True):
        if not any(d <= dose and x <= load for d, x in front):
            front = [(d, x) for d, x in front if d < dose or x < load]
            front.append((dose, load))
            kept.append(number)
    return np.array(kept, np.int64)
