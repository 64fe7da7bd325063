# SPDX-License-Identifier: Apache-2.0
"""Sunlight on the scene: shadows, and how bright a surface is."""

import math
from collections.abc import Iterable

import cv2
import numpy as np

from rocsafe_scene.scenery.marks import (
    Coordinates,
    Dots,
    Paint,
    Placing,
    Points,
    Shape,
    polygon,
)

# A fine morning: the sun stands in the south-east.
SUN_AZIMUTH_RAD = math.radians(146.0)
SUN_ELEVATION_RAD = math.radians(47.0)
AMBIENT = 0.55

SHADOW = Paint((0, 0, 0), 0)
# Towards the sun: east, north, up.
SUN_ENU = (
    math.sin(SUN_AZIMUTH_RAD) * math.cos(SUN_ELEVATION_RAD),
    math.cos(SUN_AZIMUTH_RAD) * math.cos(SUN_ELEVATION_RAD),
    math.sin(SUN_ELEVATION_RAD),
)
# Where the shadow of something one metre high falls, east and north.
SHADOW_PER_M = (-SUN_ENU[0] / SUN_ENU[2], -SUN_ENU[1] / SUN_ENU[2])


def shadow_offset(height_m: float) -> Points:
    """Return by how much the shadow of a point at a height is shifted, (east, north)."""
    return height_m * np.array(SHADOW_PER_M)


def shadow_of(points: Coordinates, height_m: float) -> Shape:
    """Return the shadow of an upright prism with a convex outline, shape (n, 2)."""
    base = np.asarray(points, float)
    hull = np.vstack([base, base + shadow_offset(height_m)])
    return polygon(convex_hull(hull), SHADOW)


def shadow_of_box(placing: Placing, length_m: float, width_m: float, height_m: float) -> Shape:
    """Return the shadow of a box that stands at `placing`."""
    x, y = 0.5 * length_m, 0.5 * width_m
    return shadow_of(placing.to_world([[-x, -y], [x, -y], [x, y], [-x, y]]), height_m)


def shadow_of_discs(centres: Points, radii_m: Points, heights_m: Points) -> Dots:
    """Return the shadows of level discs at heights; shapes (n, 2), (n,), (n,)."""
    shifted = centres + heights_m[:, None] * np.array(SHADOW_PER_M)
    return Dots(shifted, radii_m, np.zeros((1, 4)))


def brightness(normal_enu: Iterable[float]) -> float:
    """Return how bright a surface is, about 0.55 in shade to 1.2 towards the sun (Lambert)."""
    east, north, up = normal_enu
    facing = SUN_ENU[0] * east + SUN_ENU[1] * north + SUN_ENU[2] * up
    return AMBIENT + 0.65 * max(0.0, facing)


def convex_hull(points: Points) -> Points:
    """Return the corners of the convex hull of points (n, 2)."""
    centre = points.mean(axis=0)
    hull = cv2.convexHull((points - centre).astype(np.float32))
    return hull[:, 0].astype(float) + centre
