# SPDX-License-Identifier: Apache-2.0
"""Options of nodes that know the origin of the mission's local frame."""

from dataclasses import dataclass

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.option import option
from rocsafe_geo.position import GeoPosition


@dataclass(frozen=True, slots=True, kw_only=True)
class OriginOptions:
    """Origin of the local frame of the mission; level ground is its plane up = 0."""

    origin_latitude_deg: float = option(0.0, 'latitude of the mission origin, deg', -90.0, 90.0)
    origin_longitude_deg: float = option(
        0.0, 'longitude of the mission origin, deg', -180.0, 180.0
    )
    origin_altitude_m: float = option(
        0.0, 'altitude of the ground above the ellipsoid, m', -1e3, 1e4
    )

    def origin(self) -> GeoPosition:
        """Return the origin.

        Raises
        ------
        ValueError
            If it is out of range.
        """
        return GeoPosition(
            self.origin_latitude_deg, self.origin_longitude_deg, self.origin_altitude_m
        )

    def frame(self) -> LocalFrame:
        """Return the local frame of the mission.

        Raises
        ------
        ValueError
            If its origin is out of range.
        """
        return LocalFrame(self.origin())
