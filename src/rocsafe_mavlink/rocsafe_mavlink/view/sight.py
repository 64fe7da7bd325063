# SPDX-License-Identifier: Apache-2.0
"""What a ground station is shown of a simulated vehicle."""

import math
from dataclasses import dataclass

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.protocols.mission_item import MISSION_FRAME, RELATIVE_INT, MissionItem
from rocsafe_mavlink.wire.authority import NAV_RETURN_TO_LAUNCH, NAV_TAKEOFF
from rocsafe_mavlink.wire.units import e7_of_deg

NAV_WAYPOINT = 16


@dataclass(slots=True)
class Sight:
    """The newest that is known of one vehicle; None and NaN until it is heard.

    Attributes
    ----------
    system
        Its MAVLink system, 1 to 250.
    position, home
        Where it is and returns, altitude above the ellipsoid.
    velocity_enu
        Metres a second, east, north, up.
    yaw_rad
        ENU, anticlockwise from east.
    battery_fraction, voltage_v, current_a
        Charge left, 0 to 1, voltage and the current drawn.
    is_airborne, is_climbing, is_landing, is_crashed
        What it does.
    items
        Its route as a mission.
    reached
        Viewpoints that it has visited.
    """

    system: int
    position: GeoPosition | None = None
    home: GeoPosition | None = None
    velocity_enu: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw_rad: float = 0.0
    battery_fraction: float = math.nan
    voltage_v: float = math.nan
    current_a: float = math.nan
    is_airborne: bool = False
    is_climbing: bool = False
    is_landing: bool = False
    is_crashed: bool = False
    items: tuple[MissionItem, ...] = ()
    reached: int = 0

    @property
    def heading_deg(self) -> float:
        """Clockwise from north, 0 to 360."""
        return math.degrees(math.pi / 2.0 - self.yaw_rad) % 360.0

    @property
    def height_m(self) -> float:
        """Height above home; 0 while one of them is not known."""
        if self.position is None or self.home is None:
            return 0.0
        return self.position.altitude_m - self.home.altitude_m

    @property
    def current_item(self) -> int:
        """Number of the item that it flies to; the first one is the take-off."""
        return min(self.reached + 1, max(len(self.items) - 1, 0)) if self.is_airborne else 0


def mission_of(viewpoints: tuple[GeoPosition, ...], home: GeoPosition) -> tuple[MissionItem, ...]:
    """Return a route as a mission: take-off, a waypoint for each viewpoint, return; or nothing."""
    if not viewpoints:
        return ()
    heights = [place.altitude_m - home.altitude_m for place in viewpoints]
    ways = (
        MissionItem(
            command=NAV_WAYPOINT,
            frame=RELATIVE_INT,
            x_e7=e7_of_deg(place.latitude_deg),
            y_e7=e7_of_deg(place.longitude_deg),
            z_m=height,
        )
        for place, height in zip(viewpoints, heights, strict=True)
    )
    return (
        MissionItem(
            command=NAV_TAKEOFF,
            x_e7=e7_of_deg(home.latitude_deg),
            y_e7=e7_of_deg(home.longitude_deg),
            z_m=heights[0],
        ),
        *ways,
        MissionItem(command=NAV_RETURN_TO_LAUNCH, frame=MISSION_FRAME),
    )
