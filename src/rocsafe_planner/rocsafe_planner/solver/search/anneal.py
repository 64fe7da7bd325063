# SPDX-License-Identifier: Apache-2.0
"""Simulated annealing of routes with moves between near neighbours; the best routes are kept."""

from typing import NamedTuple

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, Word, inlined, kernel
from rocsafe_planner.solver.model.randomness import GOLDEN, THRESHOLD_BITS, below, scramble
from rocsafe_planner.solver.model.tables import Floats, Ints, Tables, Words
from rocsafe_planner.solver.search.moves import Change, Goal, Piece, allowed, make, rise
from rocsafe_planner.solver.search.ruin import ruin
from rocsafe_planner.solver.search.state import State, unload


class Best(NamedTuple):
    """The best routes of a search and their value."""

    order: Ints
    lengths: Ints
    value: Floats
    """(1,) worth, as `worth` counts it."""


class Dice(NamedTuple):
    """Random numbers of a lane."""

    counter: Words
    """(1,) state of the generator."""
    thresholds: Floats
    """Acceptance draws, see `acceptance_thresholds`."""


@inlined
def worth(tables: Tables, state: State, peak: float, share: float) -> float:
    """Return the minimised value: peak*longest + share*total, and the breach of limits."""
    longest, total, breach = -np.inf, 0.0, 0.0
    for r in range(len(state.cost)):
        longest = max(longest, state.cost[r])
        total += state.cost[r]
        if tables.limited:
            breach += max(0.0, state.load[r] - tables.limit[r] * (1 + 1e-9))
    return peak * longest + share * total + 1e4 * breach


NOTHING = Piece(0, 1, 0, False)
NONE = Change(-1, 1, 0, NOTHING, NOTHING)


@inlined
def span(word: Word, long: Word) -> int:
    """Draw the number of customers after the first of a segment: mostly 0 to 2, at most 63."""
    scale = word & Word(15)
    if scale < long:
        return Long((word >> Word(4)) % (Word(4) << scale))
    return Long((word >> Word(4)) % Word(3))


@inlined
def within(state: State, route: int, p: int, q: int, word: Word, long: Word) -> Change:
    """Describe a change that makes slots p (a customer) and q of one route neighbours.

    A change of route -1 changes nothing.
    """
    end = Long(state.length[route]) + 1
    low, high = min(p, q), max(p, q)
    if word & Word(1) == 0:  # 2-opt: reverse the customers between, with one of the two
        if (word & Word(2) == 0 and high < end) or low == 0:
            low += 1
        else:
            high -= 1
        if high == end or high <= low:
            return NONE
        return Change(route, low, high, Piece(route, low, high, True), NOTHING)
    size = span(word >> Word(6), long)  # Or-opt
    behind = (q == 0 or (word >> Word(4)) & Word(1) == 0) and q < end
    heading = (word >> Word(5)) & Word(1) == 0
    low = p if heading else p - size
    high = low + size
    gap = q if behind else q - 1
    if low < 1 or high >= end or low - 1 <= gap <= high:
        return NONE
    moved = Piece(route, low, high, heading != behind)
    if gap > high:
        return Change(route, low, gap, Piece(route, high + 1, gap, False), moved)
    return Change(route, gap + 1, high, moved, Piece(route, gap + 1, low - 1, False))


