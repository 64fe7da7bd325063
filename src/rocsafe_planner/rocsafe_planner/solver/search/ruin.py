# SPDX-License-Identifier: Apache-2.0
"""Ruin and recreate: strings of neighbouring routes are removed and inserted greedily.

Slack induction by string removals (Christiaens and Vanden Berghe, Transportation Science 54,
2020), with insertion beside near neighbours only, so that a step costs the same at any size.
"""

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, Word, inlined, inner
from rocsafe_planner.solver.model.randomness import GOLDEN, below, draw, scramble
from rocsafe_planner.solver.model.tables import Tables, Words, leg
from rocsafe_planner.solver.search.moves import Goal, energy
from rocsafe_planner.solver.search.state import State, refill, relink, settle

LONGEST_STRING = 10
MOST_STRINGS = 6


@inlined
def site_before(tables: Tables, place: int, route: int) -> int:
    """Return the site of a predecessor: a customer, or the start of its route."""
    return place if place < len(tables.needs) else Long(tables.first[route])


@inlined
def site_behind(tables: Tables, place: int, route: int) -> int:
    """Return the site of a successor: a customer, or the end of its route."""
    return place if place < len(tables.needs) else Long(tables.last[route])


@inner
def take_string(
    tables: Tables, state: State, customer: int, size: int, offset: int, taken: int
) -> int:
    """Remove a string around a customer from its route; return the number removed until now."""
    route = Long(state.route[customer])
    stride = len(state.node) // len(state.length)
    row = route * stride
    length = Long(state.length[route])
    size = min(size, length)
    low = min(max(1, state.place[customer] - offset % size), length - size + 1)
    high = low + size - 1
    for k in range(low, high + 1):
        state.spare[taken + k - low] = state.node[row + k]
        state.route[state.node[row + k]] = -1
    prior = Long(state.before[state.node[row + low]])
    later = Long(state.after[state.node[row + high]])
    state.after[prior] = later
    state.before[later] = prior
    left, right = Long(state.node[row + low - 1]), Long(state.node[row + high + 1])
    empty = size == length
    state.trial[2, route] = 1.0
    for kind in range(2):
        if kind == 1 and not tables.limited:
            break
        c = Long(tables.measure[route]) if kind == 0 else Long(tables.limit_measure[route])
        base = c * len(state.node) + row
        path = state.ahead[base + length + 1] - state.ahead[base + high + 1]
        path += state.ahead[base + low - 1] + leg(tables, c, left, right)
        if kind == 0:
            state.trial[0, route] = tables.idle[route] if empty else tables.fixed[route] + path
        else:
            state.trial[1, route] = 0.0 if empty else path
    return taken + size


@inlined
def detour(tables: Tables, c: int, left: int, customer: int, right: int) -> float:
    """Return the cost of a detour to a customer between two sites."""
    return (
        leg(tables, c, left, customer)
        + leg(tables, c, customer, right)
        - leg(tables, c, left, right)
    )


@inlined
def joined(
    tables: Tables, state: State, route: int, left: int, customer: int, right: int
) -> tuple[float, float]:
    """Return cost and load of a trial route with a customer between two neighbours."""
    n = len(tables.needs)
    prior, later = site_before(tables, left, route), site_behind(tables, right, route)
    c = Long(tables.measure[route])
    used = 0.0
    if left >= n and right >= n:
        cost = (
            tables.fixed[route] + leg(tables, c, prior, customer) + leg(tables, c, customer, later)
        )
        if tables.limited:
            c = Long(tables.limit_measure[route])
            used = leg(tables, c, prior, customer) + leg(tables, c, customer, later)
        return cost, used
    cost = state.trial[0, route] + detour(tables, c, prior, customer, later)
    if tables.limited:
        c = Long(tables.limit_measure[route])
        used = state.trial[1, route] + detour(tables, c, prior, customer, later)
    return cost, used


@inner
def insert(tables: Tables, state: State, goal: Goal, customer: int, random: Words) -> bool:
    """Insert a customer beside the near neighbour where the energy rises least."""
    n, near = tables.near.shape
    m = len(state.length)
    best, best_left, best_route = np.inf, Long(-1), Long(-1)
    random[0] += GOLDEN
    blinks = scramble(random[0])
    some = below(blinks >> Word(32), m)
    for k in range(2 * near + 2):
        if k < 2 * near:
            j = tables.near[customer, k >> 1]
            route = Long(state.route[j])
            if route < 0:
                continue
            left = Long(j if k & 1 else state.before[j])
        else:
            route = some
            left = Long(n + some if k & 1 else state.before[n + some])
        if tables.restricted and tables.needs[customer] & tables.ability[route] == 0:
            continue
        if (blinks >> Word(k & 31)) & Word(63) == 0:
            continue
        right = Long(state.after[left])
        cost, used = joined(tables, state, route, left, customer, right)
        rise = energy(tables, goal, route, cost, used) - energy(
            tables, goal, route, state.trial[0, route], state.trial[1, route]
        )
        if rise < best:
            best, best_left, best_route = rise, left, route
    if best_route < 0:
        return False
    link(tables, state, customer, best_left, best_route)
    return True


