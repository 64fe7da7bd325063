# SPDX-License-Identifier: Apache-2.0
"""Which sources are more than the ground's own unevenness.

Where the background is seen to vary smoothly, it also varies over shorter ways, which no smooth
field follows and a weak source does. So the evidence of a source is weighed against a background
that varies by a share a over the width of a source: its matched filter has the variance of the
counts plus that of the ground, and its log likelihood ratio L becomes

    1 / (1/L + 2 a^2/q^2),

with the source's dose rate over itself q in units of the background: never more than q^2/(2 a^2),
however long one counts. On even ground a is 0, and nothing changes.
"""

from dataclasses import replace

import numpy as np

from rocsafe_radiation.likelihood import LEVEL_PARAMETERS, SOURCE_PARAMETERS, Fit, Likelihood
from rocsafe_radiation.order_values import Array, OrderSearch

# Over the width of a source the ground varies by such a share of what it does smoothly.
UNRESOLVED_SHARE = 0.5
# As much as the first source needs to be believed on 441 readings.
LEAST_EVIDENCE = 12.0
# So much better explains uneven ground the readings, with as many sources.
CLEARLY_BETTER = 3.0


def unevenness(even: OrderSearch, uneven: OrderSearch) -> float:
    """Return the share by which the ground varies over the width of a source.

    Parameters
    ----------
    even, uneven: fits with an even and with a smooth background; 0 unless the second explain the
        readings clearly better with as many sources as they then need.
    """
    order = uneven.order
    if order < len(even.scores) and uneven.scores[order] < even.scores[order] + CLEARLY_BETTER:
        return 0.0
    return UNRESOLVED_SHARE * _smooth_variation(uneven.likelihood, uneven.fits[order])


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
    bumps = fit.parameters[LEVEL_PARAMETERS : likelihood.background_size]
    return float((likelihood.basis[:, LEVEL_PARAMETERS - 1 :] @ bumps).std())


def _penalty(likelihood: Likelihood, fit: Fit, gain: float, share: float) -> float:
    """Return the evidence that incredible sources of a fit have brought it.

    `gain` is that of the last source added, which replaces the evidence of the weakest: the
    others would take over part of what that explains.
    """
    level = float(np.median(likelihood.background_usvh(fit.parameters)))
    height = likelihood.survey.height_m(likelihood.setting.source_up_m)
    (over,) = likelihood.setting.kernel.values(np.array([height**2]))
    ratios = np.exp(likelihood.sources(fit.parameters)[:, 3]) * over / level
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


def _without(likelihood: Likelihood, fit: Fit, index: int) -> Array:
    start = likelihood.background_size + SOURCE_PARAMETERS * index
    return np.delete(fit.parameters, range(start, start + SOURCE_PARAMETERS))
