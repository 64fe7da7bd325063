# SPDX-License-Identifier: Apache-2.0
"""Which photographs were taken in one place, so that a wrong fix does not make a huge map."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from rocsafe_geo.arrays import FloatArray

EARTH_RADIUS_M = 6_371_008.8
LARGEST_GAP_M = 2000.0
"""Two photographs of one survey have others between them at this distance or less."""


def distances_from_most_m(positions: Sequence[tuple[float, float]]) -> FloatArray:
    """Return 0 for photographs in the place with most photographs, else the distance from there.

    Photographs are in one place if steps of at most `LARGEST_GAP_M` lead from one to the other.

    Parameters
    ----------
    positions
        Latitude and longitude in degrees of each.

    Returns
    -------
    (n,)
        Metres, through the earth, from the median of the place with most photographs.
    """
    if not positions:
        return np.zeros(0)
    latitude, longitude = np.radians(np.array(positions, float)).T
    points = EARTH_RADIUS_M * np.column_stack([
        np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude),
        np.sin(latitude),
    ])  # fmt: skip
    # Cells instead of photographs: the pairs of a large survey would fill the memory.
    cells, cell_of = np.unique(
        np.floor(points / LARGEST_GAP_M).astype(np.int64), axis=0, return_inverse=True
    )
    near = cKDTree(cells).query_pairs(1.8, output_type='ndarray')
    graph = coo_matrix((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(cells),) * 2)
    place = connected_components(graph, directed=False)[1][cell_of.ravel()]
    counts = np.bincount(place)
    # Two places may have equally many photographs: the first one counts.
    most = next(number for number in place if counts[number] == counts.max())
    away = np.linalg.norm(points - np.median(points[place == most], axis=0), axis=1)
    return np.where(place == most, 0.0, away)
