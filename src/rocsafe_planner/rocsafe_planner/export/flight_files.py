# SPDX-License-Identifier: Apache-2.0
"""Flights for other autopilots and apps: MAVLink way-point list, GPX routes, DJI's KMZ.

Heights are metres above the place of take-off, in GPX metres above the ellipsoid. A flight goes to
above where it lands on its planned way and at its planned height, and lands there: what an
autopilot would do by itself on the way home (climb, fly straight) does not happen.
"""

import math
import zipfile
from io import BytesIO
from xml.etree.ElementTree import Element, SubElement

from rocsafe_geo.angle import heading_of_yaw_rad
from rocsafe_geo.mission_file import (
    FRAME_GLOBAL,
    FRAME_MISSION,
    FRAME_RELATIVE_ALTITUDE,
    IMAGE_START_CAPTURE,
    NAV_LAND,
    NAV_RETURN_TO_LAUNCH,
    NAV_TAKEOFF,
    NAV_WAYPOINT,
    xml_text,
)
from rocsafe_planner.plan.flight_path import (
    Stop,
    altitude_m,
    begins_aloft,
    flight_path,
    landing_place,
)
from rocsafe_planner.plan.flight_summary import flight_summary
from rocsafe_planner.plan.plan import Route

_KML = 'http://www.opengis.net/kml/2.2'
_WPML = 'http://www.dji.com/wpmz/1.0.2'
# Time of every entry, fixed so that equal plans give equal archives: the earliest of ZIP.
_ZIP_TIME = (1980, 1, 1, 0, 0, 0)


def flight_waypoints(route: Route, number: int) -> str:
    """Return a flight as a MAVLink way-point file (`QGC WPL 110`), home first.

    Columns, by tabs: index, current, frame, command, four parameters, latitude, longitude,
    altitude, autocontinue.
    """
    home = route.vehicle.home
    height = route.flight_height_m
    rows = [
        (FRAME_GLOBAL, NAV_WAYPOINT, (0.0,) * 4, _place(home.latitude_deg, home.longitude_deg)),
    ]
    if not begins_aloft(route, number):
        above = _place(home.latitude_deg, home.longitude_deg, height)
        rows.append((FRAME_RELATIVE_ALTITUDE, NAV_TAKEOFF, (0.0,) * 4, above))
    for stop in flight_path(route, number)[1:]:
        place = _place(stop.position.latitude_deg, stop.position.longitude_deg, stop.height_m)
        hold = route.vehicle.hover_s if stop.viewpoint else 0.0
        parameters = (hold, 0.0, 0.0, _heading_deg(stop))
        rows.append((FRAME_RELATIVE_ALTITUDE, NAV_WAYPOINT, parameters, place))
        if stop.viewpoint:
            rows.append((FRAME_MISSION, IMAGE_START_CAPTURE, (0.0, 0.0, 1.0, 0.0), _place()))
    landing = landing_place(route, number) or flight_path(route, number)[-1].position
    if landing == home:
        rows.append((FRAME_MISSION, NAV_RETURN_TO_LAUNCH, (0.0,) * 4, _place()))
    else:
        place = _place(landing.latitude_deg, landing.longitude_deg)
        rows.append((FRAME_RELATIVE_ALTITUDE, NAV_LAND, (0.0,) * 4, place))
    lines = [
        '\t'.join(
            [
                str(index),
                str(int(index == 0)),
                str(frame),
                str(command),
                *(f'{value:.8f}' for value in (*parameters, *place[:2])),
                f'{place[2]:.3f}',
                '1',
            ]
        )
        for index, (frame, command, parameters, place) in enumerate(rows)
    ]
    return '\n'.join(['QGC WPL 110', *lines]) + '\n'


def plan_gpx(routes: tuple[Route, ...]) -> str:
    """Return all flights as GPX 1.1 routes; viewpoints have names, bends none."""
    root = Element(
        'gpx', version='1.1', creator='ROCSAFE', xmlns='http://www.topografix.com/GPX/1/1'
    )
    for route in routes:
        for number in range(len(route.sorties)):
            line = SubElement(root, 'rte')
            suffix = f' flight {number + 1}' if number else ''
            SubElement(line, 'name').text = route.vehicle.name + suffix
            SubElement(line, 'desc').text = flight_summary(route, number).text
            for stop in flight_path(route, number):
                _gpx_point(line, stop, altitude_m(route, stop))
    return xml_text(root)


def flight_dji(route: Route, number: int) -> bytes:
    """Return a flight as DJI's `.kmz` with `wpmz/template.kml` and `wpmz/waylines.wpml`."""
    content = BytesIO()
    with zipfile.ZipFile(content, 'w') as archive:
        for name, root in (
            ('wpmz/template.kml', _dji_document(route, number, is_template=True)),
            ('wpmz/waylines.wpml', _dji_document(route, number, is_template=False)),
        ):
            info = zipfile.ZipInfo(name, date_time=_ZIP_TIME)
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, xml_text(root))
    return content.getvalue()


def _place(
    latitude_deg: float = 0.0, longitude_deg: float = 0.0, height_m: float = 0.0
) -> tuple[float, float, float]:
    return latitude_deg, longitude_deg, height_m


