# SPDX-License-Identifier: Apache-2.0
"""The background under a photopeak, predicted from a window of the spectrum above it.

Photons of the source have less energy than a window above its lines. Photons of the ground and the
sky scatter down from that window into the peak. Where the window has more counts, so has the
background under the peak.
"""

import numpy as np

from rocsafe_geo.arrays import FloatArray

# Readings this near to each other are over the same ground.
SMOOTHING_M = 8.0
# 200 counts predict the background to 7 %, better than one reading of the peak does.
FEWEST_COUNTS = 200.0
LARGEST_SMOOTHING_M = 1000.0
# Readings at a time, so that memory stays small.
BLOCK = 1024


def background_shape(
    positions_enu_m: FloatArray, reference_counts: FloatArray, smoothing_m: float = SMOOTHING_M
) -> FloatArray:
    """Return the background at each reading relative to its mean, shape (n,).

    `reference_counts` of the window above, shape (n,), are averaged over neighbours with a
    Gaussian of `smoothing_m` or, where that holds fewer than 200 counts for half the readings, of
    twice that and so on.

    Raises
    ------
    ValueError
        If nothing was counted in the window.
    """
    if not reference_counts.sum() > 0.0:
        raise ValueError('reference_counts must hold at least one count')
    sums, weights = _sums(positions_enu_m[:, :2], reference_counts, smoothing_m)
    while np.median(sums) < FEWEST_COUNTS and smoothing_m < LARGEST_SMOOTHING_M:
        smoothing_m *= 2.0
        sums, weights = _sums(positions_enu_m[:, :2], reference_counts, smoothing_m)
    smooth = sums / weights
    mean = float(reference_counts.mean())
    # At least a tenth of the mean: a quiet place may have had no count by chance.
    return np.asarray(np.maximum(smooth / mean, 0.1))


def _sums(
    places: FloatArray, counts: FloatArray, smoothing_m: float
) -> tuple[FloatArray, FloatArray]:
    """Return around each place the weighted sum of `counts` and the sum of weights."""
    sums, totals = np.empty(len(places)), np.empty(len(places))
    for start in range(0, len(places), BLOCK):
        block = places[start : start + BLOCK]
        squares = ((block[:, None, :] - places[None, :, :]) ** 2).sum(axis=2)
        weights = np.exp(-squares / (2.0 * smoothing_m * smoothing_m))
        sums[start : start + BLOCK] = weights @ counts
        totals[start : start + BLOCK] = weights.sum(axis=1)
    return sums, totals
