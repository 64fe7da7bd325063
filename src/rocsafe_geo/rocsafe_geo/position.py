# SPDX-License-Identifier: Apache-2.0
"""Positions on the WGS84 ellipsoid, distances between them, offsets from them."""

import math
from dataclasses import dataclass
from functools import lru_cache

from numpy.typing import ArrayLike
from pyproj import Geod, Transformer

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between, require_finite
from rocsafe_geo.projection import columns, transform

_WGS84 = Geod(ellps='WGS84')
# Metres in a degree of latitude on a sphere of the mean radius of the Earth, 6371 km.
METRES_A_DEGREE = 111_195.0


@dataclass(frozen=True, slots=True)
class GeoPosition:
    """A WGS84 position: latitude and longitude in degrees, altitude above the ellipsoid in metres.

    North and east are positive. An altitude of NaN means that it is not known.

    Raises
    ------
    ValueError
        If latitude is outside -90..90, longitude outside -180..180, or altitude infinite.
    """

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = math.nan

    def __post_init__(self) -> None:
        latitude = require_between('latitude_deg', self.latitude_deg, -90.0, 90.0)
        longitude = require_between('longitude_deg', self.longitude_deg, -180.0, 180.0)
        # One NaN object for all unknown altitudes: equal positions then compare equal.
        altitude = math.nan
        if not _is_nan(self.altitude_m):
            altitude = require_finite('altitude_m', self.altitude_m)
        object.__setattr__(self, 'latitude_deg', latitude)
        object.__setattr__(self, 'longitude_deg', longitude)
        object.__setattr__(self, 'altitude_m', altitude)


def distance_m(a: GeoPosition, b: GeoPosition) -> float:
    """Return the geodesic distance along the ellipsoid (Karney 2013); altitudes do not count."""
    _, _, distance = _WGS84.inv(a.longitude_deg, a.latitude_deg, b.longitude_deg, b.latitude_deg)
    return float(distance)


def level_offset_m(origin: GeoPosition, place: GeoPosition) -> tuple[float, float]:
    """Return metres east and north of `origin`, on a plane that touches a sphere there.

    Good to 1 % within 3 km and 70 degrees of latitude; `LocalFrame` is exact.
    """
    turn_deg = math.remainder(place.longitude_deg - origin.longitude_deg, 360.0)
    east_deg = turn_deg * math.cos(math.radians(origin.latitude_deg))
    north_deg = place.latitude_deg - origin.latitude_deg
    return METRES_A_DEGREE * east_deg, METRES_A_DEGREE * north_deg


def offset(a: GeoPosition, east_m: float, north_m: float, up_m: float = 0.0) -> GeoPosition:
    """Return the position reached from `a` along the ellipsoid.

    The geodesic starts in the direction (east, north) and has the length of that vector, so that
    ``distance_m(a, offset(a, e, n))`` is ``hypot(e, n)``. `up_m` is added to the altitude; an
    unknown altitude stays unknown.
    """
    east = require_finite('east_m', east_m)
    north = require_finite('north_m', north_m)
    azimuth_deg = math.degrees(math.atan2(east, north))
    longitude, latitude, _ = _WGS84.fwd(
        a.longitude_deg, a.latitude_deg, azimuth_deg, math.hypot(east, north)
    )
    return GeoPosition(latitude, longitude, a.altitude_m + require_finite('up_m', up_m))


def ecef_m(
    latitudes_deg: ArrayLike, longitudes_deg: ArrayLike, altitudes_m: ArrayLike
) -> FloatArray:
    """Return earth-centred, earth-fixed coordinates in metres, shape (n, 3).

    Arguments are scalars or of shape (n,), WGS84, altitudes above the ellipsoid.
    """
    longitudes, latitudes, altitudes = columns(longitudes_deg, latitudes_deg, altitudes_m)
    return transform(_to_ecef(), longitudes, latitudes, altitudes)


@lru_cache(maxsize=1)
def _to_ecef() -> Transformer:
    return Transformer.from_pipeline('+proj=cart +ellps=WGS84')


def _is_nan(value: float) -> bool:
    return isinstance(value, float) and math.isnan(value)
