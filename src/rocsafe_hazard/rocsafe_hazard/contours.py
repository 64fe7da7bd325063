# SPDX-License-Identifier: Apache-2.0
"""Areas of a grid above a level."""

from itertools import pairwise
from typing import Any

import contourpy
import numpy as np
import shapely
from shapely.geometry import MultiPolygon

from rocsafe_geo.arrays import FloatArray


def area_above(
    east_m: FloatArray, north_m: FloatArray, values: FloatArray, level: float
) -> MultiPolygon:
    """Return where `values` exceed `level`, with holes; rings lie on the interpolated isoline.

    Parameters
    ----------
    east_m, north_m : (columns,), (rows,)
        Coordinates of the nodes, metres.
    values : (rows, columns)
        Linear between nodes, finite.
    level
        Value of the isoline.
    """
    lines = contourpy.contour_generator(
        east_m, north_m, values, name='serial', fill_type='OuterOffset'
    )
    filled: Any = lines.filled(level, np.inf)
    found = [
        shapely.Polygon(points[cuts[0] : cuts[1]], _rings(points, cuts))
        for points, cuts in zip(*filled, strict=True)
    ]
    joined = shapely.union_all([polygon.buffer(0.0) for polygon in found])
    return MultiPolygon([part for part in shapely.get_parts(joined) if part.area > 0.0])


def _rings(points: Any, cuts: Any) -> list[Any]:
    return [points[first:last] for first, last in pairwise(cuts[1:])]
