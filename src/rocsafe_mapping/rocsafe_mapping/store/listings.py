# SPDX-License-Identifier: Apache-2.0
"""Lists of the photographs of a store, for programs that open the folder.

``images.csv`` for people, ``geo.txt`` and ``cameras.json`` for OpenDroneMap,
``footprints.geojson`` (RFC 7946) for maps, ``collection.json`` and ``items/`` as a static STAC 1.0
catalogue. All are made from the records, at any time, by anybody; none is needed by ROCSAFE.
"""

import csv
import io
import json
import math
from collections.abc import Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from rocsafe_geo.storage.durable import finish_part, part_of
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_mapping.alignment.model.photo import footprint, ground_frame_of, photo_of_record
from rocsafe_mapping.alignment_options import PriorOptions
from rocsafe_mapping.errors import PlacementError, StoreError
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.photographs.xmp import attitude_rad
from rocsafe_mapping.store.catalogue import SIDECAR_SUFFIX, StoredShot

IMAGES_CSV, GEO_TXT, CAMERAS_JSON = 'images.csv', 'geo.txt', 'cameras.json'
FOOTPRINTS, COLLECTION, ITEMS = 'footprints.geojson', 'collection.json', 'items'
# Function code 0x12 (sha2-256) and length 0x20 before the digest.
SHA256_MULTIHASH = '1220'
STAC_VERSION = '1.0.0'
MAKE, MODEL = 'ROCSAFE', 'ROCSAFE nadir camera'
COLUMNS = (
    'image', 'vehicle', 'time_utc', 'latitude_deg', 'longitude_deg', 'altitude_m',
    'height_agl_m', 'yaw_deg', 'pitch_deg', 'roll_deg', 'horizontal_std_m', 'vertical_std_m',
    'sha256',
)  # fmt: skip


def write_listings(folder: Path, shots: Sequence[StoredShot]) -> None:
    """Write all lists of `shots` into `folder`, each replaced as a whole.

    Raises
    ------
    StoreError
        If one cannot be written.
    """
    files = {
        IMAGES_CSV: images_csv(shots),
        GEO_TXT: geo_txt(shots),
        CAMERAS_JSON: _json(cameras(shots)),
        FOOTPRINTS: _json(footprints(shots)),
        COLLECTION: _json(collection(folder.name, shots)),
        **{f'{ITEMS}/{shot.record.shot_id}.json': _json(item(shot)) for shot in shots},
    }
    try:
        (folder / ITEMS).mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            path = folder / name
            if not path.exists() or path.read_text(encoding='utf-8') != text:
                # Whole or not at all; lost with the power, it is made again.
                part_of(path).write_text(text, encoding='utf-8')
                finish_part(path)
    except OSError as error:
        raise StoreError(f'cannot write lists of {folder}: {error}') from error


def images_csv(shots: Sequence[StoredShot]) -> str:
    """Return one row for each photograph; what is not known is empty."""
    table = io.StringIO()
    rows = csv.writer(table, lineterminator='\n')
    rows.writerow(COLUMNS)
    for shot in shots:
        record = shot.record
        angles = _angles_deg(record)
        horizontal, vertical = _stds(record)
        numbers = (
            record.latitude_deg, record.longitude_deg, record.altitude_m, record.height_agl_m,
            *angles, horizontal, vertical,
        )  # fmt: skip
        rows.writerow([
            shot.path.name, record.vehicle, _time(record), *map(_text, numbers), record.sha256,
        ])  # fmt: skip
    return table.getvalue()


def geo_txt(shots: Sequence[StoredShot]) -> str:
    """Return OpenDroneMap's image geolocation file: CRS, then name x y z yaw pitch roll h v."""
    lines = ['EPSG:4326']
    for shot in shots:
        record = shot.record
        if record.has_position:
            yaw, pitch, roll = (value if math.isfinite(value) else 0.0
                                for value in _angles_deg(record))  # fmt: skip
            horizontal, vertical = _stds(record)
            place = f'{record.longitude_deg:.9f} {record.latitude_deg:.9f} {record.altitude_m:.3f}'
            turn = f'{yaw:.4f} {pitch:.4f} {roll:.4f}'
            known = math.isfinite(horizontal + vertical)
            accuracy = f' {horizontal:.3f} {vertical:.3f}' if known else ''
            lines.append(f'{shot.path.name} {place} {turn}{accuracy}')
    return '\n'.join(lines) + '\n'


