# SPDX-License-Identifier: Apache-2.0
"""What a detector counted, where it shows a running mean or dose rates of unknown noise.

A ratemeter with the time constant T shows after each interval dt the mean r of it as

    y_i = a y_{i-1} + (1 - a) r_i,    a = exp(-dt / T)

so that r_i = (y_i - a y_{i-1}) / (1 - a) is what it counted, and independent of the readings
before. With a wrong T, more of the r_i is left unexplained by sources and background: T is that
with the least left, in the scale of the y_i.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_hazard.value_runs import are_computed
from rocsafe_radiation.localization.likelihood import Fit, Likelihood
from rocsafe_radiation.readings.flight import Flight
from rocsafe_radiation.readings.survey import RadiationSurvey

# Fit of a survey in one setting: with the clock of the fixes or not, begun at another or at none.
FirstFit = Callable[[RadiationSurvey, bool, Fit | None], tuple[Likelihood, Fit]]
# Misses of readings that follow each other are alike by less than this where they are counts: four
# standard deviations of 400 readings.
LARGEST_ALIKENESS = 0.2
# Time constants looked for, seconds, how well the logarithm of one is found, and by how much the
# logarithm of what is left must fall.
RANGE_S, RANGE_LOG, LEAST_FALL = (0.7, 20.0), 0.5, 0.2
# Less than no counts in between show that it is too long: none instead make the sum of all more.
MOST_COUNTS = 1.2
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
# Readings of so many at the begin of the flight tell it.
MOST_TRIED = 1500
# Readings scatter less than counts if the square of their third differences, but for the largest,
# is below this share of that of counts; where the noise is not known, if their correlation with
# the next is above the other number.
LARGEST_SCATTER, LEAST_BEND, KEPT_SHARE, FEWEST_READINGS = 0.4, -0.72, 0.95, 16
THIRD_DIFFERENCE = np.array([1.0, -3.0, 3.0, -1.0])
LARGEST_MISS, NOISE_ROUNDS = 3.0, 3


@dataclass(frozen=True, slots=True)
class Left:
    """What a fit leaves unexplained.

    Attributes
    ----------
    alikeness
        Correlation of readings that follow each other; 0 if the times are not known.
    std
        Standard deviation, 1 for counts.
    step_s
        Usual time from one reading to the next.
    """

    alikeness: float
    std: float
    step_s: float


def as_counted(survey: RadiationSurvey, first_fit: FirstFit) -> tuple[RadiationSurvey, float]:
    """Return the survey as counted, and the smoothing time of the detector in seconds, 0: none."""
    smoothing_s = 0.0
    if survey.flight is not None:
        begin = survey.only(np.argsort(survey.flight.times_s, kind='stable')[:MOST_TRIED])
        smoothing_s = _smoothing_s(begin, first_fit)
    survey = unsmoothed(survey, smoothing_s)
    return _with_noise(survey, first_fit) if survey.is_nominal else survey, smoothing_s


def unsmoothed(survey: RadiationSurvey, smoothing_s: float) -> RadiationSurvey:
    """Return the survey as counted, where it shows running means over so many seconds."""
    flight = survey.flight
    if flight is None or smoothing_s == 0.0:
        return survey
    before, after = _neighbours(flight)
    kept = np.exp(-(flight.times_s[after] - flight.times_s[before]) / smoothing_s)
    rates = survey.net_counts / survey.exposures
    counted = rates.copy()
    counted[after] = (rates[after] - kept * rates[before]) / np.maximum(1.0 - kept, 1e-3)
    counts = np.maximum(counted * survey.exposures + survey.dark_counts, 0.0)
    return replace(survey, counts=counts)


def _with_noise(survey: RadiationSurvey, first_fit: FirstFit) -> RadiationSurvey:
    """Return a survey of dose rates alone with no more counts than their noise tells."""
    for _ in range(NOISE_ROUNDS):
        share = 1.0 / _left(*first_fit(survey, False, None)).std ** 2
        if math.log(share) > -LEAST_FALL:
            break
        survey = replace(survey, counts=survey.counts * share, exposures=survey.exposures * share)
    return survey


def _smoothing_s(survey: RadiationSurvey, first_fit: FirstFit) -> float:
    """Return the time constant with the least left by golden sections, 0 if it is hardly less."""
    if not _is_smooth(survey) or (
        _left(*first_fit(survey, False, None)).alikeness < LARGEST_ALIKENESS
    ):
        return 0.0
    likelihood, fit = first_fit(survey, True, None)
    first = math.log(_left(likelihood, fit).std)

    def left(log_s: float) -> float:
        smoothing_s = math.exp(log_s)
        tried = unsmoothed(survey, smoothing_s)
        if tried.net_counts.sum() > MOST_COUNTS * survey.net_counts.sum():
            return math.inf
        found = _left(*first_fit(tried, True, fit))
        return math.log(-found.std * math.expm1(-found.step_s / smoothing_s))

    low, high = (math.log(one) for one in RANGE_S)
    inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)]
    values = [left(one) for one in inner]
    while high - low > RANGE_LOG:
        if values[0] < values[1]:
            high, inner = inner[1], [inner[1] - GOLDEN * (inner[1] - low), inner[0]]
            values = [left(inner[0]), values[0]]
        else:
            low, inner = inner[0], [inner[1], inner[0] + GOLDEN * (high - inner[0])]
            values = [values[1], left(inner[1])]
    best = min(range(2), key=lambda k: values[k])
    return math.exp(inner[best]) if values[best] < first - LEAST_FALL else 0.0


def _is_smooth(survey: RadiationSurvey) -> bool:
    """Return whether readings scatter less from one to the next than counts do.

    Third differences are of the noise alone: neither sources nor uneven ground change so quickly.
    Those of independent readings have a correlation of -0.75 with the next.
    """
    flight = survey.flight
    if flight is None or survey.size < FEWEST_READINGS:
        return False
    order = np.lexsort((flight.times_s, flight.vehicles))
    rates = (survey.net_counts / survey.exposures)[order]
    if are_computed(rates):
        return False
    usual = np.lib.stride_tricks.sliding_window_view(rates, 4).mean(axis=1)
    mean = float(rates.mean())
    exposures = np.lib.stride_tricks.sliding_window_view(survey.exposures[order], 4)
    variances = np.maximum(usual, 0.1 * mean) * (exposures**-1.0 @ THIRD_DIFFERENCE**2)
    same = flight.vehicles[order]
    is_one = same[3:] == same[:-3]
    bends = np.diff(rates, 3) / np.sqrt(variances)
    squares = np.sort(bends[is_one] ** 2)
    if not survey.is_nominal:
        return bool(squares[: math.ceil(KEPT_SHARE * len(squares))].mean() < LARGEST_SCATTER)
    clipped = np.clip(
        bends / math.sqrt(max(float(squares.mean()), 1e-30)), -LARGEST_MISS, LARGEST_MISS
    )
    pairs = is_one[1:] & is_one[:-1]
    squared = max(float((clipped**2)[1:][pairs].sum()), 1e-30)
    alike = float((clipped[1:] * clipped[:-1])[pairs].sum()) / squared
    return bool(alike > LEAST_BEND)


def _neighbours(flight: Flight) -> tuple[IndexArray, IndexArray]:
    """Return each reading with a next one of the same vehicle, and this."""
    order = np.lexsort((flight.times_s, flight.vehicles))
    same = np.diff(flight.vehicles[order]) == 0
    return order[:-1][same], order[1:][same]


def _left(likelihood: Likelihood, fit: Fit) -> Left:
    survey = likelihood.survey
    expected, weights = likelihood.expected(fit.parameters), likelihood.weights(fit.parameters)
    misses = (survey.counts - expected) * np.sqrt(weights / expected)
    std = max(_std(misses), 1e-12)
    if survey.flight is None:
        return Left(0.0, std, 1.0)
    before, after = _neighbours(survey.flight)
    clipped = np.clip(misses / std, -LARGEST_MISS, LARGEST_MISS)
    times_s = survey.flight.times_s
    alikeness = float((clipped[before] * clipped[after]).sum() / max((clipped**2).sum(), 1e-12))
    return Left(alikeness, std, float(np.median(times_s[after] - times_s[before])))


def _std(misses: FloatArray) -> float:
    """Return the standard deviation but for the largest misses."""
    std = float(np.sqrt(np.mean(misses**2)))
    for _ in range(5):
        std = float(np.sqrt(np.mean(np.minimum(np.abs(misses), LARGEST_MISS * std) ** 2)))
    return std
