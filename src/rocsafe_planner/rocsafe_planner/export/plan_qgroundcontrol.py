# SPDX-License-Identifier: Apache-2.0
"""One flight of a vehicle as a QGroundControl plan (`.plan`, file format version 1).

Take-off, then at each viewpoint a waypoint with the vehicle's hover time as hold and one
photograph, waypoints without one where legs bend and above where it lands, then return to launch,
or land elsewhere. The format has no time of take-off: see `flight_summary`. Exclusions are a
geo-fence. A waypoint's heading is the planned one. Altitudes are relative to home
(MAV_FRAME_GLOBAL_RELATIVE_ALT). QGroundControl wants the home's altitude above mean sea level,
which a plan above the ellipsoid does not hold: it is written as 0, and nothing is relative to it.
QGroundControl estimates times with the cruise speed; set the vehicle's own parameter to the same
value.
"""

import math

from rocsafe_geo.angle import heading_of_yaw_rad
from rocsafe_geo.mission_file import (
    IMAGE_START_CAPTURE,
    NAV_LAND,
    NAV_RETURN_TO_LAUNCH,
    NAV_TAKEOFF,
    NAV_WAYPOINT,
    Document,
    item,
    item_at,
    plan_document,
)
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.flight_path import Stop, begins_aloft, flight_path, landing_place
from rocsafe_planner.plan.plan import Route

# MAV_AUTOPILOT_GENERIC and MAV_TYPE_QUADROTOR.
_KIND = 0, 2


def flight_qgroundcontrol(
    route: Route, number: int, exclusions: tuple[SurveyArea, ...] = ()
) -> Document:
    """Return the plan of flight `number` of a route; no items if it has no such flight."""
    fence = [_fence(zone) for zone in exclusions]
    speed_mps = route.vehicle.cruise_speed_mps
    return plan_document(_items(route, number), route.vehicle.home, speed_mps, _KIND, fence)


def _fence(zone: SurveyArea) -> Document:
    """Return a zone that is not to be entered; QGroundControl's fences have no holes."""
    corners = [[corner.latitude_deg, corner.longitude_deg] for corner in zone.boundary]
    return {'inclusion': False, 'polygon': corners, 'version': 1}


def _items(route: Route, number: int) -> list[Document]:
    if number >= len(route.sorties):
        return []
    home, way = route.vehicle.home, flight_path(route, number)
    items = []
    if not begins_aloft(route, number):
        items.append(item_at(home, route.flight_height_m, NAV_TAKEOFF))
    for stop in way[1:]:
        items.extend(_stop(stop, route.vehicle.hover_s))
    landing = landing_place(route, number) or way[-1].position
    is_home = landing == home
    return [
        *items,
        item(NAV_RETURN_TO_LAUNCH, [0] * 7) if is_home else item_at(landing, 0.0, NAV_LAND),
    ]


def _stop(stop: Stop, hold_s: float) -> list[Document]:
    if stop.viewpoint is None:
        return [item_at(stop.position, stop.height_m, NAV_WAYPOINT)]
    heading_deg = round(math.degrees(heading_of_yaw_rad(stop.viewpoint.yaw_rad)), 6) % 360.0
    waypoint = item_at(
        stop.viewpoint.position, stop.height_m, NAV_WAYPOINT, (hold_s, 0, 0, heading_deg)
    )
    return [waypoint, item(IMAGE_START_CAPTURE, [0, 0, 1, *[None] * 4])]
