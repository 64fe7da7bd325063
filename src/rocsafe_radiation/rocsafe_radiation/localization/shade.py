# SPDX-License-Identifier: Apache-2.0
"""A wall, a wagon or a container beside a source takes part of its dose rate on one side.

The plane through the source and the upper edge of the wall divides the readings. Those below the
plane see exp(-depth) of the source. Parameters of a shade: a, b and the logarithm of the depth.
The plane is a e + b n = u, at the way e east, n north and u up from the source: (a, b) points to
the wall, and its length is the slope up to the upper edge.
"""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray

SHADE_PARAMETERS = 3
# Prior: the slope up to the edge is 1 to 3, the depth 0.04 to 2 within two standard deviations.
SHADE_MEANS = np.array([0.0, 0.0, math.log(0.3)])
SHADE_STDS = np.array([1.5, 1.5, 1.0])
# Sine of the angle over which the shade begins: sources and edges are not sharp.
EDGE = 0.1
# Shades from which a fit is begun: directions, slopes up to the edge.
DIRECTIONS, SLOPES = 12, (0.7, 1.3, 2.5)
LARGEST_EXPONENT = 40.0


def edges() -> FloatArray:
    """Return a and b of the shades from which a fit is begun, shape (m, 2)."""
    angles = 2.0 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.concatenate([slope * ways for slope in SLOPES])


def shares(offsets: FloatArray, distances: FloatArray, shades: FloatArray) -> FloatArray:
    """Return which share of its depth each shade has at each reading, (k, n).

    Parameters
    ----------
    offsets : shape (k, 3, n)
        From each source to each reading, metres.
    distances : shape (k, n)
        Their lengths.
    shades : shape (k, 3)
        Parameters of the shade of each source.
    """
    heights = np.einsum('kc,kcn->kn', shades[:, :2], offsets[:, :2]) - offsets[:, 2]
    exponents = np.clip(heights / (EDGE * distances), -LARGEST_EXPONENT, LARGEST_EXPONENT)
    return np.asarray(1.0 / (1.0 + np.exp(-exponents)))


def logs_and_slopes(
    offsets: FloatArray, distances: FloatArray, shades: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the logarithm of what is left of the dose rates, (k, n), and its derivatives.

    Those are by east, north and up of each source, a, b and the logarithm of the depth,
    (k, 6, n).
    """
    taken = shares(offsets, distances, shades)
    logs = -np.exp(shades[:, 2:]) * taken
    # By the height above the plane over the distance.
    steep = (logs * (1.0 - taken) / (EDGE * distances))[:, None]
    ways = offsets / distances[:, None]
    normals = np.column_stack([shades[:, :2], -np.ones(len(shades))])[:, :, None]
    along = (normals * ways).sum(axis=1, keepdims=True)
    slopes = np.empty((len(shades), 3 + SHADE_PARAMETERS, offsets.shape[2]))
    slopes[:, :3] = steep * (along * ways - normals)
    slopes[:, 3:5] = steep * offsets[:, :2]
    slopes[:, 5] = logs
    return logs, slopes
