# SPDX-License-Identifier: Apache-2.0
"""Cordons of a run, as the localizer wrote them to ``cordons.geojson``."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_view.map_marks import Cordon
from rocsafe_view.svg import Point

CORDONS = 'cordons.geojson'
# Cordons on the map of the photographs: those that are on the safe side.
SAFE = 'upper_95'


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatedCordon:
    """A cordon with how surely it holds.

    Attributes
    ----------
    edge
        Its level and its edge in map coordinates.
    confidence
        ``mean`` or ``upper_95``.
    stay_h
        Hours at its edge until a dose is reached, by name of the dose.
    """

    edge: Cordon
    confidence: str
    area_m2: float
    stay_h: Mapping[str, float]


def read_cordons(folder: Path, frame: LocalFrame) -> tuple[EstimatedCordon, ...]:
    """Return the cordons of the run in `folder`, the lowest level first; none if unreadable."""
    try:
        content = json.loads((folder / CORDONS).read_text(encoding='utf-8'))
        found = [_cordon(feature, frame) for feature in content['features']]
    except (OSError, ValueError, KeyError, TypeError):
        return ()
    return tuple(sorted(found, key=lambda cordon: cordon.edge.level_usvh))


def safe_cordons(folder: Path, frame: LocalFrame) -> tuple[Cordon, ...]:
    """Return the edges of the cordons that are on the safe side, the lowest level first."""
    return tuple(c.edge for c in read_cordons(folder, frame) if c.confidence == SAFE)


def _cordon(feature: dict[str, Any], frame: LocalFrame) -> EstimatedCordon:
    facts, parts = feature['properties'], feature['geometry']['coordinates']
    return EstimatedCordon(
        edge=Cordon(
            level_usvh=float(facts['level_usv_h']),
            name=str(facts.get('name', '')),
            parts=tuple(tuple(ring_points(ring, frame) for ring in part) for part in parts),
        ),
        confidence=facts['confidence'],
        area_m2=float(facts['area_m2']),
        stay_h=dict(facts['stay_time_h']),
    )


def ring_points(ring: list[list[float]], frame: LocalFrame) -> tuple[Point, ...]:
    """Return a ring of GeoJSON in map coordinates."""
    longitudes, latitudes = np.array(ring).T
    enu = frame.to_enu(latitudes, longitudes, np.full(len(ring), frame.origin.altitude_m))
    return tuple((x, -y) for x, y in enu[:, :2].tolist())
