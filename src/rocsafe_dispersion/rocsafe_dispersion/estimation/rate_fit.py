# SPDX-License-Identifier: Apache-2.0
"""Rates and backgrounds that fit readings best, and how likely the readings are then.

For given places the readings are linear in the rates; the scatter grows with the mean, has heavy
tails, and some readings are censored or miss the gas.
"""

from dataclasses import dataclass

import numpy as np
from scipy import special

from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.estimation.plume_kernel import offset_weights
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_geo.arrays import FloatArray, IndexArray

ROUNDS = 8
_DESCENTS = 20
_TINY = 1e-300
# The rate of the last release is tried at these multiples of its fit, closer near 1; the weights
# make them even in the logarithm.
MULTIPLES = np.array([0.25, 0.5, 0.75, 0.9, 1.0, 1.1, 1.33, 2.0, 4.0])
# Which of them is the fit itself.
AS_FITTED = int(np.abs(MULTIPLES - 1.0).argmin())
_WIDTHS = np.gradient(np.log(MULTIPLES))
MULTIPLE_WEIGHTS = _WIDTHS / _WIDTHS.sum()
# Degrees of freedom of the scatter (Student's t): heavy tails.
FREEDOM = 4.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RateFits:
    """Fits of m hypotheses.

    Attributes
    ----------
    rates_g_s : (m, releases)
        Rates, not below 0, g/s.
    backgrounds_g_m3 : (m, instruments)
        Backgrounds, not below 0, g/m^3.
    log_likelihoods : (m, multiples)
        Logarithm of the likelihood of all readings, with the rate of the last release at each of
        `MULTIPLES` of its fit; without a release they are all the same.
    """

    rates_g_s: FloatArray
    backgrounds_g_m3: FloatArray
    log_likelihoods: FloatArray

    def averaged(self, share: float) -> FloatArray:
        """Return the logarithms of the likelihood, averaged over the multiples, (m,).

        `share` of the information of the readings counts.
        """
        logs = share * self.log_likelihoods
        return np.asarray(special.logsumexp(logs, axis=1, b=MULTIPLE_WEIGHTS))


def fit_rates(
    survey: GasSurvey, units: FloatArray, scatter: float, options: LocateOptions
) -> RateFits:
    """Return the fits of hypotheses by reweighted least squares.

    Parameters
    ----------
    survey
        Readings (n).
    units : (offsets, n, m, releases)
        What each reading would be for 1 g/s of each release of each hypothesis, for each offset
        of the meandering plume.
    scatter
        Standard deviation of the concentration as a share of its mean.
    options
        Tails, missed readings.
    """
    design = np.einsum('o,onmp->nmp', offset_weights(units), units)
    releases = design.shape[2]
    # Columns of like size keep the equations well conditioned.
    scale = np.maximum(np.abs(design).max(axis=0), 1e-30)
    design = design / scale
    members = np.eye(survey.instruments.max() + 1)[survey.instruments]
    values = survey.values_g_m3[:, None]
    found = np.zeros((design.shape[1], releases + members.shape[1]))
    spread = np.full(design.shape[:2], float(np.std(values)) + survey.std_g_m3.max())
    gas: FloatArray = np.zeros(design.shape[:2])
    for _ in range(ROUNDS):
        predicted = gas + members @ found[:, releases:].T
        wanted = _aimed_at(survey, predicted)
        ratio = ((wanted - predicted) / spread) ** 2
        weights = (FREEDOM + 1.0) / (FREEDOM + ratio) / spread**2
        found = _solved(design, members, weights, wanted)
        gas = np.einsum('nmp,mp->nm', design, found[:, :releases])
        spread = np.hypot(survey.std_g_m3[:, None], scatter * gas)
    background = members @ found[:, releases:].T
    rates = found[:, :releases] / scale
    return RateFits(
        rates_g_s=rates,
        backgrounds_g_m3=found[:, releases:],
        log_likelihoods=log_likelihoods(survey, units, rates, background, scatter, options),
    )


def _aimed_at(survey: GasSurvey, predicted: FloatArray) -> FloatArray:
    """Return what readings ask for: censored ones nothing while they are not contradicted."""
    values = np.broadcast_to(survey.values_g_m3[:, None], predicted.shape)
    below = survey.is_below[:, None] & (predicted <= values)
    above = survey.is_above[:, None] & (predicted >= values)
    return np.where(below | above, predicted, values)


