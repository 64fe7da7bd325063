# SPDX-License-Identifier: Apache-2.0
"""Missions as QGroundControl plans (`.plan`, version 1), and the text of XML files."""

from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from rocsafe_geo.position import GeoPosition

Document = dict[str, Any]
# MAVLink common message set.
NAV_WAYPOINT, NAV_RETURN_TO_LAUNCH, NAV_LAND, NAV_TAKEOFF = 16, 20, 21, 22
DO_CHANGE_SPEED, IMAGE_START_CAPTURE = 178, 2000
FRAME_GLOBAL, FRAME_MISSION, FRAME_RELATIVE_ALTITUDE = 0, 2, 3
# QGroundControl's own.
_ALTITUDE_RELATIVE = 1


def plan_document(
    items: Sequence[Document],
    home: GeoPosition,
    speed_mps: float,
    kind: tuple[int, int],
    fence: Sequence[Document] = (),
) -> Document:
    """Return a plan.

    Parameters
    ----------
    items
        Items of the mission in order.
    home
        Planned home; its altitude is written as 0, and nothing is relative to it.
    speed_mps
        Speed by which QGroundControl estimates times.
    kind
        MAV_AUTOPILOT and MAV_TYPE.
    fence
        Polygons of the geo-fence.
    """
    return {
        'fileType': 'Plan',
        'version': 1,
        'groundStation': 'QGroundControl',
        'geoFence': {'circles': [], 'polygons': list(fence), 'version': 2},
        'rallyPoints': {'points': [], 'version': 2},
        'mission': {
            'version': 2,
            'firmwareType': kind[0],
            'vehicleType': kind[1],
            'globalPlanAltitudeMode': _ALTITUDE_RELATIVE,
            'cruiseSpeed': speed_mps,
            'hoverSpeed': speed_mps,
            'plannedHomePosition': [home.latitude_deg, home.longitude_deg, 0.0],
            'items': [{**one, 'doJumpId': number} for number, one in enumerate(items, start=1)],
        },
    }


def item(command: int, params: Sequence[Any], frame: int = FRAME_MISSION) -> Document:
    """Return an item of a mission with its seven parameters."""
    return {
        'type': 'SimpleItem', 'autoContinue': True, 'command': command, 'frame': frame,
        'params': list(params),
    }  # fmt: skip


def item_at(
    place: GeoPosition, height_m: float, command: int, first: Sequence[Any] = (0, 0, 0, None)
) -> Document:
    """Return an item at a place above home; `first` are the command's own four parameters."""
    params = [*first, round(place.latitude_deg, 9), round(place.longitude_deg, 9), height_m]
    return {
        **item(command, params, FRAME_RELATIVE_ALTITUDE),
        'Altitude': height_m,
        'AltitudeMode': _ALTITUDE_RELATIVE,
        'AMSLAltAboveTerrain': None,
    }


def xml_text(root: Element) -> str:
    """Return an XML file, indented."""
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(root, "unicode")}\n'
