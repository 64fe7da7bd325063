# SPDX-License-Identifier: Apache-2.0
"""A smoothly varying background with few parameters: bumps on a coarse grid."""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray

# Most bumps along the longer side of a survey at a spacing of one height, half as many at two. The
# time of a fit grows with the cube of their number.
LARGEST_HEIGHTS_A_SIDE = 14


def smooth_basis(
    positions_enu_m: FloatArray, height_m: float, spacing_heights: float
) -> FloatArray:
    """Return the value of each bump at each of n places, shape (n, bumps).

    Bumps are Gaussians on a square grid, each with the standard deviation 0.7 times the spacing:
    their sum is smooth. The spacing is at least `spacing_heights` heights above the ground.
    """
    east, north = positions_enu_m[:, 0], positions_enu_m[:, 1]
    extent = max(float(np.ptp(east)), float(np.ptp(north)), 1.0)
    spacing = spacing_heights * max(height_m, extent / LARGEST_HEIGHTS_A_SIDE)
    width = 0.7 * spacing
    bumps = [
        np.exp(-((east - x) ** 2 + (north - y) ** 2) / (2.0 * width * width))
        for x in _nodes(east, spacing)
        for y in _nodes(north, spacing)
    ]
    basis = np.stack(bumps, axis=1)
    # A bump far from all readings would only follow its prior.
    return np.asarray(basis[:, basis.max(axis=0) > 0.3])


def _nodes(axis: FloatArray, spacing: float) -> FloatArray:
    low, high = float(axis.min()), float(axis.max())
    count = max(1, math.ceil((high - low) / spacing) + 1)
    start = (low + high) / 2.0 - (count - 1) * spacing / 2.0
    return np.asarray(start + spacing * np.arange(count))
