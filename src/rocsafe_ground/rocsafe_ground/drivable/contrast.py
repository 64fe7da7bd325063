# SPDX-License-Identifier: Apache-2.0
"""Pixels that are unlike the ground around them: people, cones, debris of any colour.

The colour alone does not tell a thing from ground: a brown coat has the colour of soil. But it
stands out from the meadow around it: its distance from the mean colour there, in units of the
spread of colours there, is large (Reed & Yu 1990).
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter

from rocsafe_geo.arrays import BoolArray
from rocsafe_ground.drivable.raster import Values

# Rows at a time.
STRIP = 512


@dataclass(frozen=True, slots=True, kw_only=True)
class ContrastRules:
    """When a pixel is unlike its surroundings.

    Attributes
    ----------
    around_m
        Side of the surroundings: wide beside a person or a drum, narrow beside a way.
    unlike
        Square of the distance: 99 of 100 pixels of a normal distribution of three colours are
        nearer (chi-squared with three degrees of freedom).
    noise
        Spread that every camera adds to a plain colour, of 255.
    """

    around_m: float = 2.1
    unlike: float = 11.345
    noise: float = 2.0


def is_unlike(
    colours: Values, is_seen: BoolArray, pixel_m: float, rules: ContrastRules
) -> BoolArray:
    """Return which pixels are unlike their surroundings, (rows, columns).

    Parameters
    ----------
    colours : (3, rows, columns)
        Red, green, blue, 0 to 255.
    is_seen : (rows, columns)
        Which pixels have a colour.
    pixel_m
        Side of a pixel.
    rules
        When a pixel is unlike.
    """
    side = 2 * round(0.5 * rules.around_m / pixel_m) + 1
    found = np.zeros(is_seen.shape, np.bool_)
    for first in range(0, len(found), STRIP):
        # A strip and the surroundings of its pixels.
        before, last = max(first - side, 0), first + STRIP
        rows = slice(before, last + side)
        odd = _squares(colours[:, rows], is_seen[rows], side, rules.noise) > rules.unlike
        found[first:last] = odd[first - before : last - before]
    return found & is_seen


def _squares(colours: Values, is_seen: BoolArray, side: int, noise: float) -> Values:
    """Return the squared distance (Mahalanobis) of each pixel from its surroundings."""
    count = np.maximum(uniform_filter(is_seen.astype(np.float32), side), 1e-6)

    def mean(values: Values) -> Values:
        return np.asarray(uniform_filter(values, side) / count)

    known = np.where(is_seen, colours, 0.0).astype(np.float32)
    means = [mean(one) for one in known]
    rest = [one - middle for one, middle in zip(known, means, strict=True)]
    spread = {
        (a, b): mean(known[a] * known[b]) - means[a] * means[b]
        for a in range(3)
        for b in range(a, 3)
    }
    total = np.zeros(is_seen.shape, np.float32)
    # The colours one after the other, each without what the ones before tell of it (Cholesky).
    for a in range(3):
        own = np.maximum(spread[a, a], 0.0) + noise**2
        total += rest[a] ** 2 / own
        for b in range(a + 1, 3):
            share = spread[a, b] / own
            rest[b] = rest[b] - share * rest[a]
            for c in range(b, 3):
                spread[b, c] = spread[b, c] - share * spread[a, c]
    return total
