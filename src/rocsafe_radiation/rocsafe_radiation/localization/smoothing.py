# SPDX-License-Identifier: Apache-2.0
"""What a detector counted, where it shows a running mean or dose rates of unknown noise.

A ratemeter with the time constant T shows after each interval dt the mean r of it as

    y_i = a y_{i-1} + (1 - a) r_i,    a = exp(-dt / T)

so that r_i = (y_i - a y_{i-1}) / (1 - a) is what it counted, and independent of the readings
before. One that shows the mean of the last N has counted r_i = N (y_i - y_{i-1}) + r_{i-N}.

T follows from the noise, if that of the counts is known. Otherwise it is the one with the least
left unexplained by sources and background, in the scale of the y_i.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_radiation.localization.likelihood import Fit, Likelihood
from rocsafe_radiation.localization.noise_spectrum import running_mean, runs_of
from rocsafe_radiation.readings.flight import Flight
from rocsafe_radiation.readings.survey import RadiationSurvey

# Fit of a survey in one setting: with the clock of the fixes or not, begun at another or at none.
FirstFit = Callable[[RadiationSurvey, bool, Fit | None], tuple[Likelihood, Fit]]
# Misses of readings that follow each other are alike by less than this where they are counts: four
# standard deviations of 400 readings. Lines that begin anew on the same side look like noise.
LARGEST_ALIKENESS = 0.2
# Time constants looked for, seconds, and how well the logarithm of one is found.
RANGE_S, RANGE_LOG = (0.7, 20.0), 0.5
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
# So many readings at the begin of the flight tell it.
MOST_TRIED = 1500
# Counts follow from means of the last N but for what all N-th of them have in common: this is the
# mean of so many of them, so that roundings do not add up.
MEMBERS = 45
LARGEST_MISS = 3.0
# Counts are fewer where readings scatter more, by a share that is told by so many fits, unless its
# logarithm is less than this.
NOISE_ROUNDS, LEAST_FALL = 3, 0.2


def as_counted(survey: RadiationSurvey, first_fit: FirstFit) -> tuple[RadiationSurvey, float]:
    """Return the survey as counted, and the time over which readings are means, s, 0: none."""
    flight, found = survey.flight, running_mean(survey)
    smoothing_s = 0.0
    is_smooth = found is not None and (
        _alikeness(*first_fit(_begin(survey), False, None)) > LARGEST_ALIKENESS
    )
    if flight is not None and found is not None and is_smooth:
        before, after = _neighbours(flight)
        step_s = float(np.median(flight.times_s[after] - flight.times_s[before]))
        smoothing_s = found.readings * step_s
        if found.is_even:
            survey = unaveraged(survey, round(found.readings))
        else:
            if survey.is_nominal:
                smoothing_s = _smoothing_s(_begin(survey), step_s, first_fit)
            survey = unsmoothed(survey, smoothing_s)
    return _with_noise(survey, first_fit) if survey.is_nominal else survey, smoothing_s


def _begin(survey: RadiationSurvey) -> RadiationSurvey:
    """Return the survey of the first readings."""
    if survey.flight is None:
        return survey
    return survey.only(np.argsort(survey.flight.times_s, kind='stable')[:MOST_TRIED])


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


def unaveraged(survey: RadiationSurvey, length: int) -> RadiationSurvey:
    """Return the survey as counted, where it shows the means of the last `length` readings."""
    if survey.flight is None:
        return survey
    rates = survey.net_counts / survey.exposures
    counted = rates.copy()
    for run in runs_of(survey.flight):
        if len(run) < 2 * length:
            continue
        # The mean of those about each reading; about the first and the last, the nearest one.
        numbers = np.clip(np.arange(len(run)) + length // 2, length - 1, len(run) - 1)
        about, shown = rates[run][numbers], rates[run]
        own = about.copy()
        for number in range(length, len(run)):
            own[number] = length * (shown[number] - shown[number - 1]) + own[number - length]
        weights = 1.0 / np.maximum(about, 1e-12)
        for first in range(length):
            members = slice(first, None, length)
            span = np.ones(min(MEMBERS, len(own[members])))
            sums = np.convolve(weights[members], span, 'same')
            apart = np.convolve((own - about)[members] * weights[members], span, 'same')
            own[members] -= apart / sums
        counted[run] = own
    counts = np.maximum(counted * survey.exposures + survey.dark_counts, 0.0)
    return replace(survey, counts=counts)


def _with_noise(survey: RadiationSurvey, first_fit: FirstFit) -> RadiationSurvey:
    """Return a survey of dose rates alone with no more counts than their noise tells."""
    for _ in range(NOISE_ROUNDS):
        share = 1.0 / _left(*first_fit(survey, False, None)) ** 2
        if math.log(share) > -LEAST_FALL:
            break
        survey = replace(survey, counts=survey.counts * share, exposures=survey.exposures * share)
    return survey


def _smoothing_s(survey: RadiationSurvey, step_s: float, first_fit: FirstFit) -> float:
    """Return the time constant with the least left by golden sections."""
    _, fit = first_fit(survey, True, None)

    def left(log_s: float) -> float:
        smoothing_s = math.exp(log_s)
        found = _left(*first_fit(unsmoothed(survey, smoothing_s), True, fit))
        return math.log(-found * math.expm1(-step_s / smoothing_s))

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
    return math.exp(inner[0] if values[0] < values[1] else inner[1])


def _neighbours(flight: Flight) -> tuple[IndexArray, IndexArray]:
    """Return each reading with a next one of the same vehicle, and this."""
    order = np.lexsort((flight.times_s, flight.vehicles))
    same = np.diff(flight.vehicles[order]) == 0
    return order[:-1][same], order[1:][same]


def _misses(likelihood: Likelihood, fit: Fit) -> FloatArray:
    """Return what a fit leaves unexplained, with a standard deviation of 1 for counts."""
    expected, weights = likelihood.expected(fit.parameters), likelihood.weights(fit.parameters)
    return np.asarray((likelihood.survey.counts - expected) * np.sqrt(weights / expected))


def _left(likelihood: Likelihood, fit: Fit) -> float:
    """Return the standard deviation of what a fit leaves unexplained."""
    return max(_std(_misses(likelihood, fit)), 1e-12)


def _alikeness(likelihood: Likelihood, fit: Fit) -> float:
    """Return the correlation of what is left of readings that follow each other."""
    flight, misses = likelihood.survey.flight, _misses(likelihood, fit)
    if flight is None:
        return 0.0
    before, after = _neighbours(flight)
    limit = LARGEST_MISS * max(_std(misses), 1e-12)
    clipped = np.clip(misses, -limit, limit)
    squares = float((clipped**2).sum())
    return float((clipped[before] * clipped[after]).sum()) / max(squares, 1e-12)


def _std(misses: FloatArray) -> float:
    """Return the standard deviation but for the largest misses."""
    std = float(np.sqrt(np.mean(misses**2)))
    for _ in range(5):
        std = float(np.sqrt(np.mean(np.minimum(np.abs(misses), LARGEST_MISS * std) ** 2)))
    return std
