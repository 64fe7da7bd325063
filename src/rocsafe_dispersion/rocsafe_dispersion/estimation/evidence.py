# SPDX-License-Identifier: Apache-2.0
"""Evidence that readings give for a release: the likelihood, averaged over what is not known.

The evidence is averaged over places, rates and shapes of the plume, so that it is compared with
that of one release fewer as odds (Bayes factor) and needs no penalty for the number of values.
"""

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import logsumexp

from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.estimation.rate_fit import MULTIPLES, RateFits
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_geo.arrays import FloatArray

# Before readings the logarithm of the rate is even over four decades; the likelihood is averaged
# over this share of them, about the rate that fits.
RATE_PRIOR_SHARE = float(np.log(MULTIPLES[-1] / MULTIPLES[0]) / np.log(1e4))
# Residuals are cut at this many standard deviations: a plume that is met is no correlated noise.
_CUT = 2.0
_FEWEST_PAIRS = 8
# A reading so many standard deviations above the median is within a plume.
_CLEAR = 5.0


def log_evidence(fits: Sequence[RateFits], log_priors: Sequence[float], share: float) -> float:
    """Return the logarithm of the likelihood, averaged over hypotheses, rates and shapes.

    Parameters
    ----------
    fits
        Fits of all hypotheses, which are equally probable before, for each shape of the plume.
    log_priors
        Logarithm of the prior of each shape, up to a constant.
    share
        Share of the information of the readings that counts.
    """
    priors = np.array(log_priors) - logsumexp(log_priors)
    logs = [logsumexp(fit.averaged(share)) - math.log(len(fit.log_likelihoods)) for fit in fits]
    return float(logsumexp(priors + np.array(logs)))


def independent_share(survey: GasSurvey, background_g_m3: FloatArray, least: float) -> float:
    """Return the share of readings that are independent where there is only background.

    Parameters
    ----------
    survey
        Readings.
    background_g_m3 : (instruments,)
        Their background without a release, g/m^3.
    least
        Smallest share.

    Notes
    -----
    Of n readings whose noise has the correlation rho from one to the next, (1 - rho)/(1 + rho) n
    are independent (process of first order; Bayley and Hammersley 1946). A zero that drifts is
    correlated; without this it would pass for gas.
    """
    residuals = (survey.values_g_m3 - background_g_m3[survey.instruments]) / survey.std_g_m3
    residuals = np.clip(residuals, -_CUT, _CUT)
    products, squares = [], []
    for number in np.unique(survey.instruments):
        own = np.flatnonzero(survey.instruments == number)
        row = residuals[own[np.argsort(survey.times_s[own], kind='stable')]]
        products.append(row[1:] * row[:-1])
        squares.append((row[1:] ** 2 + row[:-1] ** 2) / 2.0)
    product, square = np.concatenate(products), np.concatenate(squares)
    if len(product) < _FEWEST_PAIRS or square.sum() <= 0.0:
        return least
    rho = max(float(product.sum() / square.sum()), 0.0)
    return max((1.0 - rho) / (1.0 + rho), least)


def plume_share(survey: GasSurvey, options: LocateOptions, releases: int) -> float:
    """Return the share of the information of readings within a plume that counts.

    Parameters
    ----------
    survey
        Readings.
    options
        The largest share, and the correlation of any two readings within a plume by the error of
        the model.
    releases
        Number of plumes, which share the readings evenly.

    Notes
    -----
    Of n readings with the correlation rho of each with each, n / (1 + (n - 1) rho) are
    independent (design effect, Kish 1965). Those within a plume are the ones clearly above the
    median of their instrument.
    """
    count = 0
    for number in np.unique(survey.instruments):
        own = survey.instruments == number
        above = survey.values_g_m3[own] - np.median(survey.values_g_m3[own])
        count += int((above > _CLEAR * survey.std_g_m3[own]).sum())
    others = max(count / max(releases, 1) - 1.0, 0.0)
    return min(options.information_share, 1.0 / (1.0 + others * options.shared_error))
