# SPDX-License-Identifier: Apache-2.0
"""Ties of points that stand off the ground's plane: they show how high it is there."""

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.alignment_options import ParallaxOptions


def transformed(homography: FloatArray, points: FloatArray) -> FloatArray:
    """Return where a homography brings points (n, 2); NaN behind the camera."""
    there = np.column_stack([points, np.ones(len(points))]) @ homography.T
    with np.errstate(divide='ignore', invalid='ignore'):
        return np.where(there[:, 2:] > 0.0, there[:, :2] / there[:, 2:], np.nan)


def off_plane(
    homography: FloatArray,
    first_px: FloatArray,
    second_px: FloatArray,
    middle_px: FloatArray,
    options: ParallaxOptions,
) -> BoolArray:
    """Return which matches (n,) are probably points above or below a homography's plane.

    Such points are displaced along the baseline. None is returned unless clearly more matches are
    displaced along it than across it, where only chance puts them.

    Parameters
    ----------
    homography
        Of the plane, first photograph to second.
    first_px, second_px
        The matches, shape (n, 2).
    middle_px
        Principal point of the second photograph, which nearly is that of the first.
    """
    none = np.zeros(len(first_px), bool)
    way = transformed(homography, middle_px[np.newaxis])[0] - middle_px
    length = float(np.linalg.norm(way))
    if not length > options.least_baseline_px or not len(first_px):
        return none
    off = second_px - transformed(homography, first_px)
    along = off @ (way / length)
    across = off @ (np.array([-way[1], way[0]]) / length)
    found: BoolArray = _band(along, across, options)
    by_chance = int(_band(across, along, options).sum())
    return found if found.sum() > options.certainty * (by_chance + 1) else none


def _band(along: FloatArray, across: FloatArray, options: ParallaxOptions) -> BoolArray:
    far = np.abs(along)
    return (
        (far > options.across_px) & (far < options.most_px) & (np.abs(across) < options.across_px)
    )
