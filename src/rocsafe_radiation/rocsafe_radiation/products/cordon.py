# SPDX-License-Identifier: Apache-2.0
"""Cordons: the ground on which the dose rate exceeds a level, and how long one may stay."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from shapely.geometry import MultiPolygon

from rocsafe_geo.frame import LocalFrame
from rocsafe_hazard.area_kml import MarkedArea, areas_kml, rings_deg
from rocsafe_hazard.contours import area_above
from rocsafe_radiation.products.dose_map import DoseMap

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
    east_m, north_m = (
        np.asarray(first + found.cell_m * np.arange(count), float)
        for first, count in zip(found.corner_m, found.mean_usvh.shape[::-1], strict=True)
    )
    return [
        Cordon(
            level_usvh=level,
            confidence=name,
            area=area_above(east_m, north_m, values, level),
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
                'coordinates': [rings_deg(part, frame) for part in cordon.area.geoms],
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
    levels = sorted({cordon.level_usvh for cordon in found})
    areas = (
        MarkedArea(
            area=cordon.area,
            name=f'{cordon.level_usvh:g} µSv/h, {CONFIDENCE_MEANINGS[cordon.confidence]}',
            description='; '.join([cordon.description(), *doubts]),
            colour=KML_COLOURS[levels.index(cordon.level_usvh) % len(KML_COLOURS)],
            width=2 if cordon.confidence == MEAN else 1,
        )
        for cordon in found
    )
    return areas_kml(areas, frame, '; '.join(doubts))
