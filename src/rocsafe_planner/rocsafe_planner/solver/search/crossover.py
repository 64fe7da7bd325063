# SPDX-License-Identifier: Apache-2.0
"""Recombination by routes: some of one plan, the rest of another, the missing inserted."""

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, kernel
from rocsafe_planner.solver.model.randomness import draw
from rocsafe_planner.solver.model.tables import Ints, Tables, Words
from rocsafe_planner.solver.search.moves import Goal
from rocsafe_planner.solver.search.ruin import adopt_trial, begin_trial, insert, insert_at_end
from rocsafe_planner.solver.search.state import State, load


@kernel
def complete(
    tables: Tables,
    state: State,
    goal: Goal,
    order: Ints,
    lengths: Ints,
    missing: Ints,
    random: Words,
) -> None:
    """Set the routes to an incomplete plan; insert the missing customers where they cost least."""
    load(tables, state, order, lengths)
    for k in range(len(missing)):
        state.route[missing[k]] = -1
    begin_trial(state)
    for k in range(len(missing) - 1, -1, -1):
        j = draw(random, k + 1)
        missing[k], missing[j] = missing[j], missing[k]
        if not insert(tables, state, goal, Long(missing[k]), random):
            insert_at_end(tables, state, goal, Long(missing[k]))
    adopt_trial(tables, state)


def ends_of(lengths: Ints) -> Ints:
    """Return the index of the first customer of each route, and the end of the last route."""
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)


def mix(
    one: tuple[Ints, Ints], other: tuple[Ints, Ints], chosen: list[int], alike: bool
) -> tuple[Ints, Ints, Ints]:
    """Return a partial plan and the customers it lacks.

    Parameters
    ----------
    one, other
        Parents: customers route after route, and the length of each route.
    chosen
        Routes of `one` that are kept unchanged.
    alike
        Whether vehicles are interchangeable: then the routes of `other` that lose the fewest
        customers complete the plan; else each vehicle without a chosen route keeps the rest of
        its own.
    """
    first, second = ends_of(one[1]), ends_of(other[1])
    vehicles = len(one[1])
    free = np.ones(len(one[0]), np.bool_)
    routes: dict[int, Ints] = {}
    for r in chosen:
        routes[r] = one[0][first[r] : first[r + 1]]
        free[routes[r]] = False
    parts = [other[0][second[r] : second[r + 1]] for r in range(vehicles)]
    left = [part[free[part]] for part in parts]
    open_vehicles = [r for r in range(vehicles) if r not in routes]
    sources = open_vehicles
    if alike:
        loss = [len(part) - len(rest) for part, rest in zip(parts, left, strict=True)]
        sources = sorted(range(vehicles), key=lambda r: (loss[r], r))[: len(open_vehicles)]
    for r, source in zip(open_vehicles, sources, strict=True):
        routes[r] = left[source]
        free[left[source]] = False
    order = np.concatenate([routes[r] for r in range(vehicles)]).astype(np.int32)
    lengths = np.array([len(routes[r]) for r in range(vehicles)], np.int32)
    return order, lengths, np.flatnonzero(free).astype(np.int32)
