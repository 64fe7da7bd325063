# SPDX-License-Identifier: Apache-2.0
"""Cache of painted ground: painting takes half a minute, reading a moment."""

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_scene.ground.ground_kinds import GroundWork
from rocsafe_scene.ground.ground_map import GroundMap, inner_map, outer_map
from rocsafe_scene.ground.real_ground import draped
from rocsafe_scene.scene.description import SceneDescription
from rocsafe_scene.scene.file_stamp import source_digest, stamp

Painter = Callable[[], GroundMap]


def maps(
    works: Sequence[GroundWork],
    seed: int,
    description: SceneDescription,
    frame: LocalFrame,
    cache: Path | None,
) -> tuple[GroundMap, GroundMap]:
    """Return the inner and the outer ground map, from `cache` where they are kept there.

    Raises
    ------
    SceneError
        One line, if the scene has an orthophoto that cannot be used.
    """
    photo = description.terrain.orthophoto

    def drawn(ground: GroundMap) -> GroundMap:
        return ground if photo is None else draped(ground, photo, frame)

    if cache is None:
        return drawn(inner_map(works, seed)), drawn(outer_map(works, seed))
    entries = [entry.model_dump_json() for entry in description.ground]
    about = [] if photo is None else [stamp(photo), str(frame.origin)]
    content = '\n'.join([source_digest(), str(seed), str(description.yaw_deg), *entries, *about])
    key = sha256(content.encode()).hexdigest()[:24]
    inner = _kept(cache / f'{key}-inner.npz', lambda: drawn(inner_map(works, seed)))
    outer = _kept(cache / f'{key}-outer.npz', lambda: drawn(outer_map(works, seed)))
    return inner, outer


def _kept(path: Path, paint: Painter) -> GroundMap:
    with suppress(OSError, ValueError, KeyError):
        return _read(path)
    ground = paint()
    try:
        _write(path, ground)
        # The colours are then mapped from the file and need no memory of the process.
        return _read(path)
    except (OSError, ValueError, KeyError):
        # With a full or read-only disk the next start takes longer; nothing else is lost.
        with suppress(OSError):
            path.unlink()
    return ground


def _picture_of(path: Path) -> Path:
    return path.with_suffix('.npy')


def _read(path: Path) -> GroundMap:
    with np.load(path, allow_pickle=False) as content:
        west, south, texel = content['place'].tolist()
        classes = content['classes']
    # Mapped, not read: processes share the pages, and unused parts need no memory.
    colours = np.load(_picture_of(path), mmap_mode='r', allow_pickle=False)
    return GroundMap(west, south, texel, colours, classes)


def _write(path: Path, ground: GroundMap) -> None:
    """Write both files atomically: other processes may read and write them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    place = np.array([ground.west_m, ground.south_m, ground.texel_m])
    picture = path.with_name(f'{path.stem}.{os.getpid()}.part.npy')
    np.save(picture, ground.colours)
    picture.replace(_picture_of(path))
    part = path.with_name(f'{path.stem}.{os.getpid()}.part.npz')
    np.savez(part, place=place, classes=ground.classes)
    part.replace(path)


def default_folder() -> Path:
    """Return the cache folder of this user."""
    return Path.home() / '.cache' / 'rocsafe' / 'scenes'
