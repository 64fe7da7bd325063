# SPDX-License-Identifier: Apache-2.0
"""The files that responders get: sources, cordons, dose map."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rocsafe_geo.frame import LocalFrame
from rocsafe_radiation.cordon import DEFAULT_LEVELS_USVH, cordon_geojson, cordon_kml, cordons
from rocsafe_radiation.dose_map import dose_map
from rocsafe_radiation.dose_map_file import write_dose_map
from rocsafe_radiation.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.kernel import Kernel
from rocsafe_radiation.localization import Localization
from rocsafe_radiation.source_document import source_document, source_geojson
from rocsafe_radiation.survey import Survey


def write_products(
    folder: Path,
    found: Localization,
    survey: Survey,
    kernel: Kernel,
    frame: LocalFrame | None,
    levels_usvh: Sequence[float] = DEFAULT_LEVELS_USVH,
) -> None:
    """Write all products to `folder`, which is made if need be.

    Without `frame`, which places them on the earth, that is ``sources.json`` alone.

    Raises
    ------
    OSError, DoseMapFileError: if a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_json(folder / 'sources.json', source_document(found, frame))
    if frame is None:
        return
    _write_json(folder / 'sources.geojson', source_geojson(found, frame))
    dose = dose_map(found, survey, kernel, min(levels_usvh))
    write_dose_map(folder / 'dose_map.tif', dose, frame)
    areas = cordons(dose, levels_usvh)
    model = AIR_MODEL if kernel.is_lossy else PAPER_MODEL
    _write_json(folder / 'cordons.geojson', cordon_geojson(areas, frame, model))
    (folder / 'cordons.kml').write_text(cordon_kml(areas, frame), encoding='utf-8')


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')
