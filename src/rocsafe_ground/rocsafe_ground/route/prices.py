# SPDX-License-Identifier: Apache-2.0
"""Prices of dose and toxic load by the trips that are known (cutting planes, Kelley 1960)."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linprog

# Largest price, in times of the quickest trip for all of a budget: beyond it nothing fits.
LARGEST_PRICE = 1e6

Costs = tuple[float, float, float]


def best_prices(
    trips: Sequence[Costs], room: Sequence[float]
) -> tuple[tuple[float, float], float]:
    """Return the prices of dose and load with the highest bound, and that bound.

    The bound of a price is the minimum of time + price * (cost of a trip - room) over all known
    trips. A price whose room is infinite is 0.

    Parameters
    ----------
    trips
        Time, dose and load of each trip.
    room
        What a trip may take of dose and of load.

    Returns
    -------
    prices
        Seconds a microsievert, seconds a load.
    level
        The bound by the trips known, seconds: no bound at these prices is above it.
    """
    costs = np.array(trips)
    time = max(float(costs[:, 0].max()), 1e-9)
    limited = [k for k in (0, 1) if np.isfinite(room[k])]
    over = costs[:, [k + 1 for k in limited]] - np.array([room[k] for k in limited])
    scale = np.maximum(np.abs(over).max(axis=0), 1e-300)
    # Maximise the level: level - price * over <= time, all in units of `time` and `scale`.
    rows = np.column_stack([np.ones(len(costs)), -over / scale])
    found = linprog(
        [-1.0, *[0.0] * len(limited)],
        A_ub=rows,
        b_ub=costs[:, 0] / time,
        bounds=[(None, None), *[(0.0, LARGEST_PRICE)] * len(limited)],
    )
    prices = [0.0, 0.0]
    for k, value, size in zip(limited, found.x[1:], scale, strict=True):
        prices[k] = float(value) * time / float(size)
    return (prices[0], prices[1]), float(found.x[0]) * time
