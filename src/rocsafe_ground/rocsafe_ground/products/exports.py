# SPDX-License-Identifier: Apache-2.0
"""A drive for Google Earth (KML), receivers (GPX) and ArduPilot Rover (QGroundControl plan).

Altitudes are 0 above the ground: a rover drives on it.
"""

from xml.etree.ElementTree import Element, SubElement

from rocsafe_geo.mission_file import (
    DO_CHANGE_SPEED,
    IMAGE_START_CAPTURE,
    NAV_WAYPOINT,
    Document,
    item,
    item_at,
    plan_document,
    xml_text,
)
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveStop
from rocsafe_ground.products.document import duration_text

_GROUND_SPEED = 1
# MAV_AUTOPILOT_ARDUPILOTMEGA and MAV_TYPE_GROUND_ROVER.
_KIND = 3, 10


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
    return xml_text(root)


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
    return xml_text(root)


def drive_qgroundcontrol(plan: DrivePlan) -> Document:
    """Return the way as a QGroundControl plan for ArduPilot Rover.

    Speeds are set before each line on which they change; at evidence the rover holds and takes a
    photograph.
    """
    return plan_document(_items(plan), plan.stops[0].place, plan.request.vehicle.road_mps, _KIND)


def _items(plan: DrivePlan) -> list[Document]:
    items, speed = [], 0.0
    for stop in plan.stops[1:]:
        wanted = round(stop.speed_mps, 2)
        if wanted != speed:
            speed = wanted
            items.append(item(DO_CHANGE_SPEED, [_GROUND_SPEED, speed, -1, 0, 0, 0, 0]))
        items.append(item_at(stop.place, 0, NAV_WAYPOINT, (stop.dwell_s, 0, 0, None)))
        if stop.evidence:
            items.append(item(IMAGE_START_CAPTURE, [0, 0, 1, *[None] * 4]))
    return items


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
