# SPDX-License-Identifier: Apache-2.0
"""Running means, told by the spectrum of the noise of readings.

Counts are independent: their noise is alike at all frequencies w. A running mean lowers it by the
square of the absolute value of its frequency response (Oppenheim and Schafer 2010, chapter 2): one
that forgets by a factor of e in T readings, with a = exp(-1/T), or the mean of the last N,

    (1 - a)^2 / (1 - 2 a cos w + a^2),    (sin(N w / 2) / (N sin(w / 2)))^2

Only quick changes are looked at, which neither sources nor uneven ground make: third differences,
with the response (2 sin(w / 2))^6, of windows of readings (Welch 1967). Of the running means, with
the noise of counts and that of rounding, the one with the highest likelihood of the spectrum is
taken (Whittle 1953).
"""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_hazard.value_runs import are_computed
from rocsafe_radiation.readings.flight import Flight
from rocsafe_radiation.readings.survey import RadiationSurvey

# Readings of a window, every half of which another one begins, and the lowest frequency looked at,
# in periods a window.
WINDOW, LOWEST = 32, 5
# Windows with more noise than this, in medians of all, are beside a source.
MOST_MEDIANS = 3.0
# After so many usual steps without a reading, another run of readings begins.
LONGEST_STEP = 1.5
# Standard deviation of the logarithm of the noise over that of counts; where counts are not told,
# scintillators and Geiger tubes are a factor of up to 1000 apart.
NOISE_STD, UNTOLD_NOISE_STD = 0.3, 2.0
LOG_NOISES = np.linspace(-7.0, 7.0, 71)
# Lengths in readings of the means that forget, and of the means of the last readings: longer ones
# of these look alike in windows of 32.
FORGETTING, LENGTHS = 0.5 * 1.25 ** np.arange(18), np.arange(2.0, 13.0)
# One survey in 100 is of running means, all of these alike likely.
RARENESS = math.log(100.0 * (len(FORGETTING) + len(LENGTHS)))


@dataclass(frozen=True, slots=True)
class RunningMean:
    """A running mean.

    Attributes
    ----------
    readings
        Readings in which it forgets by a factor of e, or of which it is the mean.
    is_even
        Whether it is the mean of the last readings, all alike.
    """

    readings: float
    is_even: bool


def running_mean(survey: RadiationSurvey) -> RunningMean | None:
    """Return the running mean that readings show; None if they show none, or it cannot be told."""
    if survey.flight is None:
        return None
    rates = survey.net_counts / survey.exposures
    runs = runs_of(survey.flight)
    if are_computed(rates[np.concatenate(runs)]):
        return None
    windows = [
        run[start : start + WINDOW + 3]
        for run in runs
        for start in range(0, len(run) - WINDOW - 2, WINDOW // 2)
    ]
    if not windows:
        return None
    rows = np.array(windows)
    noises = np.maximum(rates[rows].mean(axis=1), 1e-12) / survey.exposures[rows].mean(axis=1)
    powers = np.abs(np.fft.rfft(TAPER * np.diff(rates[rows], 3)))[:, LOWEST:] ** 2
    powers /= noises[:, None]
    totals = (powers / _leaked(THIRD)).sum(axis=1)
    kept = totals <= MOST_MEDIANS * np.median(totals)
    steps = np.abs(np.diff(rates[np.concatenate(runs)]))
    step = float(steps[steps > STEP_SHARE * rates.mean()].min(initial=math.inf))
    rounding = 0.0 if math.isinf(step) else float((step * step / 12.0 / noises[kept]).mean())
    evidence = _evidence(powers[kept].mean(axis=0), rounding) * int(kept.sum())
    spread = UNTOLD_NOISE_STD if survey.is_nominal else NOISE_STD
    best = (evidence - 0.5 * (LOG_NOISES[:, None] / spread) ** 2).max(axis=0)
    index = int(np.argmax(best[1:]))
    if best[1 + index] - best[0] < RARENESS:
        return None
    lengths = np.concatenate([FORGETTING, LENGTHS])
    return RunningMean(readings=float(lengths[index]), is_even=index >= len(FORGETTING))


def runs_of(flight: Flight) -> list[IndexArray]:
    """Return the readings of each vehicle in the order of their times, split at gaps."""
    order = np.lexsort((flight.times_s, flight.vehicles))
    steps_s, same = np.diff(flight.times_s[order]), np.diff(flight.vehicles[order]) == 0
    usual_s = float(np.median(steps_s[same])) if same.any() else 0.0
    ends = np.flatnonzero(~same | (steps_s > LONGEST_STEP * usual_s)) + 1
    return np.split(order, ends)


def _evidence(powers: FloatArray, rounding: float) -> FloatArray:
    """Return the logarithm of the likelihood of a spectrum by one window, (noises, means)."""
    expected = np.exp(LOG_NOISES)[:, None, None] * _leaked(RESPONSES * THIRD)
    expected = expected + rounding * _leaked(THIRD)
    # By the taper, frequencies beside each other tell about as much as one of both.
    return np.asarray((-np.log(expected) - powers / expected).sum(axis=2) / 2.0)


def _leaked(spectrum: FloatArray) -> FloatArray:
    """Return a spectrum as the taper shows it, without the first and the last frequency."""
    return np.asarray((spectrum[..., :-2] + 4.0 * spectrum[..., 1:-1] + spectrum[..., 2:]) / 6.0)


def _responses(frequencies: FloatArray) -> FloatArray:
    """Return squared responses, (1 + means, frequencies); the first row is without a mean."""
    kept = np.exp(-1.0 / FORGETTING)[:, None]
    forgetting = (1.0 - kept) ** 2 / (1.0 - 2.0 * kept * np.cos(frequencies) + kept**2)
    lengths, halves = LENGTHS[:, None], frequencies / 2.0
    even = (np.sin(lengths * halves) / (lengths * np.sin(halves))) ** 2
    return np.concatenate([np.ones((1, len(frequencies))), forgetting, even])


# Differences of readings that are less than this share of them are of the last digits of floats.
STEP_SHARE = 1e-9
# Hann's taper, so that the power of white noise is its variance.
TAPER = np.hanning(WINDOW + 1)[:WINDOW] / math.sqrt(float((np.hanning(WINDOW + 1) ** 2).sum()))
FREQUENCIES = 2.0 * math.pi * np.arange(LOWEST - 1, WINDOW // 2 + 2) / WINDOW
THIRD = (2.0 * np.sin(FREQUENCIES / 2.0)) ** 6
RESPONSES = _responses(FREQUENCIES)
