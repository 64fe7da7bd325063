# SPDX-License-Identifier: Apache-2.0
"""Errors of the fixes of one vehicle, as their residuals show them.

The errors of a receiver drift: each is like the one before. Many fixes then say hardly more of the
place of the whole block than a few, and the residuals, from which the block's own shift, turn and
scale were taken, look smaller than the errors. The errors are modelled as autoregressive of first
order; correlation and variance are drawn from their posterior by the restricted likelihood
(Patterson and Thompson, Biometrika 58, 1971) with a prior that favours small correlations.
"""

import numpy as np

from rocsafe_geo.arrays import FloatArray

CORRELATIONS = np.linspace(0.0, 0.98, 50)
PRIOR_POWER = 3.0
"""Prior of the correlation: (1 - correlation) to this power; short flights hardly show it.

Chosen on the part `develop` of ``benchmarks/mapping_families.py``.
"""

SIMILARITY_SIZE = 4
"""Shift (2), turn and scale of a block."""

LARGEST_SCATTERS = 4.0
"""Residuals are cut at this many times their robust scatter: wrong fixes have little weight."""

NORMAL_MEDIAN_RADIUS = 1.1774
LEAST_FIXES = 10
"""With fewer fixes the residuals do not show a correlation."""


def fix_errors_m(
    fixes_m: FloatArray, found_m: FloatArray, samples: int, rng: np.random.Generator
) -> FloatArray | None:
    """Return random errors that the fixes may have; None for fewer than ten fixes.

    Parameters
    ----------
    fixes_m, found_m
        Fixes and places found by the adjustment, (east, north), shape (n, 2), in time order.
    samples
        Number of draws.

    Returns
    -------
    (n, 2, samples)
        Errors in metres.
    """
    count = len(fixes_m)
    if count < LEAST_FIXES:
        return None
    off = _cut(fixes_m - found_m)
    design = _similarity(found_m - found_m.mean(axis=0))
    fits = [_restricted(off, design, alike) for alike in CORRELATIONS]
    logs = np.array([log for log, _ in fits]) + PRIOR_POWER * np.log1p(-CORRELATIONS)
    weights = np.exp(logs - logs.max())
    chosen = rng.choice(len(CORRELATIONS), samples, p=weights / weights.sum())
    squares = np.array([square for _, square in fits])[chosen]
    freedom = 2 * count - SIMILARITY_SIZE
    std_m = np.sqrt(squares / rng.chisquare(freedom, samples))
    alike = CORRELATIONS[chosen]
    errors: FloatArray = rng.standard_normal((count, 2, samples))
    for number in range(1, count):
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


def _restricted(off: FloatArray, design: FloatArray, alike: float) -> tuple[float, float]:
    """Return the logarithm of the restricted likelihood, and the sum of whitened squares."""
    rows = _whitened(design, alike).reshape(-1, SIMILARITY_SIZE)
    values = _whitened(off, alike).ravel()
    found = np.linalg.lstsq(rows, values, rcond=None)[0]
    square = max(float(np.sum((values - rows @ found) ** 2)), 1e-12)
    _, log_design = np.linalg.slogdet(rows.T @ rows)
    freedom = len(values) - SIMILARITY_SIZE
    log_variance = 2.0 * (len(off) - 1) * np.log1p(-(alike**2))
    return -0.5 * float(log_variance + log_design + freedom * np.log(square)), square


def _whitened(values: FloatArray, alike: float) -> FloatArray:
    """Return values (n, ...) without the correlation of each with the one before."""
    fresh = (values[1:] - alike * values[:-1]) / np.sqrt(1.0 - alike**2)
    return np.concatenate([values[:1], fresh])