@inlined
def between(
    state: State, a: int, p: int, b: int, q: int, word: Word, long: Word
) -> tuple[Change, Change]:
    """Describe changes that bring slot p of route a (a customer) beside slot q of route b."""
    size_a, size_b = Long(state.length[a]), Long(state.length[b])
    behind = (q == 0 or word & Word(1) == 0) and q <= size_b
    kind = (word >> Word(1)) & Word(3)
    if kind == 0:  # swap the tails
        cut_a, cut_b = (p - 1, q) if behind else (p, q - 1)
        return (
            Change(a, cut_a + 1, size_a, Piece(b, cut_b + 1, size_b, False), NOTHING),
            Change(b, cut_b + 1, size_b, Piece(a, cut_a + 1, size_a, False), NOTHING),
        )
    if kind == 1 and 0 < q <= size_b:  # join the heads, and the tails
        cut_a, cut_b = (p, q) if behind else (p - 1, q - 1)
        return (
            Change(a, cut_a + 1, size_a, Piece(b, 1, cut_b, True), NOTHING),
            Change(
                b,
                1,
                size_b,
                Piece(a, cut_a + 1, size_a, True),
                Piece(b, cut_b + 1, size_b, False),
            ),
        )
    sent = span(word >> Word(9), long)
    got = (
        span(word >> Word(32), long) + Long((word >> Word(3)) & Word(1)) if kind == 3 else Long(0)
    )
    heading = (word >> Word(7)) & Word(1) == 0
    a_low = p if heading else p - sent
    b_low = q + 1 if behind else q - got
    a_high, b_high = a_low + sent, b_low + got - 1
    if a_low < 1 or a_high > size_a or b_low < 1 or b_high > size_b:
        return NONE, NONE
    turned = (word >> Word(8)) & Word(1) == 0
    return (
        Change(a, a_low, a_high, Piece(b, b_low, b_high, turned), NOTHING),
        Change(b, b_low, b_high, Piece(a, a_low, a_high, heading != behind), NOTHING),
    )


@inlined
def passes(
    tables: Tables, state: State, goal: Goal, bar: float, one: Change, other: Change
) -> bool:
    """Return whether two changes are allowed and together raise the energy by at most `bar`."""
    if one.route < 0:
        return False
    total = rise(tables, state, goal, one)
    if other.route >= 0:
        total += rise(tables, state, goal, other)
    if total > bar:
        return False
    return not tables.restricted or (allowed(tables, state, one) and allowed(tables, state, other))


@inlined
def proposal(tables: Tables, state: State, word: Word, long: Word) -> tuple[Change, Change]:
    """Describe a random move beside a random customer, drawn from the bits of a word."""
    n, near = tables.near.shape
    i = below(word >> Word(32), n)
    a = Long(state.route[i])
    p = Long(state.place[i])
    pick = Long((((word >> Word(12)) & Word(127)) * Word(near * 16 + 8)) >> Word(7))
    more = scramble(word)
    if pick < near * 16:
        j = tables.near[i, pick >> 4]
        b = Long(state.route[j])
        q = Long(state.place[j])
    else:
        b = below(more >> Word(32), len(state.length))
        q = Long(0 if pick & 1 else state.length[b] + 1)
    if a == b:
        return within(state, a, p, q, more, long), NONE
    return between(state, a, p, b, q, more, long)


@inlined
def note(tables: Tables, state: State, best: Best, peak: float, share: float) -> None:
    """Keep the routes if they are the best until now."""
    value = worth(tables, state, peak, share)
    if value < best.value[0]:
        best.value[0] = value
        unload(state, best.order, best.lengths)


class Heat(NamedTuple):
    """Temperatures and kinds of moves of a chunk of proposals."""

    temperature: float
    ratio: float
    """Factor of the temperature every 256 proposals."""
    proposals: int
    ruins: int
    """Of 4096 proposals, how many are ruin and recreate."""
    long: int
    """Of 16 segments, how many may be long."""


class Aim(NamedTuple):
    """Objective of the search: the energy that accepts moves, and the value that ranks plans."""

    goal: Goal
    peak: float
    share: float


@kernel
def anneal(tables: Tables, state: State, aim: Aim, best: Best, random: Dice, heat: Heat) -> int:
    """Make a number of proposals, and keep the best routes in `best`.

    Returns
    -------
    int
        Number of accepted proposals.
    """
    counter = random.counter[0]
    temperature = heat.temperature
    accepted = 0
    for step in range(heat.proposals):
        if step & 255 == 255:
            temperature *= heat.ratio
        counter += GOLDEN
        word = scramble(counter)
        bar = temperature * random.thresholds[word & Word((1 << THRESHOLD_BITS) - 1)]
        if (word >> Word(52)) < Word(heat.ruins):
            random.counter[0] = counter
            made = ruin(tables, state, aim.goal, random.counter, bar)
            counter = random.counter[0]
        else:
            one, other = proposal(tables, state, word, Word(heat.long))
            made = passes(tables, state, aim.goal, bar, one, other)
            if made:
                make(tables, state, one, other)
        if made:
            accepted += 1
            note(tables, state, best, aim.peak, aim.share)
    random.counter[0] = counter
    return accepted
