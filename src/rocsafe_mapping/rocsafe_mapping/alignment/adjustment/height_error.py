# SPDX-License-Identifier: Apache-2.0
"""How well the ground's heights are known, and what that is worth on the map."""

import numpy as np

from rocsafe_mapping.alignment.model.photo import FloatArray, Pose
from rocsafe_mapping.alignment.model.surface import Surface
from rocsafe_mapping.alignment_options import AlignmentOptions


def height_error(
    surface: Surface, ties_m: FloatArray, standing_m: FloatArray, options: AlignmentOptions
) -> Surface:
    """Return the standard error of the ground's heights, as a grid like `surface`.

    Where no ties lie the ground may bend as it is believed to do; where they lie, what stands
    there spreads as they do.

    Parameters
    ----------
    ties_m
        Where ties lie, (east, north), shape (n, 2).
    standing_m
        How far their points stand above the surface, shape (n,).
    """
    usual = float(np.mean(standing_m**2)) if len(standing_m) else 0.0
    if surface.is_level or not usual:
        return Surface(heights_m=np.full((1, 1), np.sqrt(usual)))
    nodes, weights = surface.weights(ties_m)
    counts, squares = (
        np.bincount(nodes.ravel(), (weights * values).ravel(), surface.heights_m.size)
        for values in (1.0, standing_m[:, np.newaxis] ** 2)
    )
    usual_ties = options.adjustment.usual_ties
    spread = (squares + usual_ties * usual) / (counts + usual_ties)
    unknown = surface.uncertainty_m(ties_m, np.full(len(ties_m), np.sqrt(usual)), options.ground)
    return surface.with_heights(np.sqrt(unknown**2 + spread.reshape(unknown.shape)))


def leaning_m(
    error: Surface, pose: Pose, ground_m: FloatArray, rise_m: FloatArray | float = 0.0
) -> FloatArray:
    """Return how far points (n, 2) are off on the map of a photograph where heights are off.

    A point that lies z higher is seen z r / h farther out, r from below a camera h high: so both
    what is not known of the ground and what is known to stand on it, `rise_m`, are off the map.
    """
    off = np.linalg.norm(ground_m - pose.centre[:2], axis=1)
    leaning: FloatArray = np.hypot(error.at(ground_m), rise_m) * off / pose.centre[2]
    return leaning
