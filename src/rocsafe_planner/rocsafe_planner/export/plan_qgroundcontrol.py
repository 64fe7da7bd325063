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
from typing import Any

from rocsafe_geo.angle import heading_of_yaw_rad
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.document import Document
from rocsafe_planner.plan.flight_path import Stop, begins_aloft, flight_path, landing_place
from rocsafe_planner.plan.plan import Route, Viewpoint

# MAVLink common message set.
_NAV_WAYPOINT = 16
_NAV_RETURN_TO_LAUNCH = 20
_NAV_LAND = 21
_NAV_TAKEOFF = 22
_IMAGE_START_CAPTURE = 2000
_FRAME_MISSION = 2
_FRAME_RELATIVE_ALTITUDE = 3
# QGroundControl's own.
_ALTITUDE_RELATIVE = 1
_FIRMWARE_GENERIC = 0
_VEHICLE_MULTIROTOR = 2


def flight_qgroundcontrol(
    route: Route, number: int, exclusions: tuple[SurveyArea, ...] = ()
) -> Document:
    """Return the plan of flight `number` of a route; no items if it has no such flight."""
    home = route.vehicle.home
    return {
        'fileType': 'Plan',
        'version': 1,
        'groundStation': 'QGroundControl',
        'geoFence': {
            'circles': [],
            'polygons': [_fence(zone) for zone in exclusions],
            'version': 2,
        },
        'rallyPoints': {'points': [], 'version': 2},
        'mission': {
            'version': 2,
            'firmwareType': _FIRMWARE_GENERIC,
            'vehicleType': _VEHICLE_MULTIROTOR,
            'globalPlanAltitudeMode': _ALTITUDE_RELATIVE,
            'cruiseSpeed': route.vehicle.cruise_speed_mps,
            'hoverSpeed': route.vehicle.cruise_speed_mps,
            'plannedHomePosition': [home.latitude_deg, home.longitude_deg, 0.0],
            'items': _items(route, number),
        },
    }


def _fence(zone: SurveyArea) -> Document:
    """Return a zone that is not to be entered; QGroundControl's fences have no holes."""
    corners = [[corner.latitude_deg, corner.longitude_deg] for corner in zone.boundary]
    return {'inclusion': False, 'polygon': corners, 'version': 1}


def _items(route: Route, number: int) -> list[Document]:
    if number >= len(route.sorties):
        return []
    home, height = route.vehicle.home, route.flight_height_m
    takeoff = _place(_NAV_TAKEOFF, [0, 0, 0, None], home.latitude_deg, home.longitude_deg, height)
    items = [] if begins_aloft(route, number) else [takeoff]
    way = flight_path(route, number)
    landing = landing_place(route, number)
    for stop in way[1:]:
        items.extend(_stop(stop, route.vehicle.hover_s))
    items.append(_landing(home, landing or way[-1].position))
    return [{**item, 'doJumpId': number} for number, item in enumerate(items, start=1)]


def _landing(home: GeoPosition, place: GeoPosition) -> Document:
    if place == home:
        return _item(_NAV_RETURN_TO_LAUNCH, _FRAME_MISSION, [0] * 7)
    return _place(_NAV_LAND, [0, 0, 0, None], place.latitude_deg, place.longitude_deg, 0.0)


def _stop(stop: Stop, hold_s: float) -> list[Document]:
    if stop.viewpoint is None:
        place = stop.position
        passing = [0, 0, 0, None]
        return [
            _place(_NAV_WAYPOINT, passing, place.latitude_deg, place.longitude_deg, stop.height_m)
        ]
    shot = _item(_IMAGE_START_CAPTURE, _FRAME_MISSION, [0, 0, 1, *[None] * 4])
    return [_waypoint(stop.viewpoint, hold_s, stop.height_m), shot]


def _waypoint(viewpoint: Viewpoint, hold_s: float, height_m: float) -> Document:
    heading_deg = round(math.degrees(heading_of_yaw_rad(viewpoint.yaw_rad)), 6) % 360.0
    place = viewpoint.position
    return _place(
        _NAV_WAYPOINT,
        [hold_s, 0, 0, heading_deg],
        place.latitude_deg,
        place.longitude_deg,
        height_m,
    )


def _place(
    command: int, first: list[Any], latitude_deg: float, longitude_deg: float, height_m: float
) -> Document:
    """Return an item at a place; `first` are the command's own four parameters."""
    params = [*first, round(latitude_deg, 9), round(longitude_deg, 9), height_m]
    return {
        **_item(command, _FRAME_RELATIVE_ALTITUDE, params),
        'Altitude': height_m,
        'AltitudeMode': _ALTITUDE_RELATIVE,
        'AMSLAltAboveTerrain': None,
    }


def _item(command: int, frame: int, params: list[Any]) -> Document:
    return {
        'type': 'SimpleItem',
        'autoContinue': True,
        'command': command,
        'frame': frame,
        'params': params,
    }
