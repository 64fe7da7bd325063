# SPDX-License-Identifier: Apache-2.0
"""Gas sensors that follow slowly: found by how they fall, and undone.

A sensor with the time constant T shows, after the interval dt in which the gas was x,

    y_i = a y_{i-1} + (1 - a) x_i,    a = exp(-dt / T)

It never falls faster than by the factor a, and falls just so wherever the gas is gone: its
quickest falls are alike, and end far above its noise. Those of a fast sensor end in the noise.
"""

import math
from dataclasses import replace

import numpy as np

from rocsafe_dispersion.estimation.gas_survey import PROBABLE_ERROR, GasSurvey
from rocsafe_geo.arrays import FloatArray, IndexArray

# A fall begins so many noises above the background, and must end so many above it.
FALL_FROM, FALL_TO = 10.0, 3.0
# A tenth of the falls may be quicker than the response; so many of them, and this share of all,
# must be alike to so much in their logarithm.
QUICK_PARTS = 10
FEWEST_ALIKE, ALIKE_SHARE, ALIKE = 5, 0.3, 0.15
# Sensors that keep less of a reading until the next one are fast enough.
LEAST_KEPT = 0.15
# Falls are taken over so many readings; those that keep more than this are lost in the noise.
STEPS, MOST_KEPT = (1, 2, 4, 8, 16, 32), 0.8
# This share of the readings may be too low, by accident, to be of clean air.
CLEAN_QUANTILE = 0.02


def without_delay(survey: GasSurvey) -> tuple[GasSurvey, dict[int, float]]:
    """Return the survey as fast sensors had made it, and time constants by slow instrument, s."""
    values, std = survey.values_g_m3.copy(), survey.std_g_m3.copy()
    found: dict[int, float] = {}
    for instrument in np.unique(survey.instruments).tolist():
        own = _in_order(survey, instrument)
        response_s = _response_s(survey, own)
        if response_s == 0.0:
            continue
        found[instrument] = response_s
        kept = np.exp(-np.diff(survey.times_s[own]) / response_s)
        passed = np.maximum(1.0 - kept, 1e-3)
        shown = survey.values_g_m3[own]
        values[own[1:]] = (shown[1:] - kept * shown[:-1]) / passed
        std[own[1:]] *= np.sqrt(1.0 + kept**2) / passed
    return replace(survey, values_g_m3=values, std_g_m3=std), found


def _in_order(survey: GasSurvey, instrument: int) -> IndexArray:
    """Return the values of an instrument in the order of their times; bounds are none."""
    own = (survey.instruments == instrument) & ~survey.is_below & ~survey.is_above
    numbers = np.flatnonzero(own)
    return numbers[np.argsort(survey.times_s[numbers], kind='stable')]


def _response_s(survey: GasSurvey, own: IndexArray) -> float:
    """Return the time constant of readings that follow each other; 0: fast."""
    shown = survey.values_g_m3[own]
    if len(own) <= FEWEST_ALIKE:
        return 0.0
    # What readings that follow each other differ by: what is stated may be that of the gas.
    bends = float(np.median(np.abs(np.diff(shown, 2)))) / (PROBABLE_ERROR * math.sqrt(6.0))
    noise = max(min(float(np.median(survey.std_g_m3[own])), bends), 1e-12)
    above: FloatArray = (shown - np.quantile(shown, CLEAN_QUANTILE)) / noise
    for steps in STEPS:
        found = _from_falls(survey.times_s[own], above, steps)
        if found > 0.0:
            return found
    return 0.0


def _from_falls(times_s: FloatArray, above: FloatArray, steps: int) -> float:
    """Return the time constant of falls over so many steps; 0: fast, or too few falls."""
    spans_s = times_s[steps:] - times_s[:-steps]
    is_fall = (above[:-steps] > FALL_FROM) & (above[steps:] < above[:-steps]) & (spans_s > 0.0)
    if steps > 1:
        # Half of the way down after half of the time, in logarithms: from one crossing of a steady
        # plume to the next it is not.
        logs = np.log(np.maximum(above, 1.0))
        bends = 2.0 * logs[steps // 2 : -(steps // 2)] - logs[:-steps] - logs[steps:]
        is_fall &= np.abs(bends) < 2.0 * ALIKE
    falls = np.flatnonzero(is_fall)
    if len(falls) < FEWEST_ALIKE:
        return 0.0
    shares = np.maximum(above[falls + steps], 1.0) / above[falls]
    rates = -np.log(shares) / spans_s[falls]
    # Noise makes a few quicker.
    quick = int(np.argsort(rates)[-1 - max(1, len(falls) // QUICK_PARTS)])
    alike = np.flatnonzero(np.abs(np.log(rates / rates[quick])) < ALIKE)
    is_slow = (
        LEAST_KEPT < shares[quick] < MOST_KEPT
        and above[falls[quick] + steps] > FALL_TO
        and len(alike) >= max(FEWEST_ALIKE, ALIKE_SHARE * len(falls))
    )
    return 1.0 / float(np.median(rates[alike])) if is_slow else 0.0
