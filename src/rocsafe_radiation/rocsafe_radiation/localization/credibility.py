# SPDX-License-Identifier: Apache-2.0
"""Which sources are more than the ground's own unevenness.

Where the background is seen to vary smoothly, it also varies over shorter ways, which no smooth
field follows and a weak source does. So the evidence of a source is weighed against a background
that varies by a share a over the width of a source: its matched filter has the variance of the
counts plus that of the ground, and its log likelihood ratio L becomes

    1 / (1/L + 2 a^2/q^2),

with the largest dose rate q that it adds to a reading in units of the background: never more than
q^2/(2 a^2), however long one counts. The share a is half of what the ground varies smoothly, or
what readings far from all sources scatter beyond their counts, if that is more. On even ground a
is 0, and nothing changes.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.fit_setting import WIDE_SPACING_HEIGHTS
from rocsafe_radiation.localization.hypothesis_values import OrderSearch
from rocsafe_radiation.localization.likelihood import (
    LEVEL_PARAMETERS,
    SOURCE_PARAMETERS,
    Fit,
    Likelihood,
)

# Over the width of a source the ground varies by such a share of what it does smoothly.
UNRESOLVED_SHARE = 0.5
# As much as the first source needs to be believed on 441 readings.
LEAST_EVIDENCE = 12.0
# So much better explains uneven ground the readings, with as many sources.
CLEARLY_BETTER = 3.0
# Readings to which sources add less than this share of the background are far from them.
LARGEST_EXCESS = 0.3
# Standard deviations of the squared misfits of counts.
CLEARLY_BEYOND = 3.0


def credible(results: Sequence[OrderSearch]) -> OrderSearch:
    """Return the best of `results`, the first without an uneven ground, that can be believed."""
    best = max(results, key=_evidence)
    share = unevenness(best, [one for one in results if not _is_uneven(one)])
    return max((weighed(one, share) for one in results), key=_evidence)


def unevenness(best: OrderSearch, even: Sequence[OrderSearch]) -> float:
    """Return the share by which the ground varies unforeseen over the width of a source.

    Parameters
    ----------
    best
        The fit that explains the readings best.
    even
        Those on even ground; 0 unless the best is none of them, and clearly better.
    """
    if not _is_uneven(best) or _evidence(best) < max(map(_evidence, even)) + CLEARLY_BETTER:
        return 0.0
    smooth = _unresolved_share(best.likelihood) * _smooth_variation(best.likelihood, best.best)
    return max(smooth, _rough_variation(best.likelihood, best.best))


def _is_uneven(found: OrderSearch) -> bool:
    return found.likelihood.setting.background_std > 0.0


def _evidence(found: OrderSearch) -> float:
    return max(found.scores)


def _unresolved_share(likelihood: Likelihood) -> float:
    narrow = likelihood.setting.background_spacing_heights / WIDE_SPACING_HEIGHTS
    return UNRESOLVED_SHARE * narrow


def weighed(found: OrderSearch, share: float) -> OrderSearch:
    """Return `found` with orders that need incredible sources ranked below those that do not."""
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
    """Return the standard deviation of the logarithm of the smooth background over readings."""
    bumps = fit.parameters[LEVEL_PARAMETERS : likelihood.head_size]
    return float((likelihood.basis[:, LEVEL_PARAMETERS - 1 :] @ bumps).std())


def _rough_variation(likelihood: Likelihood, fit: Fit) -> float:
    """Return the share by which readings far from all sources scatter beyond their counts."""
    background = likelihood.background_usvh(fit.parameters) * likelihood.survey.exposures
    expected = likelihood.expected(fit.parameters)
    far = expected - background <= LARGEST_EXCESS * background
    misfits = (likelihood.survey.counts - expected)[far] ** 2 - expected[far]
    noise = math.sqrt(float((2.0 * expected[far] ** 2 + expected[far]).sum()))
    if misfits.sum() <= CLEARLY_BEYOND * noise:
        return 0.0
    return math.sqrt(float(misfits.sum() / (background[far] ** 2).sum()))


def _penalty(likelihood: Likelihood, fit: Fit, gain: float, share: float) -> float:
    """Return the evidence that incredible sources of a fit have brought it.

    `gain` is that of the last source added, which replaces the evidence of the weakest: the
    others would take over part of what that explains.
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
    return float(bounded[weighed_evidence < LEAST_EVIDENCE].sum())


def _without(likelihood: Likelihood, fit: Fit, index: int) -> FloatArray:
    start = likelihood.head_size + SOURCE_PARAMETERS * index
    return np.delete(fit.parameters, range(start, start + SOURCE_PARAMETERS))
