# SPDX-License-Identifier: Apache-2.0
"""The routes of a search as flat arrays, with all partial costs."""

from typing import NamedTuple

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, inlined, inner, kernel
from rocsafe_planner.solver.model.tables import Floats, Ints, Tables, Words, leg

ALL = np.uint64(0xFFFFFFFFFFFFFFFF)


class State(NamedTuple):
    """Routes of a search; route r fills the slots r*stride .. r*stride + length[r] + 1.

    The first and last slot of a route hold its ends. With C measures, the partial costs of measure
    c lie `c * m * stride` further on.
    """

    node: Ints
    """Site in each slot."""
    length: Ints
    """(m,) customers of each route."""
    route: Ints
    """(n,) route that serves each customer."""
    place: Ints
    """(n,) slot of each customer within its route, from 1."""
    ahead: Floats
    """Cost from the route's start to each slot, for every measure."""
    back: Floats
    """Cost from each slot back to the start, flown in reverse; `ahead` itself when symmetric."""
    heads: Words
    """Abilities that serve everybody up to a slot (restricted problems only)."""
    tails: Words
    """Abilities that serve everybody from a slot on (restricted problems only)."""
    cost: Floats
    """(m,) cost of each route as the objective sees it."""
    load: Floats
    """(m,) consumption of each route as its limit sees it."""
    after: Ints
    """(n + m,) what follows each customer, and each route's start n + r; n + r means its end."""
    before: Ints
    """(n + m,) what precedes each customer, and each route's end n + r; n + r means its start."""
    unlinked: Ints
    """(m,) 1 for routes whose `after` and `before` are those of earlier slots; see `relink`."""
    trial: Floats
    """(3, m) cost and load of routes on trial, and 1 for those that differ from the slots."""
    spare: Ints
    """Room for nodes on the move."""
    spare_ahead: Floats
    """Room for their partial costs, for every measure."""
    spare_back: Floats
    """The same of `back`; `spare_ahead` itself when symmetric."""


def empty_state(tables: Tables) -> State:
    """Return a state of empty routes with room for every customer in any of them."""
    n, m = len(tables.needs), len(tables.first)
    stride, measures = n + 2, len(tables.stay)
    ahead = np.zeros(measures * m * stride)
    masks = m * stride if tables.restricted else 1
    spare_ahead = np.zeros(measures * 2 * stride)
    return State(
        node=np.zeros(m * stride, np.int32),
        length=np.zeros(m, np.int32),
        route=np.zeros(n, np.int32),
        place=np.zeros(n, np.int32),
        ahead=ahead,
        back=ahead if tables.symmetric else np.zeros_like(ahead),
        heads=np.zeros(masks, np.uint64),
        tails=np.zeros(masks, np.uint64),
        cost=np.zeros(m),
        load=np.zeros(m),
        after=np.zeros(n + m, np.int32),
        before=np.zeros(n + m, np.int32),
        unlinked=np.zeros(m, np.int32),
        trial=np.zeros((3, m)),
        spare=np.zeros(2 * stride, np.int32),
        spare_ahead=spare_ahead,
        spare_back=spare_ahead if tables.symmetric else np.zeros_like(spare_ahead),
    )


@inlined
def path_cost(tables: Tables, route: int, customers: int, path: float) -> float:
    """Return the cost of a route from the cost of its legs."""
    if customers == 0:
        return tables.idle[route]
    return tables.fixed[route] + path


@inner
def refill(tables: Tables, state: State, route: int) -> None:
    """Set places, links and partial costs of a route from its slots."""
    stride = len(state.node) // len(state.length)
    row = route * stride
    end = Long(state.length[route]) + 1
    for k in range(1, end):
        state.place[state.node[row + k]] = k
    relink(state, route)
    for c in range(tables.stay.shape[0]):
        base = c * len(state.node) + row
        for k in range(1, end + 1):
            way = leg(tables, c, Long(state.node[row + k - 1]), Long(state.node[row + k]))
            state.ahead[base + k] = state.ahead[base + k - 1] + way
        if tables.symmetric:
            continue
        for k in range(1, end + 1):
            way = leg(tables, c, Long(state.node[row + k]), Long(state.node[row + k - 1]))
            state.back[base + k] = state.back[base + k - 1] + way


@inner
def relink(state: State, route: int) -> None:
    """Set the links of a route, and which route its customers have, from its slots."""
    n = len(state.route)
    row = route * (len(state.node) // len(state.length))
    previous = n + route
    for k in range(1, state.length[route] + 1):
        customer = Long(state.node[row + k])
        state.route[customer] = route
        state.before[customer] = previous
        state.after[previous] = customer
        previous = customer
    state.after[previous] = n + route
    state.before[n + route] = previous
    state.unlinked[route] = 0


@inner
def remask(tables: Tables, state: State, route: int) -> None:
    """Compute the ability masks of a whole route from `node`."""
    stride = len(state.node) // len(state.length)
    row = route * stride
    end = state.length[route] + 1
    mask = ALL
    state.heads[row] = mask
    for k in range(1, end):
        mask &= tables.needs[state.node[row + k]]
        state.heads[row + k] = mask
    state.heads[row + end] = mask
    mask = ALL
    state.tails[row + end] = mask
    for k in range(end - 1, 0, -1):
        mask &= tables.needs[state.node[row + k]]
        state.tails[row + k] = mask
    state.tails[row] = mask


@inlined
def settle(tables: Tables, state: State, route: int) -> None:
    """Set the cost and load of a route from its partial costs."""
    m = len(state.length)
    stride = len(state.node) // m
    last = route * stride + state.length[route] + 1
    customers = Long(state.length[route])
    path = state.ahead[Long(tables.measure[route]) * m * stride + last]
    state.cost[route] = path_cost(tables, route, customers, path)
    if tables.limited:
        used = state.ahead[Long(tables.limit_measure[route]) * m * stride + last]
        state.load[route] = used if customers else 0.0
    if tables.restricted:
        remask(tables, state, route)


@kernel
def load(tables: Tables, state: State, order: Ints, lengths: Ints) -> None:
    """Set the routes: `order` lists the customers of route 0, then of route 1, and so on."""
    m = len(state.length)
    stride = len(state.node) // m
    taken = 0
    for r in range(m):
        row = r * stride
        size = Long(lengths[r])
        state.length[r] = size
        state.node[row] = Long(tables.first[r])
        for k in range(size):
            state.node[row + 1 + k] = order[taken + k]
        state.node[row + size + 1] = Long(tables.last[r])
        taken += size
        refill(tables, state, r)
        settle(tables, state, r)


@inner
def unload(state: State, order: Ints, lengths: Ints) -> None:
    """Write the routes into `order` and `lengths`, as `load` reads them."""
    m = len(state.length)
    stride = len(state.node) // m
    taken = 0
    for r in range(m):
        lengths[r] = state.length[r]
        for k in range(state.length[r]):
            order[taken + k] = state.node[r * stride + 1 + k]
        taken += state.length[r]