def _solved(
    design: FloatArray, members: FloatArray, weights: FloatArray, values: FloatArray
) -> FloatArray:
    """Return the weighted least squares of each hypothesis, none below 0, (m, parameters).

    `design` (n, m, releases) is that of the rates, `members` (n, instruments) tells whose
    background each reading has.
    """
    releases = design.shape[2]
    size = releases + members.shape[1]
    normal, right = np.zeros((design.shape[1], size, size)), np.zeros((design.shape[1], size))
    for first in range(releases):
        weighted = weights * design[:, :, first]
        right[:, first] = (weighted * values).sum(axis=0)
        for second in range(first, releases):
            normal[:, first, second] = (weighted * design[:, :, second]).sum(axis=0)
            normal[:, second, first] = normal[:, first, second]
        normal[:, first, releases:] = weighted.T @ members
        normal[:, releases:, first] = normal[:, first, releases:]
    right[:, releases:] = (weights * values).T @ members
    own = np.arange(releases, size)
    normal[:, own, own] = weights.T @ members
    ridge = 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] + _TINY
    normal = normal + ridge * np.eye(size)
    found = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
    below = (found < 0.0).any(axis=1)
    if below.any():
        found[below] = _bounded(normal[below], right[below], np.maximum(found[below], 0.0))
    return np.asarray(found)


def _bounded(normal: FloatArray, right: FloatArray, found: FloatArray) -> FloatArray:
    """Return the least squares with no parameter below 0, from a start.

    Coordinate descent; few parameters, so few rounds.
    """
    for _ in range(_DESCENTS):
        before = found.copy()
        for index in range(found.shape[1]):
            rest = right[:, index] - (normal[:, index] * found).sum(axis=1)
            step = rest / normal[:, index, index]
            found[:, index] = np.maximum(found[:, index] + step, 0.0)
        if np.allclose(found, before, rtol=1e-6, atol=0.0):
            break
    return found


def log_likelihoods(
    survey: GasSurvey,
    units: FloatArray,
    rates: FloatArray,
    background: FloatArray,
    scatter: float,
    options: LocateOptions,
    multiples: FloatArray = MULTIPLES,
) -> FloatArray:
    """Return the logarithms of the likelihood, (m, multiples).

    The rate of the last release is multiplied by each of `multiples`; other arguments are as in
    `fit_rates`, rates are (m, releases) and the background of each reading is (n, m).
    """
    every = np.arange(len(background))[:, None]
    noise = np.broadcast_to(survey.std_g_m3[:, None], background.shape)
    clean = _densities(survey, every, background, noise)
    if not rates.shape[1]:
        logs = np.log(np.maximum(clean, _TINY)).sum(axis=0)
        return np.repeat(logs[:, None], len(multiples), axis=1)
    shares = offset_weights(units)
    missed = options.missed_probability * clean
    others = np.einsum('onmp,mp->onm', units[..., :-1], rates[:, :-1])
    if others.any():
        parts = zip(shares, others, strict=True)
        clean = sum(
            share * _densities(survey, every, gas + background, np.hypot(noise, scatter * gas))
            for share, gas in parts
        )
    last = units[..., -1] * rates[:, -1]
    # Only readings that the last release reaches depend on its rate.
    reading, place = np.nonzero(last.any(axis=0))
    logs = np.log(np.maximum(missed + (1.0 - options.missed_probability) * clean, _TINY))
    logs[reading, place] = 0.0
    rest = logs.sum(axis=0)
    own, noise = background[reading, place], noise[reading, place]
    missed, others, last = (each[..., reading, place] for each in (missed, others, last))
    found = np.empty((background.shape[1], len(multiples)))
    for index, multiple in enumerate(multiples):
        density = missed.copy()
        for share, gas in zip(shares, others + multiple * last, strict=True):
            seen = _densities(survey, reading, gas + own, np.hypot(noise, scatter * gas))
            density += (1.0 - options.missed_probability) * share * seen
        reached = np.log(np.maximum(density, _TINY))
        found[:, index] = rest + np.bincount(place, reached, len(rest))
    return found


def _densities(
    survey: GasSurvey, readings: IndexArray, mean: FloatArray, spread: FloatArray
) -> FloatArray:
    """Return the densities of Student's t, and probabilities of censored readings.

    `readings` are the numbers of the readings, of a shape that fits `mean` and `spread`.
    """
    offset = (survey.values_g_m3[readings] - mean) / spread
    # 3/8 (1 + x^2/4)^(-5/2): four degrees of freedom, without a costly power.
    base = 1.0 + offset**2 / FREEDOM
    density = 0.375 / (base * base * np.sqrt(base) * spread)
    if not (survey.is_below | survey.is_above).any():
        return np.asarray(density)
    below = special.stdtr(FREEDOM, offset)
    density = np.where(survey.is_below[readings], below, density)
    return np.where(survey.is_above[readings], 1.0 - below, density)
