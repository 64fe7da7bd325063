# SPDX-License-Identifier: Apache-2.0
"""A plate beside a source, of a wagon or a container, takes part of its dose rate on one side.

The plate stands upright. Its parameters: a and b, whose direction is that from the source to the
plate and whose length is the slope up to its upper edge; the logarithm of its half width over its
distance; and the logarithm of its thickness in mean free paths. Rays through it pass more of it
the more they slant. What is left after p mean free paths is (1 + p) exp(-p), scattered photons
included.
"""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray

SHADE_PARAMETERS = 4
# Prior: slopes up to the edge of 1 to 3 are likely; within two standard deviations the half width
# is 1 to 16 times the distance, and the thickness 0.1 to 3.6 mean free paths.
SHADE_MEANS = np.array([0.0, 0.0, math.log(4.0), math.log(0.6)])
SHADE_STDS = np.array([1.5, 1.5, 0.7, 0.9])
# Sine of the angle over which the shade begins: sources and edges are not sharp.
EDGE = 0.05
# Least sine of a ray to the plate, and least slope up to the edge.
FLATTEST, LEAST_SLOPE = 0.2, 0.1
# Shades from which a fit is begun: directions, slopes up to the edge.
DIRECTIONS, SLOPES = 12, (0.7, 1.3, 2.5)
LARGEST_EXPONENT = 40.0


def first_shades() -> FloatArray:
    """Return the shades from which a fit is begun, shape (m, 4)."""
    angles = 2.0 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ways = np.concatenate([slope * ways for slope in SLOPES])
    return np.column_stack([ways, np.tile(SHADE_MEANS[2:], (len(ways), 1))])


def paths(offsets: FloatArray, distances: FloatArray, shades: FloatArray) -> FloatArray:
    """Return the mean free paths of each ray in the plate, shape (k, n).

    Parameters
    ----------
    offsets : shape (k, 3, n)
        From each source to each reading, metres.
    distances : shape (k, n)
        Their lengths.
    shades : shape (k, 4)
        Parameters of the shade of each source.
    """
    return _Rays.of(offsets, distances, shades).paths


def left(taken: FloatArray) -> FloatArray:
    """Return the share that is left after so many mean free paths."""
    return np.asarray((1.0 + taken) * np.exp(-taken))


def left_and_slopes(
    offsets: FloatArray, distances: FloatArray, shades: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the share of the dose rates that is left, (k, n), and slopes of its logarithm.

    Those are by east, north and up of each source and the parameters of its shade, (k, 7, n).
    """
    rays = _Rays.of(offsets, distances, shades)
    slopes = rays.slopes(offsets, distances, shades)
    # Derivative of the logarithm of the share left by the logarithm of the paths.
    by_path = -rays.paths * rays.paths / (1.0 + rays.paths)
    return left(rays.paths), slopes * by_path[:, None]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Rays:
    """Rays from sources to readings, beside the plates; all have shape (k, n) but as named.

    Attributes
    ----------
    towards, aside
        Unit vectors to the plate and along it, shape (k, 2, 1).
    to_m, along_m
        Way of the ray in these directions, metres.
    below, within
        Whether the ray is below the upper edge, and between the ends, smoothly from 0 to 1.
    across
        Sine of the angle of the ray to the plate.
    paths
        Mean free paths in the plate.
    """

    towards: FloatArray
    aside: FloatArray
    to_m: FloatArray
    along_m: FloatArray
    below: FloatArray
    within: FloatArray
    across: FloatArray
    paths: FloatArray

    @classmethod
    def of(cls, offsets: FloatArray, distances: FloatArray, shades: FloatArray) -> '_Rays':
        lengths, widths = _lengths(shades), np.exp(shades[:, 2:3])
        towards = shades[:, :2] / lengths
        aside = np.stack([-towards[:, 1], towards[:, 0]], axis=1)
        to_m = np.einsum('kc,kcn->kn', towards, offsets[:, :2])
        along_m = np.einsum('kc,kcn->kn', aside, offsets[:, :2])
        below = _smooth((lengths * to_m - offsets[:, 2]) / distances)
        within = _smooth((widths * to_m - np.abs(along_m)) / (np.hypot(widths, 1.0) * distances))
        across = to_m / distances
        return cls(
            towards=towards[:, :, None],
            aside=aside[:, :, None],
            to_m=to_m,
            along_m=along_m,
            below=below,
            within=within,
            across=across,
            paths=np.exp(shades[:, 3:]) * below * within / np.maximum(across, FLATTEST),
        )

    def slopes(self, offsets: FloatArray, distances: FloatArray, shades: FloatArray) -> FloatArray:
        """Return derivatives of the logarithm of `paths`, as in `left_and_slopes`."""
        lengths, widths = _lengths(shades)[:, :, None], np.exp(shades[:, 2])[:, None, None]
        ways = offsets / distances[:, None]
        ends = np.hypot(widths, 1.0)
        # Derivatives of the exponents of both edges, and of the logarithm of the slant.
        low = ((1.0 - self.below) / (EDGE * distances))[:, None]
        end = ((1.0 - self.within) / (EDGE * distances))[:, None] / ends
        slant = ((self.across > FLATTEST) / np.maximum(self.to_m, 1e-9))[:, None]
        to_m, along_m = self.to_m[:, None], self.along_m[:, None]
        side = np.sign(along_m)
        over = end * (widths * to_m - np.abs(along_m)) + low * (lengths * to_m - offsets[:, 2:])
        found = np.empty((len(shades), 3 + SHADE_PARAMETERS, offsets.shape[2]))
        # By the place of the source: a reading moves the other way.
        found[:, :3] = (over / distances[:, None] - slant * self.across[:, None]) * ways
        found[:, :2] += slant * self.towards - low * lengths * self.towards
        found[:, :2] -= end * (widths * self.towards - side * self.aside)
        found[:, 2] += low[:, 0]
        turned = end * (widths * along_m + side * to_m) - slant * along_m
        found[:, 3:5] = low * offsets[:, :2] + turned * self.aside / lengths
        found[:, 5:6] = end * widths * (to_m + widths * np.abs(along_m)) / ends**2
        found[:, 6] = 1.0
        return found


def _lengths(shades: FloatArray) -> FloatArray:
    return np.maximum(np.hypot(shades[:, :1], shades[:, 1:2]), LEAST_SLOPE)


def _smooth(sines: FloatArray) -> FloatArray:
    return np.asarray(
        1.0 / (1.0 + np.exp(-np.clip(sines / EDGE, -LARGEST_EXPONENT, LARGEST_EXPONENT)))
    )
