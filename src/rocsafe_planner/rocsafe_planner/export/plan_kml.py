# SPDX-License-Identifier: Apache-2.0
"""The plan for Google Earth: KML 2.2, heights relative to the ground."""

from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement

from rocsafe_geo.mission_file import xml_text
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.export.plan_geojson import area_rings
from rocsafe_planner.export.route_colors import kml_color
from rocsafe_planner.plan.flight_path import begins_aloft, flight_path
from rocsafe_planner.plan.flight_summary import flight_summary
from rocsafe_planner.plan.plan import Route, SurveyPlan

_NAMESPACE = 'http://www.opengis.net/kml/2.2'
_DOT = 'http://maps.google.com/mapfiles/kml/shapes/placemark_circle.png'
_HOME = 'http://maps.google.com/mapfiles/kml/shapes/heliport.png'


def plan_kml(plan: SurveyPlan) -> str:
    """Return a document with a folder for the region and one for each vehicle."""
    root = Element('kml', xmlns=_NAMESPACE)
    document = SubElement(root, 'Document')
    name = plan.request.regions[0].area.name or 'survey'
    _text(document, 'name', f'ROCSAFE plan {plan.plan_id}: {name}')
    _text(document, 'description', _summary(plan))
    _area_style(document, 'region', 'ffffff')
    _area_style(document, 'exclusion', '0000aa')
    for index in range(len(plan.routes)):
        _vehicle_style(document, index)
    _regions(document, plan)
    for index, route in enumerate(plan.routes):
        _vehicle(document, route, index)
    return xml_text(root)


def _summary(plan: SurveyPlan) -> str:
    return (
        f'{plan.viewpoint_count} photographs at '
        f'{plan.request.coverage.height_agl_m:g} m above ground, '
        f'{100.0 * plan.covered_fraction:.1f} % of {plan.region_area_m2:.0f} m2 covered, '
        f'{plan.makespan_s:.0f} s (no plan is shorter than {plan.lower_bound_s:.0f} s)'
    )


def _area_style(document: Element, name: str, color: str) -> None:
    style = SubElement(document, 'Style', id=name)
    _text(SubElement(style, 'LineStyle'), 'color', f'ff{color}')
    _text(SubElement(style, 'PolyStyle'), 'color', f'30{color}')


def _vehicle_style(document: Element, index: int) -> None:
    style = SubElement(document, 'Style', id=f'vehicle{index}')
    icon_style = SubElement(style, 'IconStyle')
    _text(icon_style, 'color', kml_color(index))
    _text(icon_style, 'scale', '0.5')
    _text(SubElement(icon_style, 'Icon'), 'href', _DOT)
    _text(SubElement(style, 'LabelStyle'), 'scale', '0.6')
    line = SubElement(style, 'LineStyle')
    _text(line, 'color', kml_color(index))
    _text(line, 'width', '3')


def _regions(document: Element, plan: SurveyPlan) -> None:
    folder = _folder(document, 'Region')
    for region in plan.request.regions:
        _area(_placemark(folder, region.area.name or 'region', 'region'), region.area)
    if plan.request.exclusions:
        folder = _folder(document, 'Exclusions')
    for zone in plan.request.exclusions:
        _area(_placemark(folder, zone.name or 'exclusion', 'exclusion'), zone)


def _area(placemark: Element, area: SurveyArea) -> None:
    polygon = SubElement(placemark, 'Polygon')
    _text(polygon, 'tessellate', '1')
    outer, *inner = area_rings(area)
    for tag, ring in (('outerBoundaryIs', outer), *(('innerBoundaryIs', hole) for hole in inner)):
        linear = SubElement(SubElement(polygon, tag), 'LinearRing')
        _text(linear, 'coordinates', _places((lon, lat, 0.0) for lon, lat in ring))


def _vehicle(document: Element, route: Route, index: int) -> None:
    vehicle = route.vehicle
    folder = _folder(document, vehicle.name)
    _text(
        folder,
        'description',
        f'{len(route.viewpoints)} photographs, {route.length_m:.0f} m, {route.duration_s:.0f} s',
    )
    for name, stand in (('home', vehicle.home), ('end', vehicle.end)):
        if stand is not None:
            _stand(_placemark(folder, f'{vehicle.name} {name}', f'vehicle{index}'), stand)
    for number in range(len(route.sorties)):
        which = f'flight {number + 1}' if len(route.sorties) > 1 else 'route'
        mark = _placemark(folder, f'{vehicle.name} {which}', f'vehicle{index}')
        _text(mark, 'description', flight_summary(route, number).text)
        _geometry(mark, 'LineString', _line(route, number))
    if not route.sorties:
        return
    shots = _folder(folder, 'Viewpoints')
    for viewpoint in route.viewpoints:
        place = (viewpoint.position.longitude_deg, viewpoint.position.latitude_deg)
        mark = _placemark(shots, str(viewpoint.id), f'vehicle{index}')
        _geometry(mark, 'Point', [(*place, viewpoint.height_agl_m)])


def _stand(mark: Element, place: GeoPosition) -> None:
    """Mark a place on the ground where a vehicle takes off or lands."""
    icon_style = SubElement(SubElement(mark, 'Style'), 'IconStyle')
    _text(SubElement(icon_style, 'Icon'), 'href', _HOME)
    _geometry(mark, 'Point', [(place.longitude_deg, place.latitude_deg, 0.0)])


def _line(route: Route, number: int) -> list[tuple[float, float, float]]:
    """Return the places of a flight, from the ground at home to the ground where it lands."""
    height = route.flight_height_m
    places = [
        (stop.position.longitude_deg, stop.position.latitude_deg)
        for stop in flight_path(route, number)
    ]
    start = [] if begins_aloft(route, number) else [(*places[0], 0.0)]
    return [*start, *((*place, height) for place in places), (*places[-1], 0.0)]


def _folder(parent: Element, name: str) -> Element:
    folder = SubElement(parent, 'Folder')
    _text(folder, 'name', name)
    return folder


def _placemark(parent: Element, name: str, style: str) -> Element:
    placemark = SubElement(parent, 'Placemark')
    _text(placemark, 'name', name)
    _text(placemark, 'styleUrl', f'#{style}')
    return placemark


def _geometry(parent: Element, tag: str, places: Sequence[tuple[float, float, float]]) -> None:
    geometry = SubElement(parent, tag)
    _text(geometry, 'altitudeMode', 'relativeToGround')
    _text(geometry, 'coordinates', _places(places))


def _places(places: Iterable[tuple[float, float, float]]) -> str:
    return ' '.join(f'{lon:.9f},{lat:.9f},{height:g}' for lon, lat, height in places)


def _text(parent: Element, tag: str, text: str) -> None:
    SubElement(parent, tag).text = _printable(text)


def _printable(text: str) -> str:
    """Return `text` without control characters, which XML cannot carry."""
    return ''.join(c for c in text if c >= ' ' or c in '\t\n')
