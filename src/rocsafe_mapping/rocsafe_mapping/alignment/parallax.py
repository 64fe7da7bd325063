# SPDX-License-Identifier: Apache-2.0
"""Ties of points that stand off the ground's plane: they show how high it is there."""

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray

# How far along the parallax such ties lie, and how far across it.
MOST_PARALLAX_PX, ACROSS_PX = 26.0, 3.0
# They count if they are so many times as many as chance would put there.
CERTAINTY = 2.5
LEAST_BASELINE_PX = 60.0


def carried(homography: FloatArray, points: FloatArray) -> FloatArray:
    """Return where a homography brings points (n, 2); NaN behind the camera."""
    there = np.column_stack([points, np.ones(len(points))]) @ homography.T
    with np.errstate(divide='ignore', invalid='ignore'):
        return np.where(there[:, 2:] > 0.0, there[:, :2] / there[:, 2:], np.nan)


def off_plane(
    homography: FloatArray, first_px: FloatArray, second_px: FloatArray, middle_px: FloatArray
) -> BoolArray:
    """Return which matches (n,) look like points that stand off the plane of a homography.

    Such points lie beside their predicted place, along the way between the cameras. Nothing is
    returned unless there are clearly more along it than across it, where only chance puts them.

    Parameters
    ----------
    homography: of the plane, first photograph to second.
    first_px, second_px: the matches, shape (n, 2).
    middle_px: principal point of the second photograph, which nearly is that of the first.
    """
    none = np.zeros(len(first_px), bool)
    way = carried(homography, middle_px[np.newaxis])[0] - middle_px
    length = float(np.linalg.norm(way))
    if not length > LEAST_BASELINE_PX or not len(first_px):
        return none
    off = second_px - carried(homography, first_px)
    along = off @ (way / length)
    across = off @ (np.array([-way[1], way[0]]) / length)
    found: BoolArray = _band(along, across)
    by_chance = int(_band(across, along).sum())
    return found if found.sum() > CERTAINTY * (by_chance + 1) else none


def _band(along: FloatArray, across: FloatArray) -> BoolArray:
    far = np.abs(along)
    return (far > ACROSS_PX) & (far < MOST_PARALLAX_PX) & (np.abs(across) < ACROSS_PX)
