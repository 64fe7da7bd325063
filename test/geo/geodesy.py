# SPDX-License-Identifier: Apache-2.0
"""Geodesy written out by hand, so that tests do not check PROJ with PROJ."""

import math

A = 6_378_137.0
F = 1.0 / 298.257223563
B = A * (1.0 - F)
E2 = F * (2.0 - F)


def ecef(lat_deg, lon_deg, alt_m):
    """Return earth-centred coordinates by the closed form of the ellipsoid's normal."""
    phi, lam = math.radians(lat_deg), math.radians(lon_deg)
    n = A / math.sqrt(1.0 - E2 * math.sin(phi) ** 2)
    return (
        (n + alt_m) * math.cos(phi) * math.cos(lam),
        (n + alt_m) * math.cos(phi) * math.sin(lam),
        (n * (1.0 - E2) + alt_m) * math.sin(phi),
    )


def enu(origin, point):
    """Return (east, north, up) of `point` about `origin`, both (lat, lon, alt)."""
    phi, lam = math.radians(origin[0]), math.radians(origin[1])
    x, y, z = (p - o for p, o in zip(ecef(*point), ecef(*origin), strict=True))
    outward = math.cos(lam) * x + math.sin(lam) * y
    return (
        math.cos(lam) * y - math.sin(lam) * x,
        math.cos(phi) * z - math.sin(phi) * outward,
        math.cos(phi) * outward + math.sin(phi) * z,
    )


def vincenty(lat1, lon1, lat2, lon2):
    """Return (distance in m, azimuth in rad) of the geodesic; Vincenty 1975, inverse formula."""
    u1 = math.atan((1.0 - F) * math.tan(math.radians(lat1)))
    u2 = math.atan((1.0 - F) * math.tan(math.radians(lat2)))
    length = lam = math.radians(lon2 - lon1)
    for _ in range(50):
        east = math.cos(u2) * math.sin(lam)
        north = math.cos(u1) * math.sin(u2) - math.sin(u1) * math.cos(u2) * math.cos(lam)
        sin_sigma = math.hypot(east, north)
        if sin_sigma == 0.0:
            return 0.0, 0.0
        cos_sigma = math.sin(u1) * math.sin(u2) + math.cos(u1) * math.cos(u2) * math.cos(lam)
        sigma = math.atan2(sin_sigma, cos_sigma)
        sin_alpha = math.cos(u1) * math.cos(u2) * math.sin(lam) / sin_sigma
        cos2_alpha = 1.0 - sin_alpha**2
        middle = cos_sigma - 2.0 * math.sin(u1) * math.sin(u2) / cos2_alpha if cos2_alpha else 0.0
        c = F / 16.0 * cos2_alpha * (4.0 + F * (4.0 - 3.0 * cos2_alpha))
        bracket = middle + c * cos_sigma * (2.0 * middle**2 - 1.0)
        before, lam = lam, length + (1.0 - c) * F * sin_alpha * (sigma + c * sin_sigma * bracket)
        if abs(lam - before) < 1e-15:
            break
    u_squared = cos2_alpha * (A**2 - B**2) / B**2
    big_a = 1.0 + u_squared / 16384.0 * (
        4096.0 + u_squared * (-768.0 + u_squared * (320.0 - 175.0 * u_squared))
    )
    big_b = (
        u_squared / 1024.0 * (256.0 + u_squared * (-128.0 + u_squared * (74.0 - 47.0 * u_squared)))
    )
    delta = (
        big_b
        * sin_sigma
        * (
            middle
            + big_b
            / 4.0
            * (
                cos_sigma * (2.0 * middle**2 - 1.0)
                - big_b / 6.0 * middle * (4.0 * sin_sigma**2 - 3.0) * (4.0 * middle**2 - 3.0)
            )
        )
    )
    return B * big_a * (sigma - delta), math.atan2(east, north)
