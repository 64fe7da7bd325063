# SPDX-License-Identifier: Apache-2.0
"""Errors of the fixes of one vehicle, as their residuals show them.

The errors of a receiver drift: each is like the one before. Many fixes then say hardly more of the
place of the whole block than a few, and the residuals, from which the block's own shift, turn and
scale were taken, look smaller than the errors. The errors are modelled as autoregressive of first
order; correlation and standard deviation are drawn from their posterior: the restricted likelihood
(Patterson and Thompson, Biometrika 58, 1971) with priors, which decide where fixes are few.
"""

import numpy as np

from rocsafe_geo.arrays import FloatArray

CORRELATIONS = np.linspace(0.0, 0.98, 50)
PRIOR_POWER = 1.0
"""Prior of the correlation: (1 - correlation) to this power; short flights hardly show it.

Chosen on the part `develop` of ``benchmarks/mapping_fixes.py``.
"""

LOG_STDS = np.linspace(-6.0, 6.0, 121)
"""Standard deviations that are tried, as logarithms over the claimed one.

Their prior is the standard normal distribution: most receivers err by a third to three times of
what they claim.
"""

SIMILARITY_SIZE = 4
"""Shift (2), turn and scale of a block."""

LARGEST_SCATTERS = 4.0
"""Residuals are cut at this many times their robust scatter: wrong fixes have little weight."""

NORMAL_MEDIAN_RADIUS = 1.1774


def fix_errors_m(
    fixes_m: FloatArray,
    found_m: FloatArray,
    claimed_m: float,
    samples: int,
    rng: np.random.Generator,
) -> FloatArray:
    """Return random errors that the fixes may have.

    Parameters
    ----------
    fixes_m, found_m
        Fixes and places found by the adjustment, (east, north), shape (n, 2), in time order.
    claimed_m
        Standard deviation that the fixes claim.
    samples
        Number of draws.

    Returns
    -------
    (n, 2, samples)
        Errors in metres.
    """
    off = _cut(fixes_m - found_m)
    design = _similarity(found_m - found_m.mean(axis=0))
    stds_m = claimed_m * np.exp(LOG_STDS)
    logs = np.array([_log_likelihood(off, design, alike, stds_m) for alike in CORRELATIONS])
    logs += PRIOR_POWER * np.log1p(-CORRELATIONS)[:, np.newaxis] - 0.5 * LOG_STDS**2
    weights = np.exp(logs - logs.max()).ravel()
    chosen = rng.choice(len(weights), samples, p=weights / weights.sum())
    alike, std_m = CORRELATIONS[chosen // len(stds_m)], stds_m[chosen % len(stds_m)]
    errors: FloatArray = rng.standard_normal((len(off), 2, samples))
    for number in range(1, len(off)):
        errors[number] = alike * errors[number - 1] + np.sqrt(1.0 - alike**2) * errors[number]
    return errors * std_m


def _cut(off: FloatArray) -> FloatArray:
    """Return residuals (n, 2), the largest ones shortened."""
    lengths = np.linalg.norm(off - np.median(off, axis=0), axis=1)
    limit = LARGEST_SCATTERS * float(np.median(lengths)) / NORMAL_MEDIAN_RADIUS
    return off * np.minimum(1.0, limit / np.maximum(lengths, 1e-9))[:, np.newaxis]


def _similarity(places: FloatArray) -> FloatArray:
    """Return the derivatives of places (n, 2) to shift, turn and scale, (n, 2, 4)."""
    design = np.zeros((len(places), 2, SIMILARITY_SIZE))
    design[:, 0, 0] = design[:, 1, 1] = 1.0
    design[:, 0, 2], design[:, 1, 2] = -places[:, 1], places[:, 0]
    design[:, :, 3] = places
    return design


def _log_likelihood(
    off: FloatArray, design: FloatArray, alike: float, stds_m: FloatArray
) -> FloatArray:
    """Return the logarithm of the restricted likelihood of standard deviations (k,)."""
    freedom = off.size - SIMILARITY_SIZE
    if freedom <= 0:
        return np.zeros(len(stds_m))
    rows = _whitened(design, alike).reshape(-1, SIMILARITY_SIZE)
    values = _whitened(off, alike).ravel()
    found = np.linalg.lstsq(rows, values, rcond=None)[0]
    square = float(np.sum((values - rows @ found) ** 2))
    _, log_design = np.linalg.slogdet(rows.T @ rows)
    log_variance = 2.0 * (len(off) - 1) * np.log1p(-(alike**2))
    logs: FloatArray = -freedom * np.log(stds_m) - 0.5 * square / stds_m**2
    return logs - 0.5 * (log_variance + log_design)


def _whitened(values: FloatArray, alike: float) -> FloatArray:
    """Return values (n, ...) without the correlation of each with the one before."""
    fresh = (values[1:] - alike * values[:-1]) / np.sqrt(1.0 - alike**2)
    return np.concatenate([values[:1], fresh])
