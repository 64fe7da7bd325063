# SPDX-License-Identifier: Apache-2.0
"""Field of the earth: magnetic by the World Magnetic Model 2025, gravity by WGS84.

``WMM2025.COF`` is the file of coefficients of the US National Centers for Environmental
Information, in the public domain; the model holds from 2025 to 2030.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S

_YEAR_NS = round(365.2425 * 86_400) * NS_PER_S
_UT_PER_NT = 1e-3
VALID_YEARS = 5.0
# Radius of the model's sphere, m, and the ellipsoid of WGS84.
_SPHERE_M = 6_371_200.0
_EQUATOR_M, _ECCENTRICITY_SQUARED = 6_378_137.0, 6.694_379_990_14e-3


@dataclass(frozen=True, slots=True, eq=False)
class _Coefficients:
    """Gauss coefficients g + ih of degree n and order m, nT, and their change in a year.

    `epoch` is the year of the values; both arrays are (13, 13), complex.
    """

    epoch: float
    values: NDArray[np.complex128]
    changes: NDArray[np.complex128]

    @property
    def degree(self) -> int:
        """Highest degree."""
        return len(self.values) - 1


def year_of(time_ns: int) -> float:
    """Return the year of a time since 1970, with its fraction, to the day."""
    day_ns = 86_400 * NS_PER_S
    return 1970.0 + (time_ns - time_ns % day_ns) / _YEAR_NS


@lru_cache(maxsize=64)
def magnetic_field_ut(place: GeoPosition, year: float) -> Enu:
    """Return the magnetic field (east, north, up) at a place, microtesla.

    Years before 2025 and after 2030 count as those, so that a run without a date has a field.
    Source: Chulliat et al., The US/UK World Magnetic Model for 2025-2030, equations 4 to 17.
    """
    model = _coefficients()
    years = min(max(year - model.epoch, 0.0), VALID_YEARS)
    gauss = model.values + years * model.changes
    latitude = math.radians(place.latitude_deg)
    radius_m, geocentric = _geocentric(latitude, place.altitude_m)
    sines = (math.sin(geocentric), max(math.cos(geocentric), 1e-10))
    legendre, slopes = _legendre(*sines, model.degree)
    orders = np.arange(model.degree + 1)
    turned = gauss * np.exp(-1j * orders * math.radians(place.longitude_deg))
    falloff = ((_SPHERE_M / radius_m) ** (orders + 2.0))[:, None]
    north = -float(np.sum(falloff * turned.real * slopes))
    east = float(np.sum(falloff * -turned.imag * orders * legendre)) / sines[1]
    down = -float(np.sum(falloff * (orders + 1.0)[:, None] * turned.real * legendre))
    tilt = geocentric - latitude
    level = north * math.cos(tilt) - down * math.sin(tilt)
    deep = north * math.sin(tilt) + down * math.cos(tilt)
    return _UT_PER_NT * east, _UT_PER_NT * level, -_UT_PER_NT * deep


def gravity_mps2(place: GeoPosition) -> float:
    """Return the acceleration of free fall (Somigliana's formula of WGS84, free-air gradient)."""
    squared = math.sin(math.radians(place.latitude_deg)) ** 2
    ground = 9.780_325_335_9 * (1.0 + 0.001_931_852_652_41 * squared)
    return ground / math.sqrt(1.0 - _ECCENTRICITY_SQUARED * squared) - 3.086e-6 * place.altitude_m


def _geocentric(latitude: float, altitude_m: float) -> tuple[float, float]:
    """Return the distance from the centre of the earth, m, and the geocentric latitude, rad."""
    normal_m = _EQUATOR_M / math.sqrt(1.0 - _ECCENTRICITY_SQUARED * math.sin(latitude) ** 2)
    level_m = (normal_m + altitude_m) * math.cos(latitude)
    axis_m = (normal_m * (1.0 - _ECCENTRICITY_SQUARED) + altitude_m) * math.sin(latitude)
    return math.hypot(level_m, axis_m), math.atan2(axis_m, level_m)


def _legendre(sine: float, cosine: float, degree: int) -> tuple[FloatArray, FloatArray]:
    """Return Schmidt's semi-normalised functions of a latitude, and their slopes, by n and m.

    The recursion is that of Holmes and Featherstone (2002) along the degree; a slope is the
    derivative by the latitude.
    """
    values, slopes = np.zeros((degree + 1, degree + 1)), np.zeros((degree + 1, degree + 1))
    values[0, 0] = 1.0
    for n in range(1, degree + 1):
        share = 1.0 if n == 1 else math.sqrt(1.0 - 0.5 / n)
        values[n, n] = share * cosine * values[n - 1, n - 1]
        slopes[n, n] = share * (cosine * slopes[n - 1, n - 1] - sine * values[n - 1, n - 1])
        for m in range(n):
            root = math.sqrt(n * n - m * m)
            first = (2 * n - 1) / root
            values[n, m] = first * sine * values[n - 1, m]
            slopes[n, m] = first * (sine * slopes[n - 1, m] + cosine * values[n - 1, m])
            if n > 1:
                second = math.sqrt((n - 1) ** 2 - m * m) / root
                values[n, m] -= second * values[n - 2, m]
                slopes[n, m] -= second * slopes[n - 2, m]
    return values, slopes


@cache
def _coefficients() -> _Coefficients:
    """Return the coefficients of the file."""
    text = files('rocsafe_sim.sensors').joinpath('WMM2025.COF').read_text(encoding='ascii')
    head, *rows = (line.split() for line in text.splitlines())
    values, changes = np.zeros((13, 13), complex), np.zeros((13, 13), complex)
    for n, m, *numbers in (row for row in rows if len(row) == 6):
        g, h, g_change, h_change = map(float, numbers)
        values[int(n), int(m)] = complex(g, h)
        changes[int(n), int(m)] = complex(g_change, h_change)
    return _Coefficients(float(head[0]), values, changes)
