# SPDX-License-Identifier: Apache-2.0
"""The local frame: east, north, up in metres about an origin on the WGS84 ellipsoid."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from pyproj import Transformer

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_finite
from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_body
from rocsafe_geo.position import GeoPosition, ecef_m
from rocsafe_geo.projection import columns, transform

# East, north and up at latitude and longitude 0, as columns: y, z and x of the earth.
_EAST_NORTH_UP = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """East-north-up metres about `origin`, which must have a known altitude.

    The frame is a Cartesian one, tangent to the ellipsoid at the origin (REP 103, EPSG method
    9837): exact at any distance. A plane ``up = 0`` leaves the curved earth by d^2/2R, which is
    0.31 m at 2 km.
    """

    origin: GeoPosition

    def __post_init__(self) -> None:
        require_finite('origin altitude_m', self.origin.altitude_m)

    def earth_pose(
        self,
    ) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
        """Return the frame in earth-centred coordinates: origin in metres and rotation.

        The rotation, a quaternion (x, y, z, w), turns east, north, up into the axes of the
        earth (REP 105, frame `earth`).
        """
        latitude, longitude = map(
            math.radians, (self.origin.latitude_deg, self.origin.longitude_deg)
        )
        rotation = rotation_enu_from_body(longitude, -latitude, 0.0) @ _EAST_NORTH_UP
        place = ecef_m(self.origin.latitude_deg, self.origin.longitude_deg, self.origin.altitude_m)
        x, y, z = map(float, place[0])
        qx, qy, qz, qw = map(float, quaternion_of_rotation(rotation))
        return (x, y, z), (qx, qy, qz, qw)

    def to_enu(
        self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike, altitudes_m: ArrayLike
    ) -> FloatArray:
        """Return (east, north, up) in metres, shape (n, 3).

        Arguments are scalars or of shape (n,). Where an altitude is NaN (unknown), east and north
        are those of a point at the origin's altitude, and up is NaN.
        """
        latitudes, longitudes, altitudes = columns(latitudes_deg, longitudes_deg, altitudes_m)
        known = np.where(np.isnan(altitudes), self.origin.altitude_m, altitudes)
        enu = transform(_topocentric(self.origin), longitudes, latitudes, known)
        enu[np.isnan(altitudes), 2] = np.nan
        return enu

    def to_geodetic(self, enu: ArrayLike) -> FloatArray:
        """Return columns latitude in degrees, longitude in degrees, altitude in metres; (n, 3).

        `enu` has shape (n, 3) or (3,), in metres. Where up is NaN, the altitude is NaN and the
        position is that of the point at up = 0.
        """
        points = np.atleast_2d(np.asarray(enu, float))
        ups = np.where(np.isnan(points[:, 2]), 0.0, points[:, 2])
        geodetic = transform(
            _topocentric(self.origin), points[:, 0], points[:, 1], ups, inverse=True
        )[:, [1, 0, 2]]
        geodetic[np.isnan(points[:, 2]), 2] = np.nan
        return geodetic

    def enu_of(self, position: GeoPosition) -> FloatArray:
        """Return (east, north, up) of one position in metres, shape (3,)."""
        enu: FloatArray = self.to_enu(
            position.latitude_deg, position.longitude_deg, position.altitude_m
        )[0]
        return enu

    def plane_of(self, positions: Sequence[GeoPosition]) -> FloatArray:
        """Return (east, north) of positions in metres, shape (n, 2)."""
        return self.to_enu(
            [position.latitude_deg for position in positions],
            [position.longitude_deg for position in positions],
            math.nan,
        )[:, :2]

    def position_of(self, enu: ArrayLike) -> GeoPosition:
        """Return the position of one point (east, north, up) in metres."""
        latitude, longitude, altitude = self.to_geodetic(enu)[0].tolist()
        return GeoPosition(latitude, longitude, altitude)


@lru_cache(maxsize=64)
def _topocentric(origin: GeoPosition) -> Transformer:
    """Return the transformation from WGS84; cached, as its set-up takes a millisecond."""
    place = f'+lat_0={origin.latitude_deg!r} +lon_0={origin.longitude_deg!r}'
    return Transformer.from_pipeline(
        '+proj=pipeline +step +proj=cart +ellps=WGS84 '
        f'+step +proj=topocentric +ellps=WGS84 {place} +h_0={origin.altitude_m!r}'
    )