def cameras(shots: Sequence[StoredShot]) -> dict[str, Any]:
    """Return OpenDroneMap's cameras by their names; lengths are over the longer side."""
    found = {}
    for shot in shots:
        camera = shot.record.camera
        longer = max(camera.width_px, camera.height_px)
        k1, k2, p1, p2, k3 = (*camera.distortion, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
        name = (
            f'v2 {MAKE.lower()} {MODEL.lower()} {camera.width_px} {camera.height_px} brown '
            f'{camera.fx_px / longer:.4f}'
        )
        found[name] = {
            'projection_type': 'brown',
            'width': camera.width_px,
            'height': camera.height_px,
            'focal_x': camera.fx_px / longer,
            'focal_y': camera.fy_px / longer,
            'c_x': (camera.cx_px + 0.5 - 0.5 * camera.width_px) / longer,
            'c_y': (camera.cy_px + 0.5 - 0.5 * camera.height_px) / longer,
            'k1': k1, 'k2': k2, 'p1': p1, 'p2': p2, 'k3': k3,
        }  # fmt: skip
    return found


def footprints(shots: Sequence[StoredShot]) -> dict[str, Any]:
    """Return the ground that each photograph shows, as its pose on board says."""
    features = []
    for shot in shots:
        ring = _ring(shot.record)
        if ring is not None:
            features.append(
                {
                    'type': 'Feature',
                    'id': shot.record.shot_id,
                    'geometry': {'type': 'Polygon', 'coordinates': [ring]},
                    'properties': {
                        'image': shot.path.name,
                        'vehicle': shot.record.vehicle,
                        'datetime': _time(shot.record),
                    },
                }
            )
    return {'type': 'FeatureCollection', 'features': features}


def item(shot: StoredShot) -> dict[str, Any]:
    """Return the STAC item of a photograph."""
    record, ring = shot.record, _ring(shot.record)
    return {
        'type': 'Feature',
        'stac_version': STAC_VERSION,
        'stac_extensions': [
            'https://stac-extensions.github.io/file/v2.1.0/schema.json',
            'https://stac-extensions.github.io/view/v1.0.0/schema.json',
        ],
        'id': record.shot_id,
        'geometry': None if ring is None else {'type': 'Polygon', 'coordinates': [ring]},
        **({} if ring is None else {'bbox': _box(ring)}),
        'properties': {'datetime': _time(record), 'platform': record.vehicle, 'view:off_nadir': 0},
        'collection': shot.path.parent.name,
        'assets': {
            'image': {
                'href': f'../{shot.path.name}',
                'type': 'image/jpeg',
                'roles': ['data'],
                **_file_facts(shot),
            },
            'record': {
                'href': f'../{shot.path.with_suffix(SIDECAR_SUFFIX).name}',
                'type': 'application/json',
                'roles': ['metadata'],
            },
        },
        'links': [
            {'rel': 'collection', 'href': f'../{COLLECTION}', 'type': 'application/json'},
            {'rel': 'root', 'href': f'../{COLLECTION}', 'type': 'application/json'},
        ],
    }


def _file_facts(shot: StoredShot) -> dict[str, Any]:
    """Return size and checksum as the file extension of STAC wants them: a multihash."""
    if not shot.sha256:
        return {}
    return {'file:size': shot.size_bytes, 'file:checksum': SHA256_MULTIHASH + shot.sha256}


def collection(name: str, shots: Sequence[StoredShot]) -> dict[str, Any]:
    """Return the STAC collection of a store."""
    rings = [ring for ring in (_ring(shot.record) for shot in shots) if ring is not None]
    points = [point for ring in rings for point in ring]
    times = sorted(_time(shot.record) for shot in shots)
    return {
        'type': 'Collection',
        'stac_version': STAC_VERSION,
        'id': name,
        'description': 'Photographs of a survey by ROCSAFE',
        'license': 'proprietary',
        'extent': {
            'spatial': {'bbox': [_box(points) if points else [-180.0, -90.0, 180.0, 90.0]]},
            'temporal': {'interval': [[times[0], times[-1]] if times else [None, None]]},
        },
        'links': [
            {'rel': 'item', 'href': f'./{ITEMS}/{shot.record.shot_id}.json', 'type':
             'application/geo+json'}
            for shot in shots
        ],
    }  # fmt: skip


def _ring(record: ShotRecord) -> list[list[float]] | None:
    """Return the footprint as a closed ring, anticlockwise, None where it is not known."""
    if math.isnan(record.height_agl_m):
        return None
    try:
        frame = ground_frame_of(record)
        photo = photo_of_record(record, frame, PriorOptions(), record.shot_id)
    except PlacementError:
        return None
    corners = frame.geodetic(footprint(photo, photo.prior))
    # Top left, top right, bottom right, bottom left run clockwise as seen from above.
    ring = [[round(lon, 9), round(lat, 9)] for lat, lon in corners[::-1].tolist()]
    return [*ring, ring[0]]


def _box(points: Sequence[Sequence[float]]) -> list[float]:
    easts, norths = [point[0] for point in points], [point[1] for point in points]
    return [min(easts), min(norths), max(easts), max(norths)]


def _angles_deg(record: ShotRecord) -> tuple[float, float, float]:
    """Return yaw clockwise from north, pitch (0 straight down) and roll; NaN if not known."""
    attitude = attitude_rad(record)
    if attitude is None:
        return math.nan, math.nan, math.nan
    yaw, pitch, roll = (math.degrees(angle) for angle in attitude)
    return (90.0 - yaw) % 360.0, -pitch, roll


def _stds(record: ShotRecord) -> tuple[float, float]:
    covariance = record.position_covariance_m2
    horizontal, vertical = 0.5 * (covariance[0] + covariance[4]), covariance[8]
    return tuple(  # type: ignore[return-value]
        math.sqrt(value) if 0.0 < value < math.inf else math.nan
        for value in (horizontal, vertical)
    )


def _time(record: ShotRecord) -> str:
    seconds, rest = divmod(record.time_ns, NS_PER_S)
    taken = datetime.fromtimestamp(seconds, tz=timezone.utc)
    return f'{taken:%Y-%m-%dT%H:%M:%S}.{rest // 1_000_000:03d}Z'


def _text(value: float) -> str:
    return (
        f'{value:.9g}'
        if abs(value) < 1.0
        else f'{value:.9f}'.rstrip('0').rstrip('.')
        if (math.isfinite(value))
        else ''
    )


def _json(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=1, allow_nan=False) + '\n'