@inner
def link(tables: Tables, state: State, customer: int, left: int, route: int) -> None:
    """Insert a customer after another, or after the start, of a trial route."""
    right = Long(state.after[left])
    cost, used = joined(tables, state, route, left, customer, right)
    state.trial[0, route], state.trial[1, route] = cost, used
    state.trial[2, route] = 1.0
    state.after[left] = customer
    state.before[customer] = left
    state.after[customer] = right
    state.before[right] = customer
    state.route[customer] = route


@inner
def insert_at_end(tables: Tables, state: State, goal: Goal, customer: int) -> None:
    """Insert a customer at the end of the allowed route whose energy then rises least."""
    n = len(tables.needs)
    best, best_route = np.inf, Long(0)
    for r in range(len(state.length)):
        if tables.needs[customer] & tables.ability[r] == 0:
            continue
        left = Long(state.before[n + r])
        cost, used = joined(tables, state, r, left, customer, n + r)
        rise = energy(tables, goal, r, cost, used)
        rise -= energy(tables, goal, r, state.trial[0, r], state.trial[1, r])
        if rise < best:
            best, best_route = rise, r
    link(tables, state, customer, Long(state.before[n + best_route]), best_route)


@inner
def adopt(tables: Tables, state: State, route: int) -> None:
    """Set the slots of a route from its links."""
    n = len(tables.needs)
    row = route * (len(state.node) // len(state.length))
    k = 0
    customer = Long(state.after[n + route])
    while customer < n:
        k += 1
        state.node[row + k] = customer
        customer = Long(state.after[customer])
    state.length[route] = k
    state.node[row + k + 1] = Long(tables.last[route])
    refill(tables, state, route)
    settle(tables, state, route)


@inlined
def begin_trial(state: State) -> None:
    """Copy all routes to trial routes, and bring their links up to date."""
    for r in range(len(state.length)):
        if state.unlinked[r] != 0:
            relink(state, r)
        state.trial[0, r] = state.cost[r]
        state.trial[1, r] = state.load[r]
        state.trial[2, r] = 0.0


@inlined
def take_strings(tables: Tables, state: State, random: Words) -> int:
    """Remove strings of customers around a random one; return the number of customers."""
    n, near = tables.near.shape
    seed = draw(random, n)
    strings = 1 + draw(random, Long(MOST_STRINGS))
    longest = 1 + draw(random, Long(LONGEST_STRING))
    taken, hit = Long(0), 0
    for k in range(-1, near):
        customer = seed if k < 0 else Long(tables.near[seed, k])
        route = Long(state.route[customer])
        if route < 0 or state.trial[2, route] != 0.0:
            continue
        size = 1 + draw(random, longest)
        taken = take_string(tables, state, customer, size, draw(random, size), taken)
        hit += 1
        if hit == strings:
            break
    return taken


@inlined
def trial_rise(tables: Tables, state: State, goal: Goal) -> float:
    """Return the increase of the energy by the trial routes."""
    rise = 0.0
    for r in range(len(state.length)):
        if state.trial[2, r] != 0.0:
            rise += energy(tables, goal, r, state.trial[0, r], state.trial[1, r])
            rise -= energy(tables, goal, r, state.cost[r], state.load[r])
    return rise


@inlined
def adopt_trial(tables: Tables, state: State) -> None:
    """Replace the present routes by the trial routes."""
    for r in range(len(state.length)):
        if state.trial[2, r] != 0.0:
            adopt(tables, state, r)


@inlined
def forget_trial(state: State) -> None:
    """Discard the trial routes."""
    for r in range(len(state.length)):
        if state.trial[2, r] != 0.0:
            relink(state, r)


@inner
def ruin(tables: Tables, state: State, goal: Goal, random: Words, bar: float) -> bool:
    """Remove strings around a random customer, insert them again, keep an accepted result."""
    begin_trial(state)
    taken = take_strings(tables, state, random)
    shuffle(tables, state, taken, random)
    complete = True
    for k in range(taken):
        if not insert(tables, state, goal, Long(state.spare[k]), random):
            complete = False
            break
    keep = complete and trial_rise(tables, state, goal) <= bar
    if keep:
        adopt_trial(tables, state)
    else:
        forget_trial(state)
    return keep


@inner
def shuffle(tables: Tables, state: State, taken: int, random: Words) -> None:
    """Sort the removed customers at random, or, half of the time, far or near ones first."""
    for k in range(taken - 1, 0, -1):
        j = draw(random, k + 1)
        state.spare[k], state.spare[j] = state.spare[j], state.spare[k]
    way = draw(random, Long(7))
    if way > 2:
        return
    sign = -1.0 if way < 2 else 1.0
    depot = Long(tables.first[0])
    for k in range(1, taken):
        customer = Long(state.spare[k])
        key = sign * leg(tables, Long(0), depot, customer)
        j = k - 1
        while j >= 0 and sign * leg(tables, Long(0), depot, Long(state.spare[j])) > key:
            state.spare[j + 1] = state.spare[j]
            j -= 1
        state.spare[j + 1] = customer
