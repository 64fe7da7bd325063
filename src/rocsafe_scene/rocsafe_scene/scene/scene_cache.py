# SPDX-License-Identifier: Apache-2.0
"""Cache of built scenes: building terrain, meshes and grass takes six times as long as reading.

Its files are pickles, written and read by the same user. Their names hold a checksum of everything
that the scene is built from, including source code, so that an old one is never read.
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
        # Written by this function, for the same user.
        return pickle.loads(path.read_bytes())  # noqa: S301
    except (OSError, EOFError, AttributeError, ImportError, ValueError, pickle.PickleError):
        made = parts()
    # Other processes may write the same file: each writes a part file of its own.
    part = path.with_name(f'{path.name}.{os.getpid()}.part')
    try:
        cache.mkdir(parents=True, exist_ok=True)
        part.write_bytes(pickle.dumps(made, pickle.HIGHEST_PROTOCOL))
        part.replace(path)
        _forget_old(cache)
    except OSError:
        # With a full or read-only disk the next start takes longer; nothing else is lost.
        with suppress(OSError):
            part.unlink()
    return made


def _forget_old(cache: Path) -> None:
    """Remove all but the newest scenes: each has a hundred megabytes or more."""
    found = sorted(cache.glob('*-scene.pickle'), key=lambda path: -path.stat().st_mtime_ns)
    for path in found[_MOST:]:
        path.unlink(missing_ok=True)


def _key(description: SceneDescription, seed: int, origin: GeoPosition) -> str:
    content = sha256(source_digest().encode())
    content.update(f'{description.model_dump_json()}\n{seed}\n{origin}'.encode())
    for path in (description.terrain.dem, *(entry.mesh for entry in description.objects)):
        content.update(stamp(path).encode())
    return content.hexdigest()[:24]
