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
from rocsafe_planner.solver.model.tables import Floats, Tables, leg
from rocsafe_planner.solver.search.state import State, path_cost, settle


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


@inlined
def tail(state: State, change: Change) -> Piece:
    """Return the slots after a change's window, with the end, that it moves; empty: none."""
    size = size_of(change.first) + size_of(change.second)
    stays = size == change.high - change.low + 1
    end = change.high if stays else Long(state.length[change.route]) + 1
    return Piece(change.route, change.high + 1, end, False)


@inner
def gather(tables: Tables, state: State, piece: Piece, taken: int) -> int:
    """Copy the nodes of a piece to `spare` from `taken` on; return where they end.

    Partial costs are copied, too, from its first node on: the legs within it stay the same.
    """
    size = size_of(piece)
    if size == 0:
        return taken
    row = row_of(state, piece.route)
    low, high = row + piece.low, row + piece.high
    if piece.turned:
        for k in range(size):
            state.spare[np.uint64(taken + k)] = state.node[np.uint64(high - k)]
    else:
        for k in range(size):
            state.spare[np.uint64(taken + k)] = state.node[np.uint64(low + k)]
    for c in range(tables.stay.shape[0]):
        base, to = c * len(state.node), c * len(state.spare) + taken
        if piece.turned:
            copy_turned(state.back, base + high, state.spare_ahead, to, size)
            if not tables.symmetric:
                copy_turned(state.ahead, base + high, state.spare_back, to, size)
        else:
            copy_paths(state.ahead, base + low, state.spare_ahead, to, size)
            if not tables.symmetric:
                copy_paths(state.back, base + low, state.spare_back, to, size)
    return taken + size


@inlined
def copy_paths(paths: Floats, base: int, spare: Floats, to: int, size: int) -> None:
    """Copy partial costs, less that of the first."""
    start = paths[np.uint64(base)]
    for k in range(size):
        spare[np.uint64(to + k)] = paths[np.uint64(base + k)] - start


@inlined
def copy_turned(paths: Floats, base: int, spare: Floats, to: int, size: int) -> None:
    """Copy the partial costs that slots before one have on the way from it."""
    start = paths[np.uint64(base)]
    for k in range(size):
        spare[np.uint64(to + k)] = start - paths[np.uint64(base - k)]


@inner
def place(tables: Tables, state: State, change: Change, source: int) -> int:
    """Replace a change's window by its pieces in `spare` from `source` on; return their end."""
    route = change.route
    one, two = size_of(change.first), size_of(change.second)
    moved = size_of(tail(state, change))
    customers = one + two + max(0, moved - 1)
    first = row_of(state, route) + change.low
    state.length[route] += one + two - (change.high - change.low + 1)
    for k in range(one + two + moved):
        state.node[np.uint64(first + k)] = state.spare[np.uint64(source + k)]
    for k in range(customers):
        state.place[np.uint64(state.spare[np.uint64(source + k)])] = change.low + k
    for k in range(one + two):
        state.route[np.uint64(state.spare[np.uint64(source + k)])] = route
    state.unlinked[route] = 1
    behind = Long(state.length[route]) + 2 - change.low - one - two
    for c in range(tables.stay.shape[0]):
        at = c * len(state.spare) + source
        for is_back in range(1 if tables.symmetric else 2):
            add_paths(tables, state, (c, first, one), at, is_back)
            add_paths(tables, state, (c, first + one, two), at + one, is_back)
            add_paths(tables, state, (c, first + one + two, moved), at + one + two, is_back)
            if moved == 0:
                move_paths(tables, state, (c, first + one + two, behind), is_back)
    settle(tables, state, route)
    return source + one + two + moved


@inlined
def path_to(tables: Tables, state: State, measure: int, slot: int, is_back: int) -> float:
    """Return the partial cost of a slot from that of the slot before it."""
    here, there = Long(state.node[slot - 1]), Long(state.node[slot])
    before = measure * len(state.node) + slot - 1
    if is_back:
        return state.back[before] + leg(tables, measure, there, here)
    return state.ahead[before] + leg(tables, measure, here, there)


@inlined
def add_paths(
    tables: Tables, state: State, slots: tuple[int, int, int], source: int, is_back: int
) -> None:
    """Set the partial costs of a piece, of which the spare room has those from its first node on.

    Parameters
    ----------
    tables, state
        The problem, and its routes with the new nodes.
    slots
        A measure, the index of the first slot, the number of slots.
    source
        Index of the first slot in the spare room.
    is_back
        Whether the costs are those of `back`.
    """
    measure, slot, size = slots
    if size == 0:
        return
    start = path_to(tables, state, measure, slot, is_back)
    base = measure * len(state.node) + slot
    if is_back:
        for k in range(size):
            state.back[np.uint64(base + k)] = start + state.spare_back[np.uint64(source + k)]
    else:
        for k in range(size):
            state.ahead[np.uint64(base + k)] = start + state.spare_ahead[np.uint64(source + k)]


@inlined
def move_paths(tables: Tables, state: State, slots: tuple[int, int, int], is_back: int) -> None:
    """Set the partial costs of slots that follow on changed ones; `slots` as for `add_paths`."""
    measure, slot, size = slots
    base = measure * len(state.node) + slot
    paths = state.back if is_back else state.ahead
    rise = path_to(tables, state, measure, slot, is_back) - paths[base]
    for k in range(size):
        paths[np.uint64(base + k)] += rise


@inner
def make(tables: Tables, state: State, one: Change, other: Change) -> None:
    """Make two changes by which routes exchange pieces; the second may change nothing."""
    taken = Long(0)
    for change in (one, other):
        if change.route >= 0:
            taken = gather(tables, state, change.first, taken)
            taken = gather(tables, state, change.second, taken)
            taken = gather(tables, state, tail(state, change), taken)
    taken = Long(0)
    for change in (one, other):
        if change.route >= 0:
            taken = place(tables, state, change, taken)
