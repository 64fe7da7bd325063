# SPDX-License-Identifier: Apache-2.0
"""Sizes of a plume by Briggs 1973 (doi 10.2172/5118833), for comparison.

The curves hold from 100 m to 10 km; nearer they are extrapolations.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.stability import StabilityClass

Setting = Literal['rural', 'urban']
# Factor, length coefficient (1/m) and exponent of factor * x * (1 + coefficient * x)^exponent.
Curve = tuple[float, float, float]
_RURAL_Y: dict[str, Curve] = {
    name: (factor, 1e-4, -0.5)
    for name, factor in zip('ABCDEF', (0.22, 0.16, 0.11, 0.08, 0.06, 0.04), strict=True)
}
_RURAL_Z: dict[str, Curve] = {
    'A': (0.20, 0.0, 0.0),
    'B': (0.12, 0.0, 0.0),
    'C': (0.08, 2e-4, -0.5),
    'D': (0.06, 1.5e-3, -0.5),
    'E': (0.03, 3e-4, -1.0),
    'F': (0.016, 3e-4, -1.0),
}
_URBAN_Y: dict[str, Curve] = {
    name: (factor, 4e-4, -0.5)
    for name, factor in zip('ABCDEF', (0.32, 0.32, 0.22, 0.16, 0.11, 0.11), strict=True)
}
_URBAN_Z: dict[str, Curve] = {
    'A': (0.24, 1e-3, 0.5),
    'B': (0.24, 1e-3, 0.5),
    'C': (0.20, 0.0, 0.0),
    'D': (0.14, 3e-4, -0.5),
    'E': (0.08, 1.5e-3, -0.5),
    'F': (0.08, 1.5e-3, -0.5),
}
_CURVES = {'rural': (_RURAL_Y, _RURAL_Z), 'urban': (_URBAN_Y, _URBAN_Z)}


def briggs_sigmas_m(
    distance_m: ArrayLike, stability: StabilityClass, setting: Setting = 'rural'
) -> tuple[FloatArray, FloatArray]:
    """Return crosswind and vertical standard deviation at distances downwind, metres.

    Raises
    ------
    ValueError
        If the class or the setting is not known.
    """
    if setting not in _CURVES or stability not in _RURAL_Y:
        raise ValueError(f'no curves of Briggs for {setting!r}, {stability!r}')
    distance = np.asarray(distance_m, float)
    across, upwards = (curves[stability] for curves in _CURVES[setting])
    return _curve(across, distance), _curve(upwards, distance)


def _curve(curve: Curve, distance_m: FloatArray) -> FloatArray:
    factor, coefficient, exponent = curve
    return np.asarray(factor * distance_m * (1.0 + coefficient * distance_m) ** exponent)
