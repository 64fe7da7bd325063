# SPDX-License-Identifier: Apache-2.0
"""Tuning of the search: how its cycles grow, how they are cooled and crossed.

The values are our own, found by trials on the families of `benchmarks/planning_families.py`; none
of them comes from a publication.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleTuning:
    """Numbers of the schedule of cycles.

    Attributes
    ----------
    chunk
        Proposals between two looks at the clock.
    ladder
        Work of the cycles that begin with a construction: proposals a customer, where one that
        ruins and recreates counts for as many others as it takes the time of.
    crosses
        Multiple of its own work that a search has done before such a cycle begins.
    crossed
        Work of the first cycles that begin with a cross, proposals a customer.
    longer
        Factor by which cycles grow when the search stagnates.
    patience
        Rounds without a better plan after which the search stagnates.
    restarts
        Every so many stagnations a cycle begins with a construction again.
    ruin_cost
        Work of a ruin-and-recreate move, in other proposals.
    ruin_slot_cost
        What it takes besides for each customer of a mean route.
    members
        Plans that are kept for crossing.
    ruins
        Ruin-and-recreate proposals of 4096 that a cycle may have.
    first_ruins
        The same of the first cycles.
    floors
        Worth of a unit of cost in a short route, against 1 in the longest. The smaller it is, the
        nearer comes the longest route to its least, and the longer the others stay hot.
    sharper
        Power of two by which the width of that worth shrinks until the end of a cycle.
    widths
        Share of the target cost over which the worth rises to 1, at the start of a cycle.
    brief, brief_hot
        Work below which a first cycle begins at the temperature `brief_hot`.
    first_hot, crossed_hots
        Temperature at the start of a first cycle, and of one after a cross: powers of two of the
        mean distance between near neighbours.
    cold
        Temperature at the end of a cycle, as such a power.
    longs
        Of 16 segments that are moved, how many may be long.
    memory
        Share of a value's weight that stays when a cycle with that value has ended.
    best_score, good_score, poor_score
        What a value is given for the best plan so far, for one among the better half of the
        members, and for another one.
    """

    chunk: int = 16384
    ladder: tuple[int, ...] = (500, 8_000)
    crosses: float = 0.5
    crossed: int = 1_000
    longer: float = 2.0
    patience: int = 3
    restarts: int = 3
    ruin_cost: float = 30.0
    ruin_slot_cost: float = 0.15
    members: int = 10
    ruins: tuple[int, ...] = (10, 40, 200, 600, 1500)
    first_ruins: int = 10
    floors: tuple[float, ...] = (0.03, 0.1, 0.2)
    sharper: tuple[float, ...] = (3.0, 4.0)
    widths: tuple[float, ...] = (0.01, 0.02)
    brief: int = 2_000
    brief_hot: float = -2.0
    first_hot: float = 0.0
    crossed_hots: tuple[float, ...] = (-1.0, -2.0, -3.0, -4.0)
    cold: float = -5.5
    longs: tuple[int, ...] = (0, 3)
    memory: float = 0.7
    best_score: float = 6.0
    good_score: float = 1.5
    poor_score: float = 0.5


USUAL = CycleTuning()
"""The tuning of every search."""
