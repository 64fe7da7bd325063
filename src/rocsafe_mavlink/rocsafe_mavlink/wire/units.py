# SPDX-License-Identifier: Apache-2.0
"""MAVLink's integers <-> SI units, radians and degrees.

Latitudes and longitudes are 1e-7 degrees (1.1 cm). They are rounded, never truncated: truncation
moves every place south-west by half a unit. They never pass through single-precision floats, whose
step is metres there.
"""

import math

from rocsafe_geo.angle import yaw_of_heading_rad
from rocsafe_geo.limits import require_finite
from rocsafe_geo.position import GeoPosition

E7 = 10_000_000
# "Not known" in unsigned fields of 16 bits.
UNKNOWN_16 = 65_535


def e7_of_deg(angle_deg: float) -> int:
    """Return degrees as 1e-7 degrees.

    Raises
    ------
    ValueError
        If the angle is not finite.
    """
    return round(require_finite('angle_deg', angle_deg) * E7)


def deg_of_e7(angle_e7: int) -> float:
    """Return 1e-7 degrees as degrees."""
    return angle_e7 / E7


def m_of_mm(length_mm: int) -> float:
    """Return millimetres as metres."""
    return length_mm / 1000.0


def position_of_e7(latitude_e7: int, longitude_e7: int, altitude_m: float) -> GeoPosition:
    """Return a position; `altitude_m` is above the ellipsoid, NaN if not known."""
    return GeoPosition(deg_of_e7(latitude_e7), deg_of_e7(longitude_e7), altitude_m)


def enu_of_ned_cmps(north: int, east: int, down: int) -> tuple[float, float, float]:
    """Return a velocity in cm/s north, east, down as m/s east, north, up."""
    return east / 100.0, north / 100.0, -down / 100.0


def yaw_of_centidegrees(heading: int) -> float:
    """Return the yaw (REP 103) of a heading in 0.01 degrees; NaN if it is not known."""
    if heading == UNKNOWN_16:
        return math.nan
    return yaw_of_heading_rad(math.radians(heading / 100.0))
