# SPDX-License-Identifier: Apache-2.0
"""Stability of the air: Pasquill classes and the Obukhov length."""

import math
from typing import Literal, get_args

from rocsafe_geo.limits import require_between
from rocsafe_geo.wind.similarity import SurfaceLayer, surface_layer

StabilityClass = Literal['A', 'B', 'C', 'D', 'E', 'F']
CLASSES: tuple[StabilityClass, ...] = get_args(StabilityClass)
# Golder 1972 as straight lines: 1/L = a + b log10(z0) (Seinfeld and Pandis, table 16.3).
_GOLDER = {
    'A': (-0.096, 0.029),
    'B': (-0.037, 0.029),
    'C': (-0.002, 0.018),
    'D': (0.0, 0.0),
    'E': (0.004, -0.018),
    'F': (0.035, -0.036),
}


def obukhov_length_m(stability: StabilityClass, roughness_m: float) -> float:
    """Return the Obukhov length of a class over ground of a roughness, metres (Golder 1972).

    Raises
    ------
    ValueError
        If the class is not one of A to F, or the roughness not 0.001 to 0.5 m.
    """
    if stability not in _GOLDER:
        raise ValueError(f'stability is {stability!r}: must be one of {", ".join(CLASSES)}')
    require_between('roughness_m', roughness_m, 1e-3, 0.5, 'm')
    first, second = _GOLDER[stability]
    inverse = first + second * math.log10(roughness_m)
    return 1.0 / inverse if inverse else math.inf


def class_of_length(length_m: float, roughness_m: float) -> StabilityClass:
    """Return the class whose 1/L is nearest to that of an Obukhov length."""
    inverse = 1.0 / length_m
    return min(CLASSES, key=lambda one: abs(1.0 / obukhov_length_m(one, roughness_m) - inverse))


def layer_of_class(
    stability: StabilityClass, speed_mps: float, height_m: float, roughness_m: float
) -> SurfaceLayer:
    """Return the surface layer of a class whose wind has a speed at a height."""
    length = obukhov_length_m(stability, roughness_m)
    return surface_layer(speed_mps, height_m, length, roughness_m)
