# SPDX-License-Identifier: Apache-2.0
"""Means with intervals from the runs themselves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray

RESAMPLES = 2000
LEVEL = 0.95
# Values drawn at a time.
LARGEST_PART = 2_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Interval:
    """A mean and its 95 % interval; NaN where there are too few values.

    Attributes
    ----------
    count
        Number of values known.
    """

    count: int
    mean: float
    low: float
    high: float


def bootstrap_mean(values: Sequence[float], seed: int = 0) -> Interval:
    """Return the mean of the known values and its interval by the percentile bootstrap.

    Efron & Tibshirani, An Introduction to the Bootstrap, 1993, chapter 13. Two values or more
    have an interval.
    """
    known = np.array([value for value in values if math.isfinite(value)])
    if not len(known):
        return Interval(count=0, mean=math.nan, low=math.nan, high=math.nan)
    mean = float(known.mean())
    if len(known) == 1:
        return Interval(count=1, mean=mean, low=math.nan, high=math.nan)
    means = _resampled_means(known, np.random.default_rng(seed))
    low, high = np.quantile(means, [(1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0]).tolist()
    return Interval(count=len(known), mean=mean, low=low, high=high)


def _resampled_means(known: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Return the means of samples of the values, in parts that fit in memory."""
    size = len(known)
    rows = max(1, min(RESAMPLES, LARGEST_PART // size))
    parts = [
        known[generator.integers(size, size=(min(rows, RESAMPLES - first), size))].mean(axis=1)
        for first in range(0, RESAMPLES, rows)
    ]
    return np.concatenate(parts)
