# SPDX-License-Identifier: Apache-2.0
"""Which sources an uneven background cannot imitate.

A background that varies smoothly also varies over shorter lengths. A smooth field cannot follow
this, but a weak source can. Let the background vary by a share a over the width of the response to
a source. The matched filter of a source then has the variance of the counts plus that of the
background, and its log likelihood ratio L becomes

    1 / (1/L + 2 a^2/q^2),

where q is the largest dose rate that the source adds to a reading, in units of the background.
This is at most q^2/(2 a^2), for any counting time. The share a is half of the smooth variation of
the background or, if that is more, the scatter of readings far from all sources beyond that of
their counts. Over a constant background a is 0, and nothing changes.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.fit_setting import WIDE_SPACING_HEIGHTS
from rocsafe_radiation.localization.hypothesis_values import OrderSearch, first_source_penalty
from rocsafe_radiation.localization.likelihood import (
    LEVEL_PARAMETERS,
    SOURCE_PARAMETERS,
    Fit,
    Likelihood,
)


def credible(results: Sequence[OrderSearch]) -> OrderSearch:
    """Return the result with the most evidence, sources that may be imitated left out."""
    best = max(results, key=_evidence)
    share = unevenness(best, [one for one in results if not _is_uneven(one)])
    return max((weighed(one, share) for one in results), key=_evidence)


def unevenness(best: OrderSearch, even: Sequence[OrderSearch]) -> float:
    """Return the share by which the background varies over the width of a source.

    Parameters
    ----------
    best
        The result with the most evidence.
    even
        Results with a constant background. If `best` is one of them or not clearly better, the
        share is 0.
    """
    if (
        not _is_uneven(best)
        or _evidence(best)
        < max(map(_evidence, even)) + best.likelihood.setting.search.clearly_better
    ):
        return 0.0
    smooth = _unresolved_share(best.likelihood) * _smooth_variation(best.likelihood, best.best)
    return max(smooth, _rough_variation(best.likelihood, best.best))


def _is_uneven(found: OrderSearch) -> bool:
    return found.likelihood.setting.background_std > 0.0


def _evidence(found: OrderSearch) -> float:
    return max(found.scores)


def _unresolved_share(likelihood: Likelihood) -> float:
    narrow = likelihood.setting.background_spacing_heights / WIDE_SPACING_HEIGHTS
    return likelihood.setting.search.unresolved_share * narrow


def weighed(found: OrderSearch, share: float) -> OrderSearch:
    """Return `found` with scores lowered by the evidence of sources that may be imitated."""
    if share <= 0.0:
        return found
    gains = [0.0, *(found.gain(order) for order in range(1, len(found.fits)))]
    penalties = [
        _penalty(found.likelihood, fit, gain, share)
        for fit, gain in zip(found.fits, gains, strict=True)
    ]
    scores = tuple(s - p for s, p in zip(found.scores, penalties, strict=True))
    return replace(found, scores=scores)


def _smooth_variation(likelihood: Likelihood, fit: Fit) -> float:
    """Return the standard deviation of the logarithm of the smooth background at the readings."""
    bumps = fit.parameters[LEVEL_PARAMETERS : likelihood.head_size]
    return float((likelihood.basis[:, LEVEL_PARAMETERS - 1 :] @ bumps).std())


def _rough_variation(likelihood: Likelihood, fit: Fit) -> float:
    """Return the share by which readings far from all sources scatter beyond Poisson."""
    background = likelihood.background_usvh(fit.parameters) * likelihood.survey.exposures
    expected = likelihood.expected(fit.parameters)
    far = expected - background <= likelihood.setting.search.largest_excess * background
    misfits = (likelihood.survey.counts - expected)[far] ** 2 - expected[far]
    noise = math.sqrt(float((2.0 * expected[far] ** 2 + expected[far]).sum()))
    if misfits.sum() <= likelihood.setting.search.clearly_beyond * noise:
        return 0.0
    return math.sqrt(float(misfits.sum() / (background[far] ** 2).sum()))


def _penalty(likelihood: Likelihood, fit: Fit, gain: float, share: float) -> float:
    """Return the evidence of those sources of a fit that an uneven background may imitate.

    `gain` is the gain of the last source added. It bounds the evidence of the weakest source,
    because without that source the others would be fitted anew and explain a part of its readings.
    """
    level = float(np.median(likelihood.background_usvh(fit.parameters)))
    ratios = likelihood.source_rates_usvh(fit.parameters).max(axis=1, initial=0.0) / level
    evidence = np.array(
        [
            fit.log_likelihood - likelihood.objective(_without(likelihood, fit, index))
            for index in range(len(ratios))
        ]
    )
    if len(ratios):
        weakest = int(np.argmin(evidence))
        evidence[weakest] = min(evidence[weakest], gain)
    bounded = np.maximum(evidence, 1e-9)
    weighed_evidence = 1.0 / (1.0 / bounded + 2.0 * (share / ratios) ** 2)
    return float(bounded[weighed_evidence < first_source_penalty(likelihood)].sum())


def _without(likelihood: Likelihood, fit: Fit, index: int) -> FloatArray:
    start = likelihood.head_size + SOURCE_PARAMETERS * index
    return np.delete(fit.parameters, range(start, start + SOURCE_PARAMETERS))