def _heading_deg(stop: Stop) -> float:
    """Return the heading clockwise from north, 0 where none is planned."""
    if stop.viewpoint is None:
        return 0.0
    return round(math.degrees(heading_of_yaw_rad(stop.viewpoint.yaw_rad)), 6) % 360.0


def _gpx_point(line: Element, stop: Stop, altitude_m: float) -> None:
    point = SubElement(
        line,
        'rtept',
        lat=f'{stop.position.latitude_deg:.9f}',
        lon=f'{stop.position.longitude_deg:.9f}',
    )
    if not math.isnan(altitude_m):
        SubElement(point, 'ele').text = f'{altitude_m:.3f}'
    if stop.viewpoint is not None:
        SubElement(point, 'name').text = str(stop.viewpoint.id)


def _dji_document(route: Route, number: int, *, is_template: bool) -> Element:
    root = Element('kml', {'xmlns': _KML, 'xmlns:wpml': _WPML})
    document = SubElement(root, 'Document')
    _dji_settings(document, route, number)
    folder = SubElement(document, 'Folder')
    if is_template:
        _wpml(folder, 'templateType', 'waypoint')
        coordinates = SubElement(folder, 'wpml:waylineCoordinateSysParam')
        _wpml(coordinates, 'coordinateMode', 'WGS84')
        _wpml(coordinates, 'heightMode', 'relativeToStartPoint')
    else:
        _wpml(folder, 'executeHeightMode', 'relativeToStartPoint')
        _wpml(folder, 'waylineId', '0')
    _wpml(folder, 'templateId', '0')
    _wpml(folder, 'autoFlightSpeed', f'{route.vehicle.cruise_speed_mps:g}')
    for index, stop in enumerate(flight_path(route, number)[1:]):
        placemark = SubElement(folder, 'Placemark')
        place = f'{stop.position.longitude_deg:.9f},{stop.position.latitude_deg:.9f}'
        SubElement(SubElement(placemark, 'Point'), 'coordinates').text = place
        _wpml(placemark, 'index', str(index))
        _wpml(placemark, 'height' if is_template else 'executeHeight', f'{stop.height_m:g}')
        _dji_turn(placemark, stop, route.vehicle.cruise_speed_mps)
        if stop.viewpoint is not None:
            _dji_photograph(placemark, index, route.vehicle.hover_s)
    return root


def _dji_settings(document: Element, route: Route, number: int) -> None:
    lands_at_home = landing_place(route, number) == route.vehicle.home
    settings = SubElement(document, 'wpml:missionConfig')
    for name, text in (
        ('flyToWaylineMode', 'safely'),
        ('finishAction', 'goHome' if lands_at_home else 'autoLand'),
        ('exitOnRCLost', 'executeLostAction'),
        ('executeRCLostAction', 'goBack'),
        ('takeOffSecurityHeight', f'{route.flight_height_m:g}'),
        ('globalTransitionalSpeed', f'{route.vehicle.cruise_speed_mps:g}'),
    ):
        _wpml(settings, name, text)


def _dji_turn(placemark: Element, stop: Stop, speed_mps: float) -> None:
    """Stop at the way-point, nose in the planned direction, -180 to 180 degrees."""
    _wpml(placemark, 'waypointSpeed', f'{speed_mps:g}')
    heading = SubElement(placemark, 'wpml:waypointHeadingParam')
    if stop.viewpoint is None:
        _wpml(heading, 'waypointHeadingMode', 'followWayline')
    else:
        _wpml(heading, 'waypointHeadingMode', 'smoothTransition')
        angle = (_heading_deg(stop) + 180.0) % 360.0 - 180.0
        _wpml(heading, 'waypointHeadingAngle', f'{angle:g}')
    turn = SubElement(placemark, 'wpml:waypointTurnParam')
    _wpml(turn, 'waypointTurnMode', 'toPointAndStopWithDiscontinuityCurvature')
    _wpml(turn, 'waypointTurnDampingDist', '0')


def _dji_photograph(placemark: Element, index: int, hover_s: float) -> None:
    group = SubElement(placemark, 'wpml:actionGroup')
    _wpml(group, 'actionGroupId', str(index))
    _wpml(group, 'actionGroupStartIndex', str(index))
    _wpml(group, 'actionGroupEndIndex', str(index))
    _wpml(group, 'actionGroupMode', 'sequence')
    _wpml(SubElement(group, 'wpml:actionTrigger'), 'actionTriggerType', 'reachPoint')
    actions: tuple[tuple[str, dict[str, str]], ...] = (
        (
            'gimbalRotate',
            {
                'gimbalPitchRotateEnable': '1',
                'gimbalPitchRotateAngle': '-90',
                'payloadPositionIndex': '0',
            },
        ),
        ('hover', {'hoverTime': f'{hover_s:g}'}),
        ('takePhoto', {'payloadPositionIndex': '0'}),
    )
    for number, (name, parameters) in enumerate(actions):
        action = SubElement(group, 'wpml:action')
        _wpml(action, 'actionId', str(number))
        _wpml(action, 'actionActuatorFunc', name)
        values = SubElement(action, 'wpml:actionActuatorFuncParam')
        for key, text in parameters.items():
            _wpml(values, key, text)


def _wpml(parent: Element, name: str, text: str) -> None:
    SubElement(parent, f'wpml:{name}').text = text
