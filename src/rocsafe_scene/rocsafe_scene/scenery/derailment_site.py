# SPDX-License-Identifier: Apache-2.0
"""Where the derailment lies: a frame whose x axis runs along the railway.

It is turned from east so that it lies along the region of the ROCSAFE demonstration of 2018.
"""

import math

import numpy as np

from rocsafe_scene.scenery.marks import Placing, Points

SITE = Placing(0.0, 0.0, math.radians(14.4))
# Torn up, metres along the track.
TORN_M = (178.0, 246.0)


def placing_at(x: float, y: float, yaw_deg: float = 0.0) -> Placing:
    """Return the placing of something at (x, y) of the site."""
    return SITE.moved(x, y, math.radians(yaw_deg))


def point_at(x: float, y: float) -> tuple[float, float]:
    """Return (east, north) of the point (x, y) of the site."""
    placing = SITE.moved(x, y)
    return placing.east_m, placing.north_m


def rail_line() -> Points:
    """Return the centre line of the track, from the site's west to its east."""
    x = np.arange(-190.0, 191.0, 4.0)
    return SITE.to_world(np.column_stack([x, 8.0 + 0.00045 * x**2]))


def rail_y_m(x: float) -> float:
    """Return y of the track at x: it bends a little."""
    return 8.0 + 0.00045 * x * x
