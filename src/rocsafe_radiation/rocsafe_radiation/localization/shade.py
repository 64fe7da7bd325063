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
SHADE_MEANS = np.array([0.0, 0.0, math.log(0.5)])
SHADE_STDS = np.array([1.5, 1.5, 1.0])
# Sine of the angle over which the shade begins: sources and edges are not sharp.
EDGE = 0.05
# Shades from which a fit is begun: directions, slopes up to the edge.
DIRECTIONS, SLOPES = 12, (0.7, 1.3, 2.5)
LARGEST_EXPONENT = 40.0
FLATTEST, LEAST_SLOPE = 0.3, 0.1


def edges() -> FloatArray:
    """Return a and b of the shades from which a fit is begun, shape (m, 2)."""
    angles = 2.0 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.concatenate([slope * ways for slope in SLOPES])


def paths(offsets: FloatArray, distances: FloatArray, shades: FloatArray) -> FloatArray:
    """Return the mean free paths of each ray in the wall, shape (k, n).

    Parameters
    ----------
    offsets : shape (k, 3, n)
        From each source to each reading, metres.
    distances : shape (k, n)
        Their lengths.
    shades : shape (k, 3)
        Parameters of the shade of each source.
    """
    below, across, _ = _geometry(offsets, distances, shades)
    return np.asarray(np.exp(shades[:, 2:]) * below / across)


def left(taken: FloatArray) -> FloatArray:
    """Return the share that is left after so many mean free paths, with the build-up 1 + p."""
    return np.asarray((1.0 + taken) * np.exp(-taken))


def left_and_slopes(
    offsets: FloatArray, distances: FloatArray, shades: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the share of the dose rates that is left, (k, n), and slopes of its logarithm.

    Those are by east, north and up of each source, a, b and the logarithm of the depth,
    (k, 6, n).
    """
    below, across, is_free = _geometry(offsets, distances, shades)
    taken = np.exp(shades[:, 2:]) * below / across
    # Of the logarithm of what is left, by that of the paths.
    by_path = -taken * taken / (1.0 + taken)
    # By the height above the plane over the distance, and by the cosine of the ray to the wall.
    steep = (by_path * (1.0 - below) / (EDGE * distances))[:, None]
    slant = (-by_path / across * is_free / distances)[:, None]
    ways = offsets / distances[:, None]
    normals = np.column_stack([shades[:, :2], -np.ones(len(shades))])[:, :, None]
    along = (normals * ways).sum(axis=1, keepdims=True)
    lengths = np.maximum(np.hypot(*shades[:, :2].T), LEAST_SLOPE)[:, None, None]
    towards = shades[:, :2, None] / lengths
    slopes = np.empty((len(shades), 3 + SHADE_PARAMETERS, offsets.shape[2]))
    slopes[:, :3] = steep * (along * ways - normals) + slant * across[:, None] * ways
    slopes[:, :2] -= slant * towards
    slopes[:, 3:5] = steep * offsets[:, :2]
    slopes[:, 3:5] += slant * (offsets[:, :2] - (across * distances)[:, None] * towards) / lengths
    slopes[:, 5] = by_path
    return left(taken), slopes


def _geometry(
    offsets: FloatArray, distances: FloatArray, shades: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return whether readings are below the plane, the sine of the ray to the wall, if free."""
    sides = np.einsum('kc,kcn->kn', shades[:, :2], offsets[:, :2])
    exponents = (sides - offsets[:, 2]) / (EDGE * distances)
    below = 1.0 / (1.0 + np.exp(-np.clip(exponents, -LARGEST_EXPONENT, LARGEST_EXPONENT)))
    lengths = np.maximum(np.hypot(*shades[:, :2].T), LEAST_SLOPE)[:, None]
    across = sides / (lengths * distances)
    return below, np.maximum(across, FLATTEST), (across > FLATTEST).astype(np.float64)
