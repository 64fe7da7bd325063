# SPDX-License-Identifier: Apache-2.0
"""Rows of a survey file that only the others show to be wrong: far places, dead detectors."""

from collections.abc import Sequence

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray

# No vehicle of a survey flies so far.
LARGEST_DISTANCE_M = 20_000.0
METRES_A_DEGREE = 111_000.0
# So many readings without a single count show a detector that is switched off or broken.
FEWEST_EMPTY = 8


def far(places: FloatArray, is_geodetic: bool) -> BoolArray:
    """Return which places (n, 2), degrees or metres, lie far from the middle of all, (n,)."""
    if not len(places):
        return np.zeros(0, dtype=bool)
    middle = np.median(places, axis=0)
    ways = places - middle
    if is_geodetic:
        ways[:, 1] = (ways[:, 1] + 180.0) % 360.0 - 180.0
        ways *= METRES_A_DEGREE * np.array([1.0, np.cos(np.radians(middle[0]))])
    return np.asarray(np.hypot(*ways.T) > LARGEST_DISTANCE_M, dtype=bool)


def dead(vehicles: Sequence[str], amounts: FloatArray) -> BoolArray:
    """Return which readings are of a vehicle whose detector read nothing but 0, (n,).

    Nature gives counts everywhere: a detector without any proves no absence of sources.

    Parameters
    ----------
    vehicles : n names
        Of each reading.
    amounts : shape (n,)
        Counts, or the dose rate where the detector does not count.
    """
    names, owner = np.unique(np.array(vehicles, dtype=str), return_inverse=True)
    totals = np.bincount(owner, amounts, minlength=len(names))
    sizes = np.bincount(owner, minlength=len(names))
    return np.asarray(((totals == 0.0) & (sizes >= FEWEST_EMPTY))[owner], dtype=bool)
