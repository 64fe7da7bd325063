# SPDX-License-Identifier: Apache-2.0
"""Writing of the plan's files; each is replaced as a whole."""

import json
from pathlib import Path

from rocsafe_geo.storage.durable import write_whole
from rocsafe_planner.export.flight_files import flight_dji, flight_waypoints, plan_gpx
from rocsafe_planner.export.plan_drawing import plan_drawing
from rocsafe_planner.export.plan_geojson import plan_geojson
from rocsafe_planner.export.plan_kml import plan_kml
from rocsafe_planner.export.plan_picture import drawing_png, drawing_svg
from rocsafe_planner.export.plan_qgroundcontrol import flight_qgroundcontrol
from rocsafe_planner.plan.document import Document
from rocsafe_planner.plan.flight_summary import flight_stem, flight_table
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.plan_json import plan_document

_FLIGHT_SUFFIXES = ('.plan', '.waypoints', '.kmz')


def write_plan(plan: SurveyPlan, directory: str | Path) -> list[Path]:
    """Write the plan for maps, the vehicles' flights for autopilots and, last, `plan.json`.

    For maps: `plan.kml`, `plan.geojson`, `plan.gpx`; pictures: `plan.svg`, `plan.png`; when each
    flight begins: `plan.csv`. Flights: `plan-<vehicle>.plan` for QGroundControl, `.waypoints` for
    MAVLink, `.kmz` for DJI, with `-2` and so on before the extension after a battery swap. The
    folder is made if it does not exist. A vehicle without viewpoints gets a QGroundControl plan
    without items, and files of former flights are removed, so that none is flown by mistake.

    Raises
    ------
    ValueError
        If the folder cannot be written, with the reason.
    """
    folder = Path(directory)
    drawing = plan_drawing(plan)
    contents = {
        'plan.kml': plan_kml(plan).encode(),
        'plan.geojson': _json(plan_geojson(plan)),
        'plan.gpx': plan_gpx(plan.routes).encode(),
        'plan.csv': flight_table(plan).encode(),
        'plan.svg': drawing_svg(drawing).encode(),
        'plan.png': drawing_png(drawing),
        **_flights(plan),
        'plan.json': _json(plan_document(plan)),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            write_whole(folder / name, content)
        for stale in folder.glob('plan-*'):
            if stale.suffix in _FLIGHT_SUFFIXES and stale.name not in contents:
                stale.unlink()
    except OSError as error:
        raise ValueError(f'cannot write the plan to {folder}: {error.strerror}') from error
    return [folder / name for name in contents]


def _flights(plan: SurveyPlan) -> dict[str, bytes]:
    """Return the content of each flight's files, by name."""
    contents: dict[str, bytes] = {}
    for route in plan.routes:
        for number in range(max(1, len(route.sorties))):
            stem = flight_stem(route, number)
            document = flight_qgroundcontrol(route, number, plan.request.exclusions)
            contents[f'{stem}.plan'] = _json(document)
            if route.sorties:
                contents[f'{stem}.waypoints'] = flight_waypoints(route, number).encode()
                contents[f'{stem}.kmz'] = flight_dji(route, number)
    return contents


def _json(document: Document) -> bytes:
    text = json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False)
    return f'{text}\n'.encode()
