# SPDX-License-Identifier: Apache-2.0
"""Starts of fits with one more source, and the best of these fits."""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.candidates import best_separated, score_candidates
from rocsafe_radiation.localization.counts_model import (
    HEAD_MEANS,
    HEAD_SIZE,
    SOURCE_PARAMETERS,
    STRENGTH,
)
from rocsafe_radiation.localization.likelihood import Fit, Likelihood
from rocsafe_radiation.localization.mirror_image import mirror_images
from rocsafe_radiation.localization.shade import first_shades, left, paths

QUIET_SHARE = 0.2
# Thickness over that expected at which a shade begins, how far apart those tried are, and the gain
# in log likelihood below which only the best one is tried.
AMOUNTS, APART, LEAST_GAIN = (0.2, 4.0), 0.5, 2.0


def without_sources(likelihood: Likelihood) -> Fit:
    """Return the fit of the background alone, begun at the mean of the lowest readings."""
    survey = likelihood.survey
    rates = survey.net_counts / survey.exposures
    quiet = rates <= np.quantile(rates, QUIET_SHARE)
    level = float(survey.net_counts[quiet].sum() / survey.exposures[quiet].sum())
    start = np.zeros(likelihood.head_size)
    start[:HEAD_SIZE] = HEAD_MEANS
    start[0] = math.log(max(level, 1e-6))
    return likelihood.fit(start)


def with_one_more(
    likelihood: Likelihood, fit: Fit, grid: FloatArray, kernel: FloatArray
) -> Fit | None:
    """Return the best fit with one more source than `fit`, None if there is no start.

    Parameters
    ----------
    likelihood, fit
        Where the new source is added.
    grid : shape (m, 2)
        Places tried, metres.
    kernel : shape (m, n)
        Counts of each reading for 1 uSv/h at 1 m at each place.
    """
    height = likelihood.survey.height_m(likelihood.setting.source_up_m)
    starts = _added(likelihood, fit.parameters, grid, kernel, height)
    if not starts:
        return None
    options = likelihood.setting.search
    rough = (likelihood.fit(start, options.rough_iterations) for start in starts)
    best = likelihood.fit(max(rough, key=_evidence).parameters)
    images = (likelihood.fit(start) for start in mirror_images(likelihood, best.parameters))
    return max((best, *images), key=_evidence)


def _evidence(fit: Fit) -> float:
    return fit.log_likelihood


def _added(
    likelihood: Likelihood,
    parameters: FloatArray,
    grid: FloatArray,
    kernel: FloatArray,
    height: float,
) -> list[FloatArray]:
    tried = likelihood.setting.search.tried_candidates
    up = likelihood.setting.source_up_m
    starts = []
    for shares in _weightings(likelihood, parameters):
        gains, strengths = score_candidates(likelihood, parameters, kernel, shares)
        starts += [
            np.concatenate([parameters, [*grid[index], up, math.log(strengths[index])]])
            for index in best_separated(grid, gains, tried, height)
        ]
    return starts


def _weightings(likelihood: Likelihood, parameters: FloatArray) -> list[FloatArray]:
    """Return all readings alike and, if there may be spikes, these left out.

    Readings that fit nothing show a strong source or are spikes, which hide weaker sources.
    """
    regular = likelihood.regular_shares(
        likelihood.expected(parameters), likelihood.weights(parameters)
    )
    alike = np.ones(likelihood.survey.size)
    return [alike] if regular.min() > 0.5 else [alike, regular]


def with_shades(plain: Likelihood, fit: Fit, shaded: Likelihood) -> Fit:
    """Return the best fit with something beside each source, begun at one without.

    Parameters
    ----------
    plain, fit
        The likelihood without shades, and its fit.
    shaded
        The likelihood with them, all else alike.
    """
    sources = plain.sources(fit.parameters)
    tried = [_likely_shades(plain, fit.parameters, source) for source in sources]
    starts = []
    for rank in range(max(map(len, tried))):
        shades = [own[min(rank, len(own) - 1)] for own in tried]
        start = np.concatenate(
            [fit.parameters[: plain.head_size], np.zeros(shaded.source_size * len(sources))]
        )
        rows = shaded.sources(start)
        rows[:, :SOURCE_PARAMETERS] = sources
        rows[:, SOURCE_PARAMETERS:] = shades
        starts.append(start)
    if len(starts) > 1:
        rough = (shaded.fit(start, shaded.setting.search.rough_iterations) for start in starts)
        starts = [max(rough, key=_evidence).parameters]
    return shaded.fit(starts[0])


def _likely_shades(plain: Likelihood, parameters: FloatArray, source: FloatArray) -> FloatArray:
    """Return the shades of one source that would explain the readings best, shape (tried, 4)."""
    shades = first_shades()
    offsets = np.broadcast_to(plain.offsets(source[None]), (len(shades), 3, plain.survey.size))
    distances = np.sqrt(np.einsum('kcn,kcn->kn', offsets, offsets))
    rates = np.exp(source[STRENGTH]) * plain.setting.kernel.values(distances[0] ** 2)
    lost = (left(paths(offsets, distances, shades)) - 1.0) * rates * plain.survey.exposures
    gains, amounts = score_candidates(plain, parameters, lost, np.ones(plain.survey.size))
    # What is lost grows with the thickness.
    shades[:, 3] += np.log(np.clip(amounts, *AMOUNTS))
    tried = plain.setting.search.tried_candidates
    best = best_separated(shades[:, :2], gains - LEAST_GAIN, tried, APART)
    return np.asarray(shades[best or [int(np.argmax(gains))]])
