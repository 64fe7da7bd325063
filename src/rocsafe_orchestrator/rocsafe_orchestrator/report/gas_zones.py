# SPDX-License-Identifier: Apache-2.0
"""Threat zones and releases of gas of a run on the map of the photographs."""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rocsafe_geo.frame import LocalFrame
from rocsafe_orchestrator.products.release_estimates import ReleaseEstimates
from rocsafe_orchestrator.report.sections.cordons import ring_points
from rocsafe_scenario.scenario import Scenario
from rocsafe_view.map_marks import GasZone, ReleasePoint, SourcePoint
from rocsafe_view.svg import Rings

ZONES = 'threat_zones.geojson'
_EXPECTED, _OUTER = 'expected', 'outer bound 95 %'


def read_zones(
    folder: Path, frame: LocalFrame, releases: Sequence[ReleasePoint]
) -> tuple[GasZone, ...]:
    """Return the threat zones of the run in `folder`, the least level first; none if unreadable.

    A zone whose outer bound is empty is left out; without `releases` there is none.
    """
    try:
        content = json.loads((folder / ZONES).read_text(encoding='utf-8'))
        areas: dict[str, dict[str, Mapping[str, Any]]] = {}
        for feature in content['features']:
            facts = feature['properties']
            areas.setdefault(facts['level'], {})[facts['kind']] = feature
        found = [_zone(kinds, frame, releases) for kinds in areas.values() if releases]
    except (OSError, ValueError, KeyError, TypeError):
        return ()
    present = (zone for zone in found if zone is not None)
    return tuple(sorted(present, key=lambda zone: zone.number))


def _zone(
    kinds: Mapping[str, Mapping[str, Any]], frame: LocalFrame, releases: Sequence[ReleasePoint]
) -> GasZone | None:
    facts = kinds[_OUTER]['properties']
    outer = _rings(kinds[_OUTER], frame)
    if not outer:
        return None
    reach_m, reach_deg = _reach(outer, releases)
    return GasZone(
        level=facts['level'],
        number=int(facts['level'][-1]),
        agent=facts['agent'],
        ppm=float(facts['ppm']),
        minutes=float(facts['averaging_minutes']),
        expected=_rings(kinds[_EXPECTED], frame),
        outer=outer,
        is_cut=bool(facts['is_cut_by_the_map']),
        reach_m=reach_m,
        reach_deg=reach_deg,
    )


def _reach(outer: Rings, releases: Sequence[ReleasePoint]) -> tuple[float, float]:
    """Return distance and direction of the furthest point from the release nearest to it."""
    nearest = (
        min(((x - one.x, y - one.y) for one in releases), key=lambda offset: math.hypot(*offset))
        for ring in outer
        for x, y in ring
    )
    x, y = max(nearest, key=lambda offset: math.hypot(*offset))
    return math.hypot(x, y), math.degrees(math.atan2(x, -y)) % 360.0


def _rings(feature: Mapping[str, Any], frame: LocalFrame) -> Rings:
    parts = feature['geometry']['coordinates']
    return tuple(ring_points(ring, frame) for part in parts for ring in part)


def true_releases(scenario: Scenario | None, frame: LocalFrame) -> tuple[SourcePoint, ...]:
    """Return the releases of a scenario in map coordinates, where they start."""
    found = () if scenario is None else scenario.air.releases
    if not found:
        return ()
    places = ring_points([[one.position[1], one.position[0]] for one in found], frame)
    return tuple(SourcePoint(x, y, one.name) for (x, y), one in zip(places, found, strict=True))


def release_points(
    estimates: ReleaseEstimates | None, frame: LocalFrame
) -> tuple[ReleasePoint, ...]:
    """Return the estimated releases in map coordinates."""
    if estimates is None or not estimates.releases:
        return ()
    found = estimates.releases
    places = ring_points([[one.longitude_deg, one.latitude_deg] for one in found], frame)
    return tuple(
        ReleasePoint(x=x, y=y, radius_m=math.sqrt(one.region_95_m2 / math.pi))
        for (x, y), one in zip(places, found, strict=True)
    )
