# SPDX-License-Identifier: Apache-2.0
"""Cordons: the ground on which the dose rate exceeds a level, and how long one may stay."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.polygon import orient

from rocsafe_geo.frame import LocalFrame
from rocsafe_radiation.products.dose_map import DoseMap
from rocsafe_radiation.products.isolines import areas_above

# Microsievert per hour at 1 m: the public, German responders, the inner cordon of the IAEA
# (EPR-First Responders), ten times that, turn back (enter only to save lives).
DEFAULT_LEVELS_USVH = (2.5, 25.0, 100.0, 1000.0, 100_000.0)
LEVEL_NAMES = {
    2.5: 'the public',
    25.0: 'responders’ cordon (Germany)',
    100.0: 'inner cordon (IAEA)',
    1e3: 'trained teams alone',
    1e5: 'turn back, but to save lives (IAEA)',
}
# Doses of stay times: yearly limits of the public and of a worker (ICRP 103), microsievert.
STAY_DOSES_USV = {'public_year_1_msv': 1e3, 'worker_year_20_msv': 2e4}
STAY_MEANINGS = {'public_year_1_msv': '1 mSv', 'worker_year_20_msv': '20 mSv'}
MEAN, UPPER = 'mean', 'upper_95'
CONFIDENCE_MEANINGS = {MEAN: 'mean', UPPER: 'upper 95 %'}
DEGREE_DIGITS = 8
KML_NAMESPACE = 'http://www.opengis.net/kml/2.2'
# Blue to yellow, distinct for the colour-blind; KML writes alpha, blue, green, red.
KML_COLOURS = ('ff8e5830', 'ff8c8021', 'ff63c85e', 'ff21e4fd', 'ff4670f0')


@dataclass(frozen=True, slots=True, kw_only=True)
class Cordon:
    """The ground above one level, east and north in metres.

    Attributes
    ----------
    level_usvh
        Microsievert per hour at 1 m.
    confidence
        ``mean``: by the estimate itself, ``upper_95``: by its upper 95 %.
    area
        Area, metres.
    """

    level_usvh: float
    confidence: str
    area: MultiPolygon

    def stay_times_h(self) -> dict[str, float]:
        """Return the times at the cordon's edge until a dose is reached, hours."""
        return {name: dose / self.level_usvh for name, dose in STAY_DOSES_USV.items()}

    def description(self) -> str:
        """Return in words its purpose, its size and stay times at its edge."""
        parts = [LEVEL_NAMES.get(self.level_usvh, ''), f'{self.area.area:.0f} m²']
        stays = self.stay_times_h().items()
        parts += [
            f'{STAY_MEANINGS[name]} after {_stay(hours)} at its edge' for name, hours in stays
        ]
        return '; '.join(part for part in parts if part)


def _stay(hours: float) -> str:
    if hours < 1.0:
        return f'{60.0 * hours:.3g} min'
    return f'{hours:.3g} h' if hours < 72.0 else f'{hours / 24.0:.0f} d'


def cordons(found: DoseMap, levels_usvh: Sequence[float] = DEFAULT_LEVELS_USVH) -> list[Cordon]:
    """Return the cordon of each level, by the mean and by the upper 95 %.

    Raises
    ------
    ValueError
        If a level is not above 0.
    """
    for level in levels_usvh:
        if not 0.0 < level < math.inf:
            raise ValueError(f'level_usvh = {level} must be above 0 and finite')
    return [
        Cordon(
            level_usvh=level,
            confidence=name,
            area=areas_above(values, level, found.corner_m, found.cell_m),
        )
        for level in sorted(levels_usvh)
        for name, values in ((MEAN, found.mean_usvh), (UPPER, found.upper_usvh))
    ]


def cordon_geojson(
    found: Sequence[Cordon], frame: LocalFrame, model: str, doubts: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the cordons in WGS84 (RFC 7946): closed rings, outer ones anticlockwise."""
    features = [
        {
            'type': 'Feature',
            'geometry': {
                'type': 'MultiPolygon',
                'coordinates': [_rings(part, frame) for part in cordon.area.geoms],
            },
            'properties': {
                'kind': 'cordon',
                'level_usv_h': cordon.level_usvh,
                'name': LEVEL_NAMES.get(cordon.level_usvh, ''),
                'confidence': cordon.confidence,
                'model': model,
                'area_m2': round(cordon.area.area, 2),
                'stay_time_h': cordon.stay_times_h(),
                'doubts': list(doubts),
            },
        }
        for cordon in found
        if not cordon.area.is_empty
    ]
    return {'type': 'FeatureCollection', 'features': features, 'doubts': list(doubts)}


def cordon_kml(found: Sequence[Cordon], frame: LocalFrame, doubts: Sequence[str] = ()) -> str:
    """Return the cordons as KML 2.2, clamped to the ground; `doubts` stand in each description."""
    ElementTree.register_namespace('', KML_NAMESPACE)
    root = ElementTree.Element(f'{{{KML_NAMESPACE}}}kml')
    document = _child(root, 'Document')
    if doubts:
        _child(document, 'description', '; '.join(doubts))
    levels = sorted({cordon.level_usvh for cordon in found})
    for cordon in found:
        if cordon.area.is_empty:
            continue
        placemark = _child(document, 'Placemark')
        confidence = CONFIDENCE_MEANINGS[cordon.confidence]
        _child(placemark, 'name', f'{cordon.level_usvh:g} µSv/h, {confidence}')
        description = '; '.join([cordon.description(), *doubts])
        _child(placemark, 'description', description)
        style = _child(placemark, 'Style')
        line = _child(style, 'LineStyle')
        _child(line, 'color', KML_COLOURS[levels.index(cordon.level_usvh) % len(KML_COLOURS)])
        _child(line, 'width', '2' if cordon.confidence == MEAN else '1')
        _child(_child(style, 'PolyStyle'), 'fill', '0')
        shapes = _child(placemark, 'MultiGeometry')
        for part in cordon.area.geoms:
            _add_polygon(shapes, _rings(part, frame))
    return ElementTree.tostring(root, encoding='unicode', xml_declaration=True) + '\n'


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


def _rings(part: Polygon, frame: LocalFrame) -> list[list[list[float]]]:
    turned = orient(part)
    return [
        _degrees(np.array(ring.coords), frame) for ring in (turned.exterior, *turned.interiors)
    ]


def _degrees(ring: np.ndarray[Any, np.dtype[np.float64]], frame: LocalFrame) -> list[list[float]]:
    places = frame.to_geodetic(np.column_stack([ring[:, :2], np.zeros(len(ring))]))
    return np.round(places[:, [1, 0]], DEGREE_DIGITS).tolist()
