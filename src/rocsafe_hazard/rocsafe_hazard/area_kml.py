# SPDX-License-Identifier: Apache-2.0
"""Areas of a hazard as KML 2.2, and their rings in degrees."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.polygon import orient

from rocsafe_geo.frame import LocalFrame

KML_NAMESPACE = 'http://www.opengis.net/kml/2.2'
DEGREE_DIGITS = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class MarkedArea:
    """An area in metres of a frame, with name, description, colour (aabbggrr) and line width."""

    area: MultiPolygon
    name: str
    description: str
    colour: str
    width: int


def areas_kml(areas: Iterable[MarkedArea], frame: LocalFrame, note: str = '') -> str:
    """Return areas as KML 2.2, clamped to the ground; empty ones are left out.

    `note` describes all of them together.
    """
    ElementTree.register_namespace('', KML_NAMESPACE)
    root = ElementTree.Element(f'{{{KML_NAMESPACE}}}kml')
    document = _child(root, 'Document')
    if note:
        _child(document, 'description', note)
    for marked in areas:
        if marked.area.is_empty:
            continue
        placemark = _child(document, 'Placemark')
        _child(placemark, 'name', marked.name)
        _child(placemark, 'description', marked.description)
        style = _child(placemark, 'Style')
        line = _child(style, 'LineStyle')
        _child(line, 'color', marked.colour)
        _child(line, 'width', f'{marked.width}')
        _child(_child(style, 'PolyStyle'), 'fill', '0')
        shapes = _child(placemark, 'MultiGeometry')
        for part in marked.area.geoms:
            _add_polygon(shapes, rings_deg(part, frame))
    return ElementTree.tostring(root, encoding='unicode', xml_declaration=True) + '\n'


def rings_deg(part: Polygon, frame: LocalFrame) -> list[list[list[float]]]:
    """Return closed rings of longitude and latitude (RFC 7946), the outer one anticlockwise."""
    turned = orient(part)
    return [
        _degrees(np.array(ring.coords), frame) for ring in (turned.exterior, *turned.interiors)
    ]


def _add_polygon(parent: ElementTree.Element, rings: list[list[list[float]]]) -> None:
    polygon = _child(parent, 'Polygon')
    for index, ring in enumerate(rings):
        boundary = _child(polygon, 'innerBoundaryIs' if index else 'outerBoundaryIs')
        text = ' '.join(f'{longitude},{latitude}' for longitude, latitude in ring)
        _child(_child(boundary, 'LinearRing'), 'coordinates', text)


def _child(parent: ElementTree.Element, name: str, text: str = '') -> ElementTree.Element:
    element = ElementTree.SubElement(parent, f'{{{KML_NAMESPACE}}}{name}')
    element.text = text or None
    return element


def _degrees(ring: np.ndarray[Any, np.dtype[np.float64]], frame: LocalFrame) -> list[list[float]]:
    places = frame.to_geodetic(np.column_stack([ring[:, :2], np.zeros(len(ring))]))
    return np.round(places[:, [1, 0]], DEGREE_DIGITS).tolist()
