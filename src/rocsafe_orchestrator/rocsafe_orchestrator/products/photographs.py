# SPDX-License-Identifier: Apache-2.0
"""Reader of the image store of a run, as far as the report needs it."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.products.run_record import Aim, Photograph

MANIFEST = 'manifest.jsonl'


def read_photographs(directory: Path) -> tuple[Photograph, ...]:
    """Return the photographs that the manifest of an image store lists, by time, each once.

    Lines or records that cannot be read are left out: the store's own node says so in its log.
    """
    photographs: dict[str, Photograph] = {}
    for name in _listed(directory / MANIFEST):
        photograph = _photograph(directory / f'{name}.json')
        if photograph is not None:
            photographs[name] = photograph
    return tuple(sorted(photographs.values(), key=lambda shot: (shot.time_ns, shot.shot_id)))


def _listed(manifest: Path) -> Iterator[str]:
    if not manifest.is_file():
        return
    for line in manifest.read_text(encoding='utf-8', errors='replace').splitlines():
        try:
            name = json.loads(line)['shot_id']
        except (ValueError, KeyError, TypeError):
            continue
        # The name becomes part of a path, so that only safe names are accepted.
        if isinstance(name, str) and name == Path(name).name:
            yield name


def _photograph(sidecar: Path) -> Photograph | None:
    try:
        record = json.loads(sidecar.read_text(encoding='utf-8'))
        return Photograph(
            shot_id=sidecar.stem,
            vehicle=str(record['vehicle']),
            viewpoint_id=int(record['viewpoint_id']),
            time_ns=int(record['time_ns']),
            position=_position(record),
            path=sidecar.with_suffix('.jpg'),
            aim=_aim(record),
        )
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _aim(record: dict[str, Any]) -> Aim | None:
    try:
        camera = record['camera']
        width_px = int(camera['width_px'])
        return Aim(
            camera=PinholeCamera(
                horizontal_fov_rad=2.0 * math.atan2(width_px / 2.0, float(camera['fx_px'])),
                image_width_px=width_px,
                image_height_px=int(camera['height_px']),
            ),
            height_agl_m=float(record['height_agl_m']),
            orientation_xyzw=tuple(map(float, record['orientation_xyzw'])),
        )
    except (ValueError, KeyError, TypeError):
        return None


def _position(record: dict[str, Any]) -> GeoPosition:
    altitude = record['altitude_m']
    return GeoPosition(
        latitude_deg=float(record['latitude_deg']),
        longitude_deg=float(record['longitude_deg']),
        altitude_m=float('nan') if altitude is None else float(altitude),
    )
