# SPDX-License-Identifier: Apache-2.0
"""Walks over priced customers in steps of time: the most that is collected by each moment."""

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, kernel
from rocsafe_planner.solver.model.tables import Floats, Ints

NOTHING = -1e18
"""Prize of a walk that does not exist."""
FROM_START = -1
"""Predecessor of the first customer of a walk."""
NO_FLIGHT = 0
"""Steps of a flight that is not flown."""


@kernel
def collect(  # noqa: C901 - one loop over moments, customers and their predecessors
    legs: Ints,
    first: Ints,
    last: Ints,
    price: Floats,
    best: Floats,
    before: Ints,
    second: Floats,
    before_second: Ints,
    collected: Floats,
) -> None:
    """Find, for each moment and customer, the walk that ends there with the highest prize.

    A walk may visit a customer again, and collect again, but not at once (i, j, i).

    Parameters
    ----------
    legs : (n, n)
        Steps from one customer to the next, at least 1 between two.
    first, last : (n,)
        Steps to a first customer, and from a last one to the end.
    price : (n,)
        Price of each customer.
    best, before : (steps + 1, n)
        Written: the prize, and the customer visited before.
    second, before_second : (steps + 1, n)
        Written: the same of the best walk with another customer before.
    collected : (steps + 1,)
        Written: the highest prize of a walk that has reached its end by each moment, at least 0.
    """
    n, moments = len(first), len(collected)
    for t in range(moments):
        collected[t] = 0.0
    for t in range(moments):
        for i in range(n):
            top, other, top_from, other_from = NOTHING, NOTHING, -2, -2
            if first[i] == t:
                top, top_from = price[i], FROM_START
            # Rounded legs know no triangle inequality: what is far may be near by another way.
            for j in range(n):
                s = Long(t - legs[j, i])
                if s < 0 or j == i:
                    continue
                prize = second[s, j] if before[s, j] == i else best[s, j]
                prize += price[i]
                if prize > top:
                    other, other_from = top, top_from
                    top, top_from = prize, j
                elif prize > other:
                    other, other_from = prize, j
            end = Long(t + last[i])
            if end < moments:
                collected[end] = max(collected[end], top)
            best[t, i], before[t, i] = top, top_from
            second[t, i], before_second[t, i] = other, other_from
    for t in range(1, moments):
        collected[t] = max(collected[t], collected[t - 1])


@kernel
def count_visits(
    legs: Ints, before: Ints, before_second: Ints, ends: Ints, times: Ints, visits: Ints
) -> None:
    """Count how often each of some best walks visits each customer.

    Parameters
    ----------
    legs, before, before_second
        As in `collect`.
    ends, times : (k,)
        Last customer of each walk, and when it is there.
    visits : (k, n)
        Written.
    """
    for k in range(len(ends)):
        for i in range(visits.shape[1]):
            visits[k, i] = 0
        i, t, after = Long(ends[k]), Long(times[k]), Long(-3)
        while i >= 0:
            visits[k, i] += 1
            earlier = Long(before[t, i])
            if earlier == after:
                earlier = Long(before_second[t, i])
            if earlier >= 0:
                t -= Long(legs[earlier, i])
            after, i = i, earlier


@kernel
def chain_flights(
    alone: Floats, before: Floats, further: Floats, change: int, best: Floats, flown: Ints
) -> None:
    """Find the most that is collected by each moment, with or without one flight more at the end.

    Parameters
    ----------
    alone : (steps + 1,)
        The most that is collected without that flight.
    before : (steps + 1,)
        The most that is collected before it; `best` itself: any number of such flights.
    further : (steps + 1,)
        The most that it collects in so many steps.
    change
        Steps of the change before it.
    best : (steps + 1,)
        Written.
    flown : (steps + 1,)
        Written: its steps, `NO_FLIGHT` without it.
    """
    for t in range(len(best)):
        best[t], flown[t] = alone[t], NO_FLIGHT
        for s in range(1, t - change + 1):
            collected = before[t - change - s] + further[s]
            if collected > best[t]:
                best[t], flown[t] = collected, s


@kernel
def find_corners(values: Floats, corners: Ints) -> int:
    """Find the corners of the least concave function that is nowhere less than some values.

    Parameters
    ----------
    values : (n,)
        At equal intervals.
    corners : (n,)
        Written: the numbers of those at the corners, ascending.

    Returns
    -------
    How many there are.
    """
    count = 0
    for i in range(len(values)):
        while count > 1:
            a, b = Long(corners[count - 2]), Long(corners[count - 1])
            if (values[b] - values[a]) * (i - a) > (values[i] - values[a]) * (b - a):
                break
            count -= 1
        corners[count] = i
        count += 1
    return count


def best_ends(best: Floats, last: Ints, steps: int, most: int) -> tuple[Ints, Ints]:
    """Return last customers and times of the best walks that are done by `steps`."""
    best = best[: steps + 1]
    moments = np.arange(len(best))
    in_time = moments[:, None] + last[None, :] <= steps
    prizes = np.where(in_time, best, NOTHING)
    times = prizes.argmax(axis=0)
    tops = prizes[times, np.arange(len(last))]
    order = np.argsort(-tops, kind='stable')[:most]
    order = order[tops[order] > 0.0]
    return order.astype(np.int32), times[order].astype(np.int32)
