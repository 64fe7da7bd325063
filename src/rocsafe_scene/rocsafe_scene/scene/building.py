# SPDX-License-Identifier: Apache-2.0
"""A scene built from its description."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.errors import SceneError
from rocsafe_scene.ground.ground_kinds import GROUND_KINDS, GroundWork, yaw_of
from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.ground.real_ground import measured_heights, open_photo
from rocsafe_scene.ground.relief import Pad, Relief
from rocsafe_scene.ground.terrain import INNER_HALF_M, Terrain, make_terrain
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.mesh.mesh import Floats, Mesh
from rocsafe_scene.painting.noise import Window, fractal_at
from rocsafe_scene.parts.plants import tufts
from rocsafe_scene.scene import map_cache, scene_cache
from rocsafe_scene.scene.catalogue import maker_of
from rocsafe_scene.scene.description import GroundBlock, SceneDescription
from rocsafe_scene.scene.environment import Environment, SceneObject
from rocsafe_scene.scene.placing import Placer, to_world

_TUFTS_PER_M2 = 1.6
_PATCHES = {6: 0.5, 7: 0.8, 8: 1.0, 9: 0.8}
# Density of long grass by class of ground; short grass is only painted.
_LONG_GRASS = {'grass': 1.0, 'meadow': 0.16, 'water': 0.05, 'soil': 0.02}
_CHUNK_M = 20.48
_Shapes = tuple[Terrain, tuple[SceneObject, ...], tuple[Mesh, ...]]


def build(
    description: SceneDescription,
    seed: int | None = None,
    origin: GeoPosition | None = None,
    cache: Path | None = None,
) -> Environment:
    """Return a scene built from its description.

    Parameters
    ----------
    description
        Content of the scene.
    seed
        Seed instead of that of the description.
    origin
        Mission origin instead of the place in the description.
    cache
        Folder that keeps painted ground and built scenes between runs; None: no cache.

    Raises
    ------
    SceneError
        One line, if an entry cannot be made.
    """
    seed = description.seed if seed is None else seed
    origin = origin or _origin(description)
    frame = LocalFrame(origin)
    works = ground_works(description, seed)
    inner, outer = map_cache.maps(works, seed, description, frame, cache)

    def shapes() -> _Shapes:
        terrain = make_terrain(_relief(description, seed, works, frame).heights)
        objects = tuple(Placer(description, seed, frame, terrain).objects())
        return terrain, objects, tuple(_tufts(description.terrain.tufts, seed, terrain, inner))

    terrain, objects, grass = scene_cache.kept(shapes, description, seed, origin, cache)
    return Environment(
        description=description,
        seed=seed,
        terrain=terrain,
        inner=inner,
        outer=outer,
        objects=objects,
        tufts=grass,
    )


def check(
    description: SceneDescription, seed: int | None = None, origin: GeoPosition | None = None
) -> tuple[SceneObject, ...]:
    """Build everything but the ground maps, and return the objects; for the rest see `build`."""
    seed = description.seed if seed is None else seed
    origin = origin or _origin(description)
    if description.terrain.orthophoto is not None:
        open_photo(description.terrain.orthophoto, LocalFrame(origin))
    terrain = terrain_of(description, seed, origin)
    return tuple(Placer(description, seed, LocalFrame(origin), terrain).objects())


def terrain_of(description: SceneDescription, seed: int, origin: GeoPosition) -> Terrain:
    """Return only the terrain of a scene.

    Raises
    ------
    SceneError
        One line, if an entry cannot be made.
    """
    works = ground_works(description, seed)
    return make_terrain(_relief(description, seed, works, LocalFrame(origin)).heights)


def ground_works(description: SceneDescription, seed: int) -> tuple[GroundWork, ...]:
    """Return marks, classes and earthworks of the entries of the ground, in their order.

    Raises
    ------
    SceneError
        One line, naming the entry.
    """
    works = []
    for entry in description.ground:
        try:
            works.append(_work(description, entry, seed))
        except (ValueError, TypeError) as error:
            raise SceneError(f'ground: {entry.name}: {error}') from error
    return tuple(works)


def _work(description: SceneDescription, entry: GroundBlock, seed: int) -> GroundWork:
    if entry.kind not in GROUND_KINDS:
        raise ValueError(f'kind is {entry.kind!r}: must be one of {", ".join(GROUND_KINDS)}')
    make, shape = GROUND_KINDS[entry.kind]
    points = entry.outline if shape == 'outline' else entry.line
    if points is None:
        raise ValueError(f'{entry.kind} must say {shape}')
    options: dict[str, Any] = dict(yaw_of(dict(entry.options)))
    if 'yaw_rad' in options:
        options['yaw_rad'] += np.radians(description.yaw_deg)
    return make(to_world(description, list(points)), seed + len(entry.name), **options)


def _origin(description: SceneDescription) -> GeoPosition:
    place = description.place
    return GeoPosition(place.latitude_deg, place.longitude_deg, place.altitude_m)


def _relief(
    description: SceneDescription, seed: int, works: Sequence[GroundWork], frame: LocalFrame
) -> Relief:
    dem = description.terrain.dem
    return Relief(
        seed=seed,
        local_m=description.terrain.local_m,
        hills_m=description.terrain.hills_m,
        courses=[course for work in works for course in work.courses],
        pads=_pads(description),
        measured=None if dem is None else measured_heights(dem, frame),
    )


def _pads(description: SceneDescription) -> list[Pad]:
    """Return level places under buildings."""
    pads = []
    for entry in description.objects:
        is_building = entry.make is not None and maker_label(entry.make) in ('house', 'tent')
        if is_building and entry.at is not None:
            east, north = to_world(description, [entry.at])[0].tolist()
            pads.append(Pad(east_m=east, north_m=north, radius_m=9.0))
    return pads


def maker_label(name: str) -> str:
    """Return the class of the objects that the maker `name` makes; empty if there is none."""
    try:
        return maker_of(name).label
    except ValueError:
        return ''


def _tufts(density: float, seed: int, terrain: Terrain, ground: GroundMap) -> list[Mesh]:
    """Return long grass in patches, a mesh for each chunk of ground."""
    rng = np.random.default_rng([seed, 77])
    area = 4.0 * INNER_HALF_M[0] * INNER_HALF_M[1]
    count = int(area * _TUFTS_PER_M2 * density)
    half = np.array(INNER_HALF_M)
    feet = rng.uniform(-half, half, (count, 2))
    feet = feet[_grows(feet, seed, ground) > rng.uniform(0.0, 1.0, count)]
    placed = np.column_stack([feet, terrain.height_at(feet)])
    chunk = np.floor((feet + half) / _CHUNK_M).astype(int)
    keys = chunk[:, 0] * 1000 + chunk[:, 1]
    return [
        tufts(np.random.default_rng([seed, 78, int(key)]), placed[keys == key]).compact()
        for key in np.unique(keys)
    ]


def _grows(feet: Floats, seed: int, ground: GroundMap) -> Floats:
    """Return the probability of long grass at each of `feet` (n, 2)."""
    classes = ground.classes_at(feet)
    likely = np.zeros(len(feet))
    for label, share in _LONG_GRASS.items():
        likely[classes == class_number(label)] = share
    octave, cell = 6, 0.64
    columns, rows = (round(2.0 * half / cell) for half in INNER_HALF_M)
    x0, y0 = -columns // 2, -rows // 2
    patches = fractal_at(seed + 75, _PATCHES, octave, Window(x0, y0, x0 + columns, y0 + rows))
    column = np.clip((feet[:, 0] / cell).astype(int) - x0, 0, columns - 1)
    row = np.clip((feet[:, 1] / cell).astype(int) - y0, 0, rows - 1)
    return np.asarray(likely * np.clip(0.5 + 0.9 * patches[row, column], 0.03, 1.0))
