# SPDX-License-Identifier: Apache-2.0
"""Changes of routes, described by slots, evaluated in constant and made in linear time.

Every move is one or two `Change`s: a window of a route replaced by at most two pieces of routes.
That covers 2-opt (one reversed piece), Or-opt (two pieces of the same route), relocation and swap
of segments, and the two ways of recombining two routes, whatever the measures and ends of the
routes.
"""

from typing import NamedTuple

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, inlined, inner
from rocsafe_planner.solver.model.tables import Tables, leg
from rocsafe_planner.solver.search.state import State, path_cost, refill, settle, slide


class Piece(NamedTuple):
    """Slots low .. high of a route, reversed if turned; empty if high < low."""

    route: int
    low: int
    high: int
    turned: bool


class Change(NamedTuple):
    """A route and its slots low .. high (none: high = low - 1), which two pieces replace."""

    route: int
    low: int
    high: int
    first: Piece
    second: Piece


class Goal(NamedTuple):
    """The minimised energy: the sum of the costs, and penalties of long routes."""

    target: float
    """Cost above which a route is penalised."""
    floor: float
    """Worth of each unit of cost."""
    steepness: float
    """Penalty for each unit of cost above the target."""
    curvature: float
    """Penalty for each squared unit of cost above the target."""
    vacancy: float
    """Penalty for leaving a route empty."""
    strictness: float
    """Penalty for each unit of consumption above a route's limit."""


@inlined
def energy(tables: Tables, goal: Goal, route: int, cost: float, load: float) -> float:
    """Return the energy of a route of this cost and load."""
    over = max(0.0, cost - goal.target)
    value = goal.floor * cost + over * (goal.steepness + goal.curvature * over)
    if tables.limited:
        value += goal.strictness * max(0.0, load - tables.limit[route])
    return value


@inlined
def row_of(state: State, route: int) -> int:
    """Return the index of a route's first slot in `node`."""
    return route * (len(state.node) // len(state.length))


@inlined
def piece_path(
    tables: Tables, state: State, measure: int, piece: Piece, path: float, here: int
) -> tuple[float, int]:
    """Return the cost and last site of a path to which a piece is appended."""
    if piece.high < piece.low:
        return path, here
    row = row_of(state, piece.route)
    base = measure * len(state.node) + row
    low, high = np.uint64(row + piece.low), np.uint64(row + piece.high)
    from_low, to_high = np.uint64(base + piece.low), np.uint64(base + piece.high)
    if piece.turned:
        path += leg(tables, measure, here, Long(state.node[high]))
        return path + (state.back[to_high] - state.back[from_low]), Long(state.node[low])
    path += leg(tables, measure, here, Long(state.node[low]))
    return path + (state.ahead[to_high] - state.ahead[from_low]), Long(state.node[high])


@inlined
def changed_path(tables: Tables, state: State, measure: int, change: Change) -> float:
    """Return the cost of a route's legs under a measure after the change."""
    row = row_of(state, change.route)
    base = measure * len(state.node) + row
    end = np.uint64(base + state.length[change.route] + 1)
    path = state.ahead[np.uint64(base + change.low - 1)] + (
        state.ahead[end] - state.ahead[np.uint64(base + change.high + 1)]
    )
    here = Long(state.node[np.uint64(row + change.low - 1)])
    path, here = piece_path(tables, state, measure, change.first, path, here)
    path, here = piece_path(tables, state, measure, change.second, path, here)
    last = Long(state.node[np.uint64(row + change.high + 1)])
    return path + leg(tables, measure, here, last)


@inlined
def size_of(piece: Piece) -> int:
    """Return the number of slots of a piece."""
    return max(0, piece.high - piece.low + 1)


@inlined
def rise(tables: Tables, state: State, goal: Goal, change: Change) -> float:
    """Return the increase of the energy by a change."""
    route = change.route
    customers = Long(state.length[route]) - (change.high - change.low + 1)
    customers += size_of(change.first) + size_of(change.second)
    path = changed_path(tables, state, Long(tables.measure[route]), change)
    used = 0.0
    if tables.limited and customers:
        used = changed_path(tables, state, Long(tables.limit_measure[route]), change)
    value = energy(tables, goal, route, path_cost(tables, route, customers, path), used) - energy(
        tables, goal, route, state.cost[route], state.load[route]
    )
    return value + (goal.vacancy if customers == 0 else 0.0)


@inner
def serves(tables: Tables, state: State, route: int, piece: Piece) -> bool:
    """Return whether a route's vehicle may serve a piece.

    A piece that is neither the head nor the tail of its route is checked slot by slot: moves
    keep such pieces short.
    """
    if piece.high < piece.low or piece.route == route or route < 0:
        return True
    row = row_of(state, piece.route)
    ability = tables.ability[route]
    if piece.low == 1:
        return ability & state.heads[row + piece.high] != 0
    if piece.high == state.length[piece.route]:
        return ability & state.tails[row + piece.low] != 0
    for k in range(piece.low, piece.high + 1):
        if ability & tables.needs[state.node[row + k]] == 0:
            return False
    return True


@inlined
def allowed(tables: Tables, state: State, change: Change) -> bool:
    """Return whether the vehicle of a changed route may serve the new customers."""
    return serves(tables, state, change.route, change.first) and serves(
        tables, state, change.route, change.second
    )


@inner
def gather(state: State, change: Change, taken: int) -> int:
    """Copy the nodes of a change's pieces to `spare` from `taken` on; return where they end."""
    for piece in (change.first, change.second):
        row = row_of(state, piece.route)
        for k in range(size_of(piece)):
            slot = piece.high - k if piece.turned else piece.low + k
            state.spare[taken + k] = state.node[row + slot]
        taken += size_of(piece)
    return taken


@inner
def place(tables: Tables, state: State, change: Change, source: int, size: int) -> None:
    """Replace a change's window by `size` nodes of `spare` from `source` on."""
    by = size - (change.high - change.low + 1)
    if by != 0:
        slide(tables, state, change.route, change.high + 1, by)
    row = row_of(state, change.route)
    for k in range(size):
        state.node[row + change.low + k] = state.spare[source + k]
    refill(tables, state, change.route, change.low, change.low + size)
    settle(tables, state, change.route)


@inner
def make(tables: Tables, state: State, one: Change, other: Change) -> None:
    """Make two changes by which routes exchange pieces; the second may change nothing."""
    middle = gather(state, one, Long(0))
    total = gather(state, other, middle)
    for change, source, beyond in ((one, 0, middle), (other, middle, total)):
        if change.route >= 0:
            place(tables, state, change, source, beyond - source)
