# SPDX-License-Identifier: Apache-2.0
"""Errors of the ground's heights, and the errors on the map that follow from them."""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.model.photo import Pose
from rocsafe_mapping.alignment.model.surface import Surface
from rocsafe_mapping.alignment_options import AlignmentOptions

ROUNDS = 10
SMALLEST_M2 = 1e-12
"""Keeps weights in proportion where all heights are zero."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TieHeights:
    """How high points stand above the ground that two photographs show.

    Attributes
    ----------
    places_m
        Where they lie, (east, north), shape (n, 2).
    standing_m
        Their heights above the surface, shape (n,).
    stds_m
        Standard errors of these, shape (n,): large where both photographs were taken at one place.
    """

    places_m: FloatArray
    standing_m: FloatArray
    stds_m: FloatArray


def height_error(surface: Surface, ties: TieHeights, options: AlignmentOptions) -> Surface:
    """Return the standard error of the ground's heights, as a grid like `surface`.

    Between ties, the prior of the ground's curvature gives the error; at ties, the spread of their
    heights is added. A tie counts by how well it tells a height.
    """
    usual = _usual_m2(ties)
    if surface.is_level or not usual:
        return Surface(heights_m=np.full((1, 1), np.sqrt(usual)))
    telling = _telling(usual, ties)
    nodes, weights = surface.weights(ties.places_m)
    counts, squares = (
        np.bincount(nodes.ravel(), (weights * values).ravel(), surface.heights_m.size)
        for values in (telling[:, np.newaxis], (telling * ties.standing_m**2)[:, np.newaxis])
    )
    usual_ties = options.adjustment.usual_ties
    spread = (squares + usual_ties * usual) / (counts + usual_ties)
    unknown = surface.uncertainty_m(
        ties.places_m, np.hypot(np.sqrt(usual), ties.stds_m), options.ground
    )
    return surface.with_heights(np.sqrt(unknown**2 + spread.reshape(unknown.shape)))


def _usual_m2(ties: TieHeights) -> float:
    """Return the mean square of heights.

    By the few ties that tell heights best alone, a handful of wrong ones would decide: cameras
    that were low tell heights to centimetres.
    """
    if not len(ties.stds_m):
        return 0.0
    usual = float(np.median(ties.standing_m**2))
    for _ in range(ROUNDS):
        weights = _telling(max(usual, SMALLEST_M2), ties)
        usual = float(np.average(ties.standing_m**2, weights=weights))
    return usual


def _telling(usual_m2: float, ties: TieHeights) -> FloatArray:
    """Return the weights (n,) with which the variance of heights of that spread is found best."""
    found: FloatArray = (usual_m2 / (usual_m2 + ties.stds_m**2)) ** 2
    return found


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
