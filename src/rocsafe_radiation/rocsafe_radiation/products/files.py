# SPDX-License-Identifier: Apache-2.0
"""The files that responders get: sources, cordons, dose map."""

import json
from pathlib import Path
from typing import Any

from rocsafe_geo.frame import LocalFrame
from rocsafe_radiation.physics.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.products.assessment import Picture
from rocsafe_radiation.products.cordon import cordon_geojson, cordon_kml
from rocsafe_radiation.products.dose_map_file import write_dose_map
from rocsafe_radiation.products.source_document import picture_document, source_geojson


def write_products(folder: Path, picture: Picture, frame: LocalFrame | None) -> None:
    """Write all products to `folder`, which is made if need be.

    Without `frame`, which places them on the earth, that is ``sources.json`` alone.

    Raises
    ------
    OSError, DoseMapFileError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_json(folder / 'sources.json', picture_document(picture, frame))
    if frame is None:
        return
    _write_json(folder / 'sources.geojson', source_geojson(picture.found, frame))
    write_dose_map(folder / 'dose_map.tif', picture.dose, frame)
    model = AIR_MODEL if picture.options.known.kernel.is_lossy else PAPER_MODEL
    _write_json(folder / 'cordons.geojson', cordon_geojson(picture.cordons, frame, model))
    (folder / 'cordons.kml').write_text(cordon_kml(picture.cordons, frame), encoding='utf-8')


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')
