# SPDX-License-Identifier: Apache-2.0
"""Whether the detectors of a survey read alike where they were at the same place."""

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from rocsafe_geo.arrays import FloatArray

# Readings in a cube of this share of the median height, or of so many metres, are at one place.
CELL_HEIGHTS, LEAST_CELL_M = 0.5, 2.0
# Detectors of one kind differ by less; so many cells must have readings of both.
LARGEST_FACTOR, FEWEST_CELLS = 1.3, 5
# Standard deviation of a median over that of a mean, and how sure a difference must be.
MEDIAN_FACTOR, SURE_STDS = 1.25, 3.0


def unlike_detectors(
    vehicles: Sequence[str], places_m: FloatArray, counts: FloatArray, exposures: FloatArray
) -> tuple[str, str, float] | None:
    """Return the two detectors that differ most, and the factor by which the second reads more.

    None if all read alike, or none were at the same places.

    Parameters
    ----------
    vehicles : n names
        Of the detector of each reading.
    places_m : shape (n, 3)
        East, north and height above the ground.
    counts, exposures : shape (n,)
        Counts, and those expected for one unit.
    """
    names, owner = np.unique(np.asarray(vehicles), return_inverse=True)
    if len(names) < 2:
        return None
    cell_m = max(LEAST_CELL_M, CELL_HEIGHTS * float(np.median(places_m[:, 2])))
    _, cells = np.unique(np.floor(places_m / cell_m), axis=0, return_inverse=True)
    size = (int(cells.max()) + 1, len(names))
    at = np.ravel_multi_index((cells.reshape(-1), owner), size)
    shape = size[0] * size[1]
    summed = np.bincount(at, counts, shape).reshape(size)
    exposed = np.bincount(at, exposures, shape).reshape(size)
    with np.errstate(divide='ignore', invalid='ignore'):
        logs = np.log(summed / exposed)
    found: tuple[str, str, float] | None = None
    for first, second in combinations(range(len(names)), 2):
        ways = logs[:, second] - logs[:, first]
        ways = ways[np.isfinite(ways)]
        if len(ways) < FEWEST_CELLS:
            continue
        middle = float(np.median(ways))
        doubt = SURE_STDS * MEDIAN_FACTOR * float(np.std(ways)) / math.sqrt(len(ways))
        if abs(middle) < math.log(LARGEST_FACTOR) + doubt:
            continue
        if found is None or abs(middle) > abs(math.log(found[2])):
            found = str(names[first]), str(names[second]), math.exp(middle)
    return found
