# SPDX-License-Identifier: Apache-2.0
"""Recombination by tours: a piece of one tour, the rest in the order of another.

The routes of a plan, sorted by their direction from the home, are one tour of all customers. A
tour is cut into a plan such that the costliest route is cheapest (Beasley's route first, cluster
second; order crossover as in Prins, 2004). Unlike a mix of whole routes, this moves customers
between all routes at once.
"""

from itertools import pairwise

import numpy as np

from rocsafe_planner.solver.model.tables import Floats, Ints, Tables
from rocsafe_planner.solver.search.crossover import ends_of
from rocsafe_planner.solver.search.split import split

TURNS = 16
"""Places of a tour at which its first route is tried to begin."""
LEAST_PIECE, MOST_PIECE = 0.2, 0.8
"""Shares of a tour that are taken from the first parent."""


def tour_of(plan: tuple[Ints, Ints], away: Floats, choices: np.random.Generator) -> Ints:
    """Return all customers, route after route by direction, from a random route on.

    Parameters
    ----------
    plan
        Customers route after route, and the length of each route.
    away
        (n, 2) places of the customers relative to the home.
    choices
        Random numbers, for the route that comes first.
    """
    ends = ends_of(plan[1])
    routes = [plan[0][a:b] for a, b in pairwise(ends) if b > a]
    centres = np.array([away[route].mean(axis=0) for route in routes])
    angles = np.round(np.arctan2(centres[:, 1], centres[:, 0]), 9)
    turn = np.roll(np.argsort(angles, kind='stable'), -int(choices.integers(len(routes))))
    return np.concatenate([routes[k] for k in turn])


def braid(one: Ints, other: Ints, choices: np.random.Generator) -> Ints:
    """Return a piece of one tour, then all other customers in the order of another tour."""
    n = len(one)
    piece = np.roll(one, -int(choices.integers(n)))
    piece = piece[: max(1, int(n * choices.uniform(LEAST_PIECE, MOST_PIECE)))]
    is_taken = np.zeros(n, np.bool_)
    is_taken[piece] = True
    rest = np.roll(other, -1 - int(np.flatnonzero(other == piece[-1])[0]))
    return np.concatenate([piece, rest[~is_taken[rest]]])


def cut(tables: Tables, tour: Ints) -> tuple[Ints, Ints]:
    """Return the best plan cut from a tour, from several first customers; vehicles are equal."""
    vehicles = np.arange(len(tables.first), dtype=np.int32)
    best, plan = np.inf, (tour, np.zeros(len(vehicles), np.int32))
    for begin in range(0, len(tour), max(1, len(tour) // TURNS)):
        order, lengths = np.roll(tour, -begin).astype(np.int32), np.zeros_like(vehicles)
        value = split(tables, order, vehicles, lengths)
        if value < best or begin == 0:
            best, plan = value, (order, lengths)
    return plan
