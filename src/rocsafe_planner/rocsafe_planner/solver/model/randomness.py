# SPDX-License-Identifier: Apache-2.0
"""Random numbers that are the same on every machine, from integers only.

Sebastiano Vigna's SplitMix64 (public domain, 2015): the state is one 64-bit word; each proposal
uses the bit fields of one draw.
"""

import math

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, Word, inlined
from rocsafe_planner.solver.model.tables import Floats, Words

GOLDEN = Word(0x9E3779B97F4A7C15)
MIX_1 = Word(0xBF58476D1CE4E5B9)
MIX_2 = Word(0x94D049BB133111EB)
S30, S27, S31, S32 = Word(30), Word(27), Word(31), Word(32)

THRESHOLD_BITS = 12
"""Resolution of the acceptance draw, in bits."""


@inlined
def scramble(word: int) -> int:
    """Return the well mixed 64 bits of one counter value."""
    word = (word ^ (word >> S30)) * MIX_1
    word = (word ^ (word >> S27)) * MIX_2
    return word ^ (word >> S31)


@inlined
def below(bits32: int, limit: int) -> int:
    """Map 32 random bits to 0 .. limit - 1 (Lemire's multiplication)."""
    return Long((bits32 * Word(limit)) >> S32)


@inlined
def draw(random: Words, limit: int) -> int:
    """Draw a number from 0 .. limit - 1."""
    random[0] += GOLDEN
    return below(scramble(random[0]) >> S32, limit)


def seed_word(seed: int, lane: int) -> int:
    """Return the start state of one lane of a seeded search."""
    mask = (1 << 64) - 1
    word = (seed * 0x9E3779B97F4A7C15 + (lane + 1) * 0xD1342543DE82EF95) & mask
    word = ((word ^ (word >> 33)) * 0xFF51AFD7ED558CCD) & mask
    return word ^ (word >> 33)


def acceptance_thresholds() -> Floats:
    """Return -ln(u) for evenly spaced u, rounded to 2**-20 to hide the last digit of `log`."""
    count = 1 << THRESHOLD_BITS
    exact = [-math.log((k + 0.5) / count) for k in range(count)]
    return np.array([round(x * 2**20) / 2**20 for x in exact])
