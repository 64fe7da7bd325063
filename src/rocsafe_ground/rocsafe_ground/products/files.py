# SPDX-License-Identifier: Apache-2.0
"""All files of a drive."""

import json
from pathlib import Path

from rocsafe_ground.drive.drive_plan import DrivePlan
from rocsafe_ground.drive.ground_map import GroundMap
from rocsafe_ground.products.document import drive_document, drive_geojson
from rocsafe_ground.products.exports import drive_gpx, drive_kml, drive_qgroundcontrol
from rocsafe_ground.products.ground_file import write_ground

ROUTE_FILE = 'route.json'


def write_drive(folder: Path, plan: DrivePlan, ground: GroundMap) -> None:
    """Write the files of a drive to `folder`, which is created if it does not exist.

    Raises
    ------
    OSError, GroundError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    documents = {
        ROUTE_FILE: drive_document(plan),
        'route.geojson': drive_geojson(plan),
        'route.plan': drive_qgroundcontrol(plan),
    }
    for name, document in documents.items():
        (folder / name).write_text(json.dumps(document, indent=1) + '\n', encoding='utf-8')
    (folder / 'route.kml').write_text(drive_kml(plan), encoding='utf-8')
    (folder / 'route.gpx').write_text(drive_gpx(plan), encoding='utf-8')
    write_ground(folder / 'ground.tif', ground)
