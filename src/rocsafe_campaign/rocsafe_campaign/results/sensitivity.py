# SPDX-License-Identifier: Apache-2.0
"""Which key moves the result: rank correlation, and share of the variance of its ranks."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from rocsafe_geo.arrays import FloatArray

# Groups that the values of a drawn key are put into, each with the same number of runs.
GROUPS = 8
FEWEST = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Influence:
    """How much a key moves the result.

    Attributes
    ----------
    correlation
        Spearman's rank correlation with the result; NaN of a key without an order.
    share
        Share of the variance of the result's ranks that lies between groups of runs with alike
        values of the key, less what chance gives (epsilon squared of Kelley, 1935); 0 to 1.
    p_value
        Probability of such differences by chance (Kruskal and Wallis, 1952).
    """

    key: str
    correlation: float
    share: float
    p_value: float


def influences(
    inputs: Sequence[Mapping[str, Any]], results: Sequence[float]
) -> tuple[Influence, ...]:
    """Return the influence of each key on the result, the greatest share first.

    Latitude and longitude of a place count as two keys. Runs without a result, and keys that have
    one value only, are left out; below ten runs nothing is said.
    """
    known = [k for k, value in enumerate(results) if math.isfinite(value)]
    if len(known) < FEWEST:
        return ()
    ranks = stats.rankdata([results[k] for k in known])
    columns = _columns([inputs[k] for k in known])
    found = [_influence(key, values, ranks) for key, values in columns.items()]
    return tuple(sorted((one for one in found if one), key=lambda one: -one.share))


def _columns(inputs: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = {}
    for values in inputs:
        for key, value in values.items():
            parts = value if isinstance(value, (tuple, list)) else None
            if parts is None:
                columns.setdefault(key, []).append(value)
            else:
                for index, part in enumerate(parts):
                    columns.setdefault(f'{key}[{index}]', []).append(part)
    return columns


def _influence(key: str, values: Sequence[Any], ranks: FloatArray) -> Influence | None:
    is_ordered = all(
        isinstance(value, (int, float)) and not isinstance(value, bool) for value in values
    )
    kinds = sorted(set(map(str, values)))
    if len(values) != len(ranks) or len(kinds) < 2:
        return None
    if is_ordered:
        numbers = np.asarray(values, float)
        correlation = float(stats.spearmanr(numbers, ranks).statistic)
        groups = _groups(numbers)
    else:
        correlation = math.nan
        groups = np.array([kinds.index(str(value)) for value in values])
    sets = [ranks[groups == one] for one in np.unique(groups)]
    if len(sets) < 2 or np.ptp(ranks) == 0.0:
        return Influence(key=key, correlation=0.0, share=0.0, p_value=1.0)
    h, p_value = stats.kruskal(*sets)
    spare = len(ranks) - len(sets)
    share = (h - len(sets) + 1.0) / spare if spare else 0.0
    return Influence(
        key=key, correlation=correlation, share=max(0.0, float(share)), p_value=float(p_value)
    )


def _groups(numbers: FloatArray) -> FloatArray:
    """Return the group of each number: its value if there are few, else its quantile."""
    values = np.unique(numbers)
    if len(values) <= GROUPS:
        return np.asarray(np.searchsorted(values, numbers))
    places = stats.rankdata(numbers, method='ordinal') - 1
    return np.asarray(places * GROUPS // len(numbers))
