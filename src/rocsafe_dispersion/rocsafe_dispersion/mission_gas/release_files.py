# SPDX-License-Identifier: Apache-2.0
"""The files that responders get: releases, threat zones, map of the plume, figure over time."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_dispersion.mission_gas.gas_figure import gas_figure
from rocsafe_dispersion.mission_gas.release_assessment import ReleaseAssessment
from rocsafe_dispersion.mission_gas.release_map import PlumeMap
from rocsafe_dispersion.zones.threat_zones import ThreatZone, zones_geojson
from rocsafe_geo.frame import LocalFrame
from rocsafe_hazard.area_kml import MarkedArea, areas_kml
from rocsafe_hazard.grid_file import Band, write_grid

# Lines of the levels 1 to 3 in KML, alpha, blue, green, red.
KML_COLOURS = ('ff00d8ff', 'ff0080ff', 'ff0000d8')
KINDS = {'expected': 2, 'outer bound 95 %': 1}


def write_release_files(
    folder: Path, document: Mapping[str, Any], assessment: ReleaseAssessment, frame: LocalFrame
) -> None:
    """Write all files to `folder`, which is created if it does not exist.

    ``release.json`` and ``gas.svg`` always; with a release also ``threat_zones.geojson``,
    ``threat_zones.kml`` and ``plume.tif``; without one, those of an earlier estimate are removed.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_json(folder / 'release.json', document)
    (folder / 'gas.svg').write_text(gas_figure(assessment), encoding='utf-8')
    write_plume_files(folder, assessment, frame)


def write_plume_files(folder: Path, assessment: ReleaseAssessment, frame: LocalFrame) -> None:
    """Write threat zones and plume to `folder`, which is created; without a release remove them.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    of_plume = [folder / f'threat_zones.{kind}' for kind in ('geojson', 'kml')]
    if assessment.plume is None:
        for path in (*of_plume, folder / 'plume.tif'):
            path.unlink(missing_ok=True)
        return
    agent = assessment.flight.agent
    facts = {
        'agent': agent.name,
        'verdict': assessment.verdict.reason,
        # n of the toxic load C^n t; null: not known.
        'load_exponent': agent.load_exponent,
    }
    _write_json(of_plume[0], zones_geojson(assessment.zones, frame, facts))
    areas = [_marked(zone, kind, agent.name) for zone in assessment.zones for kind in KINDS]
    of_plume[1].write_text(areas_kml(areas, frame), encoding='utf-8')
    _write_plume(folder / 'plume.tif', assessment.plume, assessment, frame)


def _marked(zone: ThreatZone, kind: str, agent: str) -> MarkedArea:
    text = f'{agent}: {zone.level.label}, {zone.level.ppm:g} ppm, {kind}'
    return MarkedArea(
        area=zone.expected if kind == 'expected' else zone.outer,
        name=f'{zone.level.label}, {kind}',
        description=text + (', cut by the edge of the map' if zone.is_cut else ''),
        colour=KML_COLOURS[int(zone.level.name[-1]) - 1],
        width=KINDS[kind],
    )


def _write_plume(
    path: Path, plume: PlumeMap, assessment: ReleaseAssessment, frame: LocalFrame
) -> None:
    counted = assessment.found.amount
    shown, unit = counted.shown(assessment.flight.agent), counted.shown_unit
    arrival = np.where(np.isfinite(plume.arrival_s), plume.arrival_s, np.nan)
    bands = (
        Band(
            meaning=f'mean: concentration 1.5 m above ground, {unit}',
            values=plume.mean_g_m3 * shown,
        ),
        Band(
            meaning=f'upper_95: not exceeded with a probability of 0.95, {unit}',
            values=plume.upper_g_m3 * shown,
        ),
        Band(meaning='arrival: after the release with the mean wind, s', values=arrival),
    )
    grid = plume.grid
    write_grid(path, bands, (grid.west_m, grid.south_m), grid.cell_m, frame)


def _write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')
