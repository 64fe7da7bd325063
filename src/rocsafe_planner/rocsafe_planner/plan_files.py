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
from rocsafe_planner.plan_qgroundcontrol import flight_qgroundcontrol


def write_plan(plan: SurveyPlan, directory: str | Path) -> list[Path]:
    """Write `plan.kml`, `plan.geojson`, the vehicles' flights and, last, `plan.json`.

    Flights are `plan-<vehicle>.plan`, with `-2` and so on before the extension after a battery
    swap. The folder is made if need be. Each file is replaced as a whole. A vehicle without
    viewpoints gets a plan without items, and flights from before are removed, so that none is
    flown by mistake.

    Raises
    ------
    ValueError
        If the folder cannot be written, with the reason.
    """
    folder = Path(directory)
    contents = {
        'plan.kml': plan_kml(plan),
        'plan.geojson': _json(plan_geojson(plan)),
        **_flights(plan),
        'plan.json': _json(plan_document(plan)),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            _replace(folder / name, content)
        for stale in folder.glob('plan-*.plan'):
            if stale.name not in contents:
                stale.unlink()
    except OSError as error:
        raise ValueError(f'cannot write the plan to {folder}: {error.strerror}') from error
    return [folder / name for name in contents]


def _flights(plan: SurveyPlan) -> dict[str, str]:
    """Return the content of each flight's file, by name."""
    contents = {}
    for route in plan.routes:
        for number in range(max(1, len(route.sorties))):
            suffix = f'-{number + 1}' if number else ''
            document = flight_qgroundcontrol(route, number, plan.request.exclusions)
            contents[f'plan-{route.vehicle.name}{suffix}.plan'] = _json(document)
    return contents


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
