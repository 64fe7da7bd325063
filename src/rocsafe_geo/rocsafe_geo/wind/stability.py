# SPDX-License-Identifier: Apache-2.0
"""Stability of the air: Pasquill classes from wind, sun and cloud, and the Obukhov length."""

import math
from bisect import bisect_right
from typing import Literal, get_args

from rocsafe_geo.limits import require_between, require_not_negative
from rocsafe_geo.wind.similarity import SurfaceLayer, surface_layer

StabilityClass = Literal['A', 'B', 'C', 'D', 'E', 'F']
CLASSES: tuple[StabilityClass, ...] = get_args(StabilityClass)
Insolation = Literal['strong', 'moderate', 'slight']

# Pasquill 1961 as in Turner 1970, workbook of atmospheric dispersion estimates, table 3-1; of a
# pair such as A-B the more stable class. Speeds at 10 m, m/s.
_SPEEDS_MPS = (2.0, 3.0, 5.0, 6.0)
_BY_DAY: dict[str, str] = {'strong': 'ABBCC', 'moderate': 'BBCDD', 'slight': 'BCCDD'}
_BY_NIGHT = {True: 'EEDDD', False: 'FFEDD'}
# Turner 1970: the sun is above 60, 35 and 15 degrees.
STRONG_DEG, MODERATE_DEG, SLIGHT_DEG = 60.0, 35.0, 15.0
CLOUDY_SHARE, OVERCAST_SHARE = 0.5, 0.95
# Golder 1972 as straight lines: 1/L = a + b log10(z0) (Seinfeld and Pandis, table 16.3).
_GOLDER = {
    'A': (-0.096, 0.029),
    'B': (-0.037, 0.029),
    'C': (-0.002, 0.018),
    'D': (0.0, 0.0),
    'E': (0.004, -0.018),
    'F': (0.035, -0.036),
}


def insolation(sun_elevation_deg: float, cloud_share: float) -> Insolation | None:
    """Return how strong the sun is, or None at night (Turner 1970).

    Parameters
    ----------
    sun_elevation_deg
        Elevation of the sun, -90 to 90 degrees.
    cloud_share
        Share of the sky under clouds, 0 to 1; more than a half takes one step off.
    """
    elevation = require_between('sun_elevation_deg', sun_elevation_deg, -90.0, 90.0, 'degrees')
    cloud = require_between('cloud_share', cloud_share, 0.0, 1.0)
    if elevation <= 0.0:
        return None
    steps: tuple[Insolation, ...] = ('slight', 'moderate', 'strong')
    step = int(elevation > MODERATE_DEG) + int(elevation > STRONG_DEG)
    return steps[max(step - int(cloud > CLOUDY_SHARE), 0)]


def stability_class(
    speed_mps: float, sun_elevation_deg: float, cloud_share: float = 0.0
) -> StabilityClass:
    """Return the Pasquill class from the wind at 10 m, the sun and the clouds.

    Under an overcast sky, day or night, the class is D. At night, clouds over more than a half
    of the sky keep the ground warm.

    Raises
    ------
    ValueError
        If a value is out of range.
    """
    speed = require_not_negative('speed_mps', speed_mps, 'm/s')
    sun = insolation(sun_elevation_deg, cloud_share)
    if cloud_share >= OVERCAST_SHARE:
        return 'D'
    row = _BY_NIGHT[cloud_share > CLOUDY_SHARE] if sun is None else _BY_DAY[sun]
    return CLASSES[CLASSES.index(row[bisect_right(_SPEEDS_MPS, speed)])]


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
