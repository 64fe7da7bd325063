# SPDX-License-Identifier: Apache-2.0
"""A drive for Google Earth (KML), receivers (GPX) and ArduPilot Rover (QGroundControl plan).

Altitudes are 0 above the ground: a rover drives on it.
"""

from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from rocsafe_ground.drive.drive_plan import DrivePlan, DriveStop
from rocsafe_ground.products.document import Document, duration_text

# MAVLink common message set.
_NAV_WAYPOINT, _NAV_RETURN_TO_LAUNCH = 16, 20
_DO_CHANGE_SPEED, _IMAGE_START_CAPTURE = 178, 2000
_FRAME_MISSION, _FRAME_RELATIVE_ALTITUDE = 2, 3
_GROUND_SPEED = 1
# QGroundControl's own, and MAVLink's numbers of autopilot and vehicle.
_ALTITUDE_RELATIVE, _ARDUPILOT, _ROVER = 1, 3, 10


def drive_kml(plan: DrivePlan) -> str:
    """Return the way and its stands as KML 2.2, on the ground."""
    root = Element('kml', xmlns='http://www.opengis.net/kml/2.2')
    document = SubElement(root, 'Document')
    SubElement(document, 'name').text = 'ROCSAFE drive'
    SubElement(
        document, 'description'
    ).text = (
        f'{plan.length_m:.0f} m, {duration_text(plan.time_s)}, {plan.forecast.mean_usv:.4g} uSv'
    )
    style = SubElement(SubElement(document, 'Style', id='route'), 'LineStyle')
    SubElement(style, 'color').text = 'ffeb6f1f'
    SubElement(style, 'width').text = '4'
    way = _placemark(document, 'route')
    SubElement(way, 'styleUrl').text = '#route'
    _geometry(way, 'LineString', plan.stops)
    for stop in plan.stops:
        if stop.evidence:
            _geometry(_placemark(document, stop.evidence), 'Point', (stop,))
    return _xml(root)


def drive_gpx(plan: DrivePlan) -> str:
    """Return the way as a GPX 1.1 route; stands have names, bends none."""
    root = Element(
        'gpx', version='1.1', creator='ROCSAFE', xmlns='http://www.topografix.com/GPX/1/1'
    )
    route = SubElement(root, 'rte')
    SubElement(route, 'name').text = 'drive'
    for stop in plan.stops:
        place = stop.place
        point = SubElement(
            route, 'rtept', lat=f'{place.latitude_deg:.9f}', lon=f'{place.longitude_deg:.9f}'
        )
        if stop.evidence:
            SubElement(point, 'name').text = stop.evidence
    return _xml(root)


def drive_qgroundcontrol(plan: DrivePlan) -> Document:
    """Return the way as a QGroundControl plan for ArduPilot Rover.

    Speeds are set before each line on which they change; at evidence the rover holds and takes a
    photograph.
    """
    start = plan.stops[0].place
    speed = plan.request.vehicle.road_mps
    return {
        'fileType': 'Plan',
        'version': 1,
        'groundStation': 'QGroundControl',
        'geoFence': {'circles': [], 'polygons': [], 'version': 2},
        'rallyPoints': {'points': [], 'version': 2},
        'mission': {
            'version': 2,
            'firmwareType': _ARDUPILOT,
            'vehicleType': _ROVER,
            'globalPlanAltitudeMode': _ALTITUDE_RELATIVE,
            'cruiseSpeed': speed,
            'hoverSpeed': speed,
            'plannedHomePosition': [start.latitude_deg, start.longitude_deg, 0.0],
            'items': _items(plan),
        },
    }


def _items(plan: DrivePlan) -> list[Document]:
    items, speed = [], 0.0
    for stop in plan.stops[1:]:
        wanted = round(stop.speed_mps, 2)
        if wanted != speed:
            speed = wanted
            items.append(_item(_DO_CHANGE_SPEED, [_GROUND_SPEED, speed, -1, 0, 0, 0, 0]))
        place = [round(stop.place.latitude_deg, 9), round(stop.place.longitude_deg, 9), 0]
        item = _item(_NAV_WAYPOINT, [stop.dwell_s, 0, 0, None, *place], _FRAME_RELATIVE_ALTITUDE)
        items.append({
            **item, 'Altitude': 0, 'AltitudeMode': _ALTITUDE_RELATIVE, 'AMSLAltAboveTerrain': None
        })  # fmt: skip
        if stop.evidence:
            items.append(_item(_IMAGE_START_CAPTURE, [0, 0, 1, *[None] * 4]))
    return [{**item, 'doJumpId': number} for number, item in enumerate(items, start=1)]


def _item(command: int, params: list[Any], frame: int = _FRAME_MISSION) -> Document:
    return {
        'type': 'SimpleItem', 'autoContinue': True, 'command': command, 'frame': frame,
        'params': params,
    }  # fmt: skip


def _placemark(parent: Element, name: str) -> Element:
    mark = SubElement(parent, 'Placemark')
    SubElement(mark, 'name').text = name
    return mark


def _geometry(mark: Element, kind: str, stops: tuple[DriveStop, ...]) -> None:
    shape = SubElement(mark, kind)
    if kind == 'LineString':
        SubElement(shape, 'tessellate').text = '1'
    places = (stop.place for stop in stops)
    SubElement(shape, 'coordinates').text = ' '.join(
        f'{place.longitude_deg:.9f},{place.latitude_deg:.9f},0' for place in places
    )


def _xml(root: Element) -> str:
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(root, "unicode")}\n'
