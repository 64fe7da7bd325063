# SPDX-License-Identifier: Apache-2.0
"""Intersections of rays with upright boxes."""

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray

GRAZING = 1e-12
"""Cosine, or length in metres, below which a ray counts as parallel to a face."""


def boxes_reached(
    lows: NDArray[np.floating],
    highs: NDArray[np.floating],
    origins: FloatArray,
    directions: FloatArray,
    limits: FloatArray,
) -> NDArray[np.bool_]:
    """Return which of n rays enter which of k boxes, by the slab method.

    Parameters
    ----------
    lows, highs : (k, 3)
        Opposite corners of each box, metres.
    origins, directions : (n, 3)
        Start of each ray, metres, and its unit direction.
    limits : (n,)
        Length of each ray, metres.

    Returns
    -------
    (k, n)
        Whether the ray is inside the box anywhere within its length.
    """
    safe = np.where(np.abs(directions) < GRAZING, GRAZING, directions)
    first, second = (lows[:, None] - origins) / safe, (highs[:, None] - origins) / safe
    enter = np.minimum(first, second).max(axis=2)
    leave = np.maximum(first, second).min(axis=2)
    return np.asarray((leave >= np.maximum(enter, 0.0)) & (enter <= limits))
