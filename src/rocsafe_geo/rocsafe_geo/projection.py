# SPDX-License-Identifier: Apache-2.0
"""Coordinate transformations by PROJ, on columns of coordinates."""

import numpy as np
from numpy.typing import ArrayLike
from pyproj import Transformer

from rocsafe_geo.arrays import FloatArray


def columns(*values: ArrayLike) -> tuple[FloatArray, ...]:
    """Return scalars or arrays of shape (n,) as float arrays of one common shape (n,)."""
    return tuple(np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, float)) for v in values)))


def transform(
    transformer: Transformer, x: FloatArray, y: FloatArray, z: FloatArray, inverse: bool = False
) -> FloatArray:
    """Return the transformed points, shape (n, 3), of coordinates of shape (n,)."""
    # pyproj takes an array of one element for a scalar, and warns: give it the scalar.
    points = [v.item() if v.size == 1 else v for v in (x, y, z)]
    direction = 'INVERSE' if inverse else 'FORWARD'
    return np.column_stack(transformer.transform(*points, direction=direction, errcheck=True))
