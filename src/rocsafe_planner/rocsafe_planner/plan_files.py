# SPDX-License-Identifier: Apache-2.0
"""Writing the plan's files, so that a reader never sees half of one."""

import json
import os
import tempfile
from pathlib import Path

from rocsafe_planner.document import Document
from rocsafe_planner.plan import SurveyPlan
from rocsafe_planner.plan_geojson import plan_geojson
from rocsafe_planner.plan_json import plan_document
from rocsafe_planner.plan_kml import plan_kml
from rocsafe_planner.plan_qgroundcontrol import route_qgroundcontrol


def write_plan(plan: SurveyPlan, directory: str | Path) -> list[Path]:
    """Write `plan.kml`, `plan.geojson`, `plan-<vehicle>.plan` and, last, `plan.json`.

    The folder is made if need be. Each file is replaced as a whole. A vehicle without viewpoints
    gets a plan without items, so that none from before is flown by mistake.

    Raises
    ------
    ValueError
        If the folder cannot be written, with the reason.
    """
    folder = Path(directory)
    contents = {
        'plan.kml': plan_kml(plan),
        'plan.geojson': _json(plan_geojson(plan)),
        **{
            f'plan-{route.vehicle.name}.plan': _json(route_qgroundcontrol(route))
            for route in plan.routes
        },
        'plan.json': _json(plan_document(plan)),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            _replace(folder / name, content)
    except OSError as error:
        raise ValueError(f'cannot write the plan to {folder}: {error.strerror}') from error
    return [folder / name for name in contents]


def _json(document: Document) -> str:
    return json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False) + '\n'


def _replace(path: Path, content: str) -> None:
    """Write beside, flush to the disk, rename over."""
    descriptor, temporary = tempfile.mkstemp(prefix=f'.{path.name}.', dir=path.parent)
    try:
        with os.fdopen(descriptor, 'w', encoding='utf-8') as stream:
            # mkstemp makes a private file; the plan is for everyone who may read the folder.
            os.fchmod(stream.fileno(), 0o644)
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
