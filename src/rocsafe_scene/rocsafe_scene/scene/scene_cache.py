# SPDX-License-Identifier: Apache-2.0
"""Built scenes kept between runs: making terrain, meshes and grass takes six times the reading.

The file is the user's own, in the user's own cache. Its name holds a checksum of all that the
scene is made from, the source of its makers included, so an old one is never read.
"""

import os
import pickle
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_scene.scene.description import SceneDescription
from rocsafe_scene.scene.file_stamp import source_digest, stamp

_MOST = 6


def kept(
    parts: Callable[[], Any],
    description: SceneDescription,
    seed: int,
    origin: GeoPosition,
    cache: Path | None,
) -> Any:
    """Return what `parts` makes of a scene, from `cache` where it is kept there."""
    if cache is None:
        return parts()
    path = cache / f'{_key(description, seed, origin)}-scene.pickle'
    try:
        # Written by the function itself, for the same user.
        return pickle.loads(path.read_bytes())  # noqa: S301
    except (OSError, EOFError, AttributeError, ImportError, ValueError, pickle.PickleError):
        made = parts()
    # Others may be writing the same one: each to a part of its own.
    part = path.with_name(f'{path.name}.{os.getpid()}.part')
    try:
        cache.mkdir(parents=True, exist_ok=True)
        part.write_bytes(pickle.dumps(made, pickle.HIGHEST_PROTOCOL))
        part.replace(path)
        _forget_old(cache)
    except OSError:
        # A full or read-only disk costs time at the next start, nothing else.
        with suppress(OSError):
            part.unlink()
    return made


def _forget_old(cache: Path) -> None:
    """Remove the scenes that were made longest ago: each is of a hundred megabytes or more."""
    found = sorted(cache.glob('*-scene.pickle'), key=lambda path: -path.stat().st_mtime_ns)
    for path in found[_MOST:]:
        path.unlink(missing_ok=True)


def _key(description: SceneDescription, seed: int, origin: GeoPosition) -> str:
    content = sha256(source_digest().encode())
    content.update(f'{description.model_dump_json()}\n{seed}\n{origin}'.encode())
    for path in (description.terrain.dem, *(entry.mesh for entry in description.objects)):
        content.update(stamp(path).encode())
    return content.hexdigest()[:24]
