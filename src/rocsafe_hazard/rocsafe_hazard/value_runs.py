# SPDX-License-Identifier: Apache-2.0
"""Values of one detector that stand still: read more often than measured, stuck, or saturated."""

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray

# A detector has fine steps if at least this share, and this number, of its values differ from
# each other when repeats of the value before are left out. Values of coarse steps, and zeros of
# clean air, recur.
LEAST_UNLIKE, FEWEST_UNLIKE = 0.9, 10
# A smaller share of equal neighbours is an accident of rounding.
LEAST_AGAIN = 0.05
# Steps shorter than this share of the longest, but for as many, are those of the receiver's noise.
STANDING = 0.1
# Readings whose third differences are a smaller share of them are of no detector, but computed:
# neither sources nor uneven ground change so quickly, and the noise of detectors is above 1 %.
LEAST_NOISE = 1e-3
# So many times as many equal values at the top as there are of each other one are no accident, on
# a scale of so many steps, where few of the others repeat the one before.
TIMES_AT_TOP, LEAST_STEPS, MOST_REPEATS = 3.0, 20.0, 0.1


def are_again(values: FloatArray, steps_m: FloatArray | None = None) -> BoolArray:
    """Return which values of a detector with fine steps, in their order, are the one before, (n,).

    Parameters
    ----------
    values : (n,)
        Readings of one detector.
    steps_m : (n,)
        Way to the place of each from that of the one before; None: unknown. A computed reading is
        alike wherever its vehicle stands, that of a stuck detector also where it moves.

    Examples
    --------
    >>> are_again(np.array([1.3, 1.3, 0.7, 2.1, 2.2, 2.3, 2.4, 2.9, 1.1, 0.1, 0.2])).tolist()[:4]
    [False, True, False, False]
    >>> are_again(np.array([0.0, 0.1, 0.1, 0.0, 0.0, 0.1])).tolist()
    [False, False, False, False, False, False]
    """
    again = np.concatenate([np.zeros(min(len(values), 1), dtype=bool), np.diff(values) == 0.0])
    kept = values[~again]
    is_fine = len(np.unique(kept)) >= max(LEAST_UNLIKE * len(kept), FEWEST_UNLIKE)
    steps_m = np.ones(len(values)) if steps_m is None else steps_m
    moves = steps_m > STANDING * np.quantile(steps_m, 1.0 - STANDING) if len(values) else again
    is_often = (again & moves).sum() >= LEAST_AGAIN * moves.sum() and not are_computed(kept)
    return again & (is_fine and is_often)


def are_computed(values: FloatArray) -> bool:
    """Return whether values, in their order, have no noise.

    Examples
    --------
    >>> are_computed(np.exp(np.linspace(0.0, 3.0, 100)))
    True
    >>> are_computed(np.random.default_rng(1).poisson(1000.0, 100))
    False
    """
    if len(values) < 4:
        return False
    usual = np.abs(np.lib.stride_tricks.sliding_window_view(values, 4).mean(axis=1))
    shares = np.abs(np.diff(values, 3)) / np.maximum(usual, 1e-12)
    return not float(np.median(shares)) > LEAST_NOISE


def are_at_top(values: FloatArray) -> BoolArray:
    """Return which values of a detector, in their order, are the largest that it can show, (n,).

    Examples
    --------
    >>> are_at_top(np.array([0.3, 5.1, 9.9, 9.9, 9.9, 7.2, 0.2, 0.25])).tolist()
    [False, False, True, True, True, False, False, False]
    >>> are_at_top(np.array([0.3, 5.1, 9.7, 9.9, 9.8, 7.2, 0.2])).tolist()
    [False, False, False, False, False, False, False]
    """
    levels = np.unique(values)
    at_top = values == levels[-1:]
    others = len(values) - int(at_top.sum())
    if not others:
        return np.zeros(len(values), dtype=bool)
    repeats = (np.diff(values) == 0.0) & ~at_top[1:]
    is_limit = (
        at_top.sum() >= TIMES_AT_TOP * others / (levels.size - 1)
        and levels[-1] - levels[0] >= LEAST_STEPS * np.diff(levels).min()
        and repeats.sum() <= MOST_REPEATS * len(values)
    )
    return at_top & is_limit
