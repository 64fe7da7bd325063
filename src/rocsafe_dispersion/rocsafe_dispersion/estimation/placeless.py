# SPDX-License-Identifier: Apache-2.0
"""Whether readings are better explained without the places where they were taken.

Releases tell what a reading is at its place and in its wind. Two descriptions that know neither
place nor wind compete with them: a reading is like any other one of its instrument, or like those
just before and after it. Readings of another place, in another order, or of a detector that steps
are nonsense as a plume, but a plume that comes and goes enough may hold them all the same: then
one of these two tells readings that are left out better.

Both are densities by kernels (Student's t) over the other readings, on a scale that is even near
the noise and logarithmic above. Releases tell a reading left out by their hypotheses, each
weighted by one over the likelihood of that reading (Gelfand and others 1992).
"""

import numpy as np
from scipy import special

from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.estimation.reading_density import FREEDOM
from rocsafe_geo.arrays import FloatArray, IndexArray

# Width of the kernels, in units of the scale, noises near the background; share of the kernels
# of the neighbours in time where those tell a reading, the rest being those of any reading.
_WIDTH, _NEIGHBOURS_SHARE, _NEIGHBOURS = 0.4, 0.7, 2
_PEAK = 0.375
# Probability that a reading is beyond a bound that another one is beyond: noise moves it across.
_SAME_BOUND = 0.95
_LEAST = 1e-12


def gain_of_places(survey: GasSurvey, backgrounds_g_m3: FloatArray, logs: FloatArray) -> float:
    """Return the logarithm of the odds of releases against readings without places.

    Parameters
    ----------
    survey
        The readings.
    backgrounds_g_m3
        Backgrounds of the instruments, g/m^3.
    logs : (p, n)
        Logarithms of the likelihood of each reading for equally probable hypotheses.
    """
    left_out = np.log(len(logs)) - special.logsumexp(-logs, axis=0)
    above = (survey.values_g_m3 - backgrounds_g_m3[survey.instruments]) / survey.std_g_m3
    scaled = np.arcsinh(above / 2.0)
    slope = 1.0 / (survey.std_g_m3 * np.hypot(2.0, above))
    any_other, neighbours = np.zeros(len(scaled)), np.zeros(len(scaled))
    for instrument in np.unique(survey.instruments):
        own = np.flatnonzero(survey.instruments == instrument)
        own = own[np.argsort(survey.times_s[own], kind='stable')]
        if len(own) <= _NEIGHBOURS:
            # Too few to tell each other: they speak for nobody.
            any_other[own] = neighbours[own] = left_out[own]
            continue
        kernels = _kernels(survey, own, scaled, slope)
        np.fill_diagonal(kernels, 0.0)
        anywhere = kernels.sum(axis=1) / (len(own) - 1)
        apart = np.abs(np.subtract.outer(np.arange(len(own)), np.arange(len(own))))
        near = (apart > 0) & (apart <= _NEIGHBOURS // 2)
        beside = (kernels * near).sum(axis=1) / near.sum(axis=1)
        any_other[own] = np.log(anywhere)
        neighbours[own] = np.log(_NEIGHBOURS_SHARE * beside + (1.0 - _NEIGHBOURS_SHARE) * anywhere)
    return float(min((left_out - other).sum() for other in (any_other, neighbours)))


def _kernels(
    survey: GasSurvey, own: IndexArray, scaled: FloatArray, slope: FloatArray
) -> FloatArray:
    """Return what each reading (rows) has from each other one (columns), (m, m).

    A density per g/m^3 of a value, a probability of a bound.
    """
    offsets = np.subtract.outer(scaled[own], scaled[own]) / _WIDTH
    values = _PEAK * (1.0 + offsets**2 / FREEDOM) ** -2.5 / _WIDTH * slope[own, None]
    below = special.stdtr(FREEDOM, offsets)
    low, high = survey.is_below[own], survey.is_above[own]
    found = np.where(low[:, None], below, np.where(high[:, None], 1.0 - below, values))
    found[(low[:, None] & low) | (high[:, None] & high)] = _SAME_BOUND
    return np.maximum(found, _LEAST)
