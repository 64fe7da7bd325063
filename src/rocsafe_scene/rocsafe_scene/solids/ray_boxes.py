# SPDX-License-Identifier: Apache-2.0
"""Which rays enter which boxes, all at once."""

import numpy as np

from rocsafe_scene.mesh.mesh import Floats

GRAZING = 1e-12


def boxes_reached(
    lows: Floats, highs: Floats, origins: Floats, directions: Floats, limits: Floats
) -> Floats:
    """Return which of n rays enter which of k boxes (k, 3) within their limits, (k, n)."""
    safe = np.where(np.abs(directions) < GRAZING, GRAZING, directions)
    first, second = (lows[:, None] - origins) / safe, (highs[:, None] - origins) / safe
    enter = np.minimum(first, second).max(axis=2)
    leave = np.maximum(first, second).min(axis=2)
    return np.asarray((leave >= np.maximum(enter, 0.0)) & (enter <= limits))
