# SPDX-License-Identifier: Apache-2.0
"""Boxes as triangles, for tests of solids."""

import itertools

import numpy as np

from rocsafe_geo.solids.scene_solids import Thing

# Corners of the faces of a box by the bits of (east, north, up), anticlockwise from outside.
FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def box_triangles(low, high):
    """Return the twelve triangles of an upright box between two corners, (12, 3, 3)."""
    ends = np.array([low, high], np.float32)
    corners = np.array([[ends[bits >> axis & 1, axis] for axis in range(3)] for bits in range(8)])
    triangles = itertools.chain.from_iterable(((a, b, c), (a, c, d)) for a, b, c, d in FACES)
    return corners[np.array(list(triangles))]


def box_thing(name, size_m, foot_m, material, fill=1.0):
    """Return a box that stands with the middle of its bottom at `foot_m`."""
    half = np.array([size_m[0] / 2.0, size_m[1] / 2.0, 0.0])
    low, high = np.array(foot_m) - half, np.array(foot_m) + half + [0.0, 0.0, size_m[2]]
    return Thing(name=name, material=material, fill=fill, corners_enu_m=box_triangles(low, high))
