# SPDX-License-Identifier: Apache-2.0
"""Weights of readings, and probabilities of their being shaded."""

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.readings.survey import RadiationSurvey

# Shares of the dose rate of sources that a shaded reading may keep.
SHADES = (0.8, 0.66, 0.54, 0.44, 0.36, 0.29, 0.22, 0.14, 0.06, 0.0)


def log_sums(logs: FloatArray) -> FloatArray:
    """Return the logarithm of the sum of exponentials of each column."""
    if len(logs) == 1:
        return logs[0]
    top = logs.max(axis=0)
    return np.asarray(top + np.log(np.exp(logs - top).sum(axis=0)))


def chances_of(logs: FloatArray) -> FloatArray:
    """Return the share of each row in the sum of exponentials of its column."""
    return np.asarray(np.exp(logs - log_sums(logs)))


def background_level_usvh(survey: RadiationSurvey) -> float:
    """Return the mean rate of the lowest fifth of the readings."""
    rates = survey.counts / survey.exposures
    quiet = rates <= np.quantile(rates, 0.2)
    level = survey.counts[quiet].sum() / survey.exposures[quiet].sum()
    return max(float(level), 1e-6)


def weights_of(survey: RadiationSurvey, rho: float) -> FloatArray:
    """Return the weight of each reading whose excess scatters by a share `rho`, shape (n,)."""
    excess = survey.counts - survey.exposures * background_level_usvh(survey)
    excess = np.maximum(excess, 0.0)
    variance = rho * rho * excess * excess / np.maximum(survey.counts, 1.0)
    return np.asarray(1.0 / (1.0 + variance))
