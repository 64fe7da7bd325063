# SPDX-License-Identifier: Apache-2.0
"""Split of a sequence of the customers into routes such that the costliest is cheapest."""

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, inner, kernel
from rocsafe_planner.solver.model.tables import Ints, Tables, leg
from rocsafe_planner.solver.search.state import path_cost

BISECTIONS = 50


@inner
def fill(tables: Tables, order: Ints, turn: Ints, cap: float, lengths: Ints) -> bool:
    """Give each vehicle in turn the longest part of the sequence whose cost is within `cap`."""
    n, taken = len(order), 0
    for vehicle in turn:
        r = Long(vehicle)
        c = Long(tables.measure[r])
        here = Long(tables.first[r])
        path = 0.0
        best = taken
        k = taken
        while k < n:
            customer = Long(order[k])
            if tables.needs[customer] & tables.ability[r] == 0:
                break
            path += leg(tables, c, here, customer)
            here = customer
            k += 1
            closed = path + leg(tables, c, here, Long(tables.last[r]))
            if path_cost(tables, r, k - taken, closed) <= cap:
                best = k
            elif path > 2.0 * cap:
                break
        lengths[r] = best - taken
        taken = best
    return taken == n


@inner
def whole(tables: Tables, order: Ints) -> float:
    """Return a cost that no part of a sequence exceeds for any vehicle."""
    most = 0.0
    for r in range(len(tables.first)):
        c = Long(tables.measure[r])
        path = 0.0
        far = 0.0
        for k in range(len(order)):
            customer = Long(order[k])
            far = max(far, leg(tables, c, Long(tables.first[r]), customer))
            far = max(far, leg(tables, c, customer, Long(tables.last[r])))
            if k > 0:
                path += leg(tables, c, Long(order[k - 1]), customer)
        most = max(most, tables.fixed[r] + path + 2 * far)
    return most


@kernel
def split(tables: Tables, order: Ints, turn: Ints, lengths: Ints) -> float:
    """Split a sequence into consecutive routes, one per vehicle, with the least greatest cost.

    Exact to one part in 2**50 for equal vehicles and metric legs, where a longer part never costs
    less; otherwise a good cut. Writes the lengths; returns the greatest cost allowed, or infinity
    if the vehicles, in this order, may not serve the customers, in this order.
    """
    low, high = 0.0, whole(tables, order)
    if not fill(tables, order, turn, high, lengths):
        return np.inf
    for _ in range(BISECTIONS):
        cap = 0.5 * (low + high)
        if fill(tables, order, turn, cap, lengths):
            high = cap
        else:
            low = cap
    fill(tables, order, turn, high, lengths)
    return high
