# SPDX-License-Identifier: Apache-2.0
"""How well the ground's heights are known, and what that is worth on the map."""

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.model.photo import Pose
from rocsafe_mapping.alignment.model.surface import Surface
from rocsafe_mapping.alignment_options import AlignmentOptions


def height_error(
    surface: Surface, ties_m: FloatArray, standing_m: FloatArray, options: AlignmentOptions
) -> Surface:
    """Return the standard error of the ground's heights, as a grid like `surface`.

    Between ties, the prior of the ground's curvature gives the error; at ties, the spread of their
    heights is added.

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
    """Return the displacement of points (n, 2) of a photograph on the map by errors of height.

    A point z above the surface is drawn z r / h farther out, at the distance r from the nadir of a
    camera at the height h. Both the error of the ground's height and the height of objects,
    `rise_m`, have this effect.
    """
    off = np.linalg.norm(ground_m - pose.centre[:2], axis=1)
    leaning: FloatArray = np.hypot(error.at(ground_m), rise_m) * off / pose.centre[2]
    return leaning
