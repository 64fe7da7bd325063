# SPDX-License-Identifier: Apache-2.0
"""The files that responders get: sources, cordons, dose map."""

import json
from pathlib import Path
from typing import Any

from rocsafe_geo.frame import LocalFrame
from rocsafe_radiation.physics.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.products.assessment import Assessment
from rocsafe_radiation.products.cordon import cordon_geojson, cordon_kml
from rocsafe_radiation.products.dose_map_file import write_dose_map
from rocsafe_radiation.products.source_document import assessment_document, source_geojson


def write_products(folder: Path, assessment: Assessment, frame: LocalFrame | None) -> None:
    """Write all products to `folder`, which is created if it does not exist.

    Without `frame`, places have no latitude and longitude: only ``sources.json`` is written.

    Raises
    ------
    OSError, DoseMapFileError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_json(folder / 'sources.json', assessment_document(assessment, frame))
    if frame is None:
        return
    _write_json(folder / 'sources.geojson', source_geojson(assessment.found, frame))
    doubts = assessment.found.doubts
    write_dose_map(folder / 'dose_map.tif', assessment.dose, frame, doubts)
    model = AIR_MODEL if assessment.options.known.kernel.is_lossy else PAPER_MODEL
    areas = cordon_geojson(assessment.cordons, frame, model, doubts)
    _write_json(folder / 'cordons.geojson', areas)
    areas_kml = cordon_kml(assessment.cordons, frame, doubts)
    (folder / 'cordons.kml').write_text(areas_kml, encoding='utf-8')


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')
