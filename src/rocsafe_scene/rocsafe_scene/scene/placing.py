# SPDX-License-Identifier: Apache-2.0
"""Placing of the objects of a scene file on the ground."""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any
from zlib import crc32

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.errors import SceneError
from rocsafe_scene.ground.terrain import Terrain
from rocsafe_scene.mesh.lines import resampled, run_of
from rocsafe_scene.mesh.mesh import Floats, Mesh, rotation_of
from rocsafe_scene.mesh.mesh_file import read_mesh
from rocsafe_scene.scene.catalogue import Maker, maker_of
from rocsafe_scene.scene.description import ObjectBlock, Point, SceneDescription
from rocsafe_scene.scene.environment import FIRST_OBJECT_NUMBER, MovingPath, Piece, SceneObject

# Number of different shapes of objects that are scattered in large numbers.
_VARIANTS = 7
_LINE_STEP_M = 1.5


@dataclass(slots=True)
class Placer:
    """Makes the objects of a scene and numbers them in order.

    Attributes
    ----------
    description
        Description of the scene.
    seed
        Seed of everything random.
    frame
        Local frame of the mission, for places in degrees.
    terrain
        Terrain on which objects stand.
    """

    description: SceneDescription
    seed: int
    frame: LocalFrame
    terrain: Terrain
    _names: set[str] = field(default_factory=set)

    def objects(self) -> Iterator[SceneObject]:
        """Yield all objects.

        Raises
        ------
        SceneError
            If an entry cannot be made; one line.
        """
        number = FIRST_OBJECT_NUMBER
        for entry in self.description.objects:
            try:
                for thing in self._made(entry, number):
                    self._claim(thing.name)
                    yield thing
                    number += 1
            except (ValueError, TypeError) as error:
                raise SceneError(f'objects: {entry.name}: {error}') from error

    def _claim(self, name: str) -> None:
        if name in self._names:
            raise ValueError('the name is taken: names must differ')
        self._names.add(name)

    def _made(self, entry: ObjectBlock, number: int) -> Iterator[SceneObject]:
        if entry.mesh is None and entry.make is None:
            raise ValueError('must say make or mesh')
        maker = maker_of(entry.make or 'debris')
        options = _checked(entry, maker)
        rng = self._rng(entry.name)
        if entry.line is not None:
            yield self._thing(
                entry, maker, number, entry.name, self._along(entry, maker, rng, options)
            )
        elif entry.scatter is not None:
            yield from self._scattered(entry, maker, number, rng, options)
        else:
            mesh = self._mesh(entry, maker, rng, options)
            place = self._place(entry)
            piece = self._standing(entry, mesh, place, entry.yaw_deg, entry.scale)
            yield self._thing(entry, maker, number, entry.name, (piece,))

    def _rng(self, name: str) -> np.random.Generator:
        return np.random.default_rng([self.seed, crc32(name.encode())])

    def _mesh(
        self,
        entry: ObjectBlock,
        maker: Maker,
        rng: np.random.Generator,
        options: Mapping[str, Any],
    ) -> Mesh:
        if entry.mesh is not None:
            return read_mesh(entry.mesh).compact()
        return maker.make(rng, options).compact()

    def _place(self, entry: ObjectBlock) -> Floats:
        """Return (east, north) of an entry."""
        if entry.position is not None:
            position = GeoPosition(*entry.position, self.description.place.altitude_m)
            return self.frame.enu_of(position)[:2]
        if entry.at is None:
            raise ValueError('must say at, position, line or scatter')
        return self.world([entry.at])[0]

    def world(self, points: list[Point]) -> Floats:
        """Return (east, north) of points of the scene's own frame, (n, 2)."""
        return to_world(self.description, points)

    def _standing(
        self, entry: ObjectBlock, mesh: Mesh, place: Floats, yaw_deg: float, scale: float
    ) -> Piece:
        if not self.terrain.covers(place[None])[0]:
            half = self.terrain.outer.frame
            raise ValueError(
                f'stands at east {place[0]:.1f} m, north {place[1]:.1f} m: must be on the '
                f'terrain, {half.west_m:g} to {-half.west_m:g} m'
            )
        ground = float(self.terrain.height_at(place[None])[0])
        turned = yaw_deg + self.description.yaw_deg
        rotation = rotation_of(turned, entry.pitch_deg, entry.roll_deg) * scale
        return Piece(
            mesh=mesh, rotation=rotation, offset=np.array([*place, ground + entry.height_m])
        )

    def _along(
        self,
        entry: ObjectBlock,
        maker: Maker,
        rng: np.random.Generator,
        options: Mapping[str, Any],
    ) -> tuple[Piece, ...]:
        if not maker.piece_m:
            raise ValueError(f'{entry.make} stands in one place: must say at, not line')
        flat = resampled(self.world(list(entry.line or ())), _step_of(entry))
        height = self.terrain.height_at(flat) + entry.height_m
        course = np.column_stack([flat, height])
        pieces = []
        for part in _parts(course, maker.piece_m):
            middle = part[len(part) // 2]
            mesh = maker.make_along(rng, part - middle, options).compact()
            pieces.append(Piece(mesh=mesh, rotation=np.eye(3), offset=middle))
        return tuple(pieces)

    def _scattered(
        self,
        entry: ObjectBlock,
        maker: Maker,
        number: int,
        rng: np.random.Generator,
        options: Mapping[str, Any],
    ) -> Iterator[SceneObject]:
        assert entry.scatter is not None  # noqa: S101 - for the type checker
        count = entry.scatter.count
        meshes = [self._mesh(entry, maker, rng, options) for _ in range(min(count, _VARIANTS))]
        places = self._spread(entry, rng)
        for index in range(count):
            yaw = float(rng.uniform(0.0, 360.0))
            size = entry.scale * (float(rng.uniform(0.8, 1.25)) if maker.is_random else 1.0)
            mesh = meshes[index % len(meshes)]
            piece = self._standing(entry, mesh, places[index], yaw, size)
            name = f'{entry.name}_{index + 1}'
            yield self._thing(entry, maker, number + index, name, (piece,))

    def _spread(self, entry: ObjectBlock, rng: np.random.Generator) -> Floats:
        scatter = entry.scatter
        assert scatter is not None  # noqa: S101 - for the type checker
        if scatter.around is not None:
            offsets = rng.normal(0.0, 1.0, (scatter.count, 2)) * np.array(scatter.spread_m)
            return self.world((np.array(scatter.around) + offsets).tolist())
        if scatter.outline is None:
            raise ValueError('scatter must say outline or around')
        return _inside(self.world(list(scatter.outline)), scatter.count, rng)

    def _thing(
        self, entry: ObjectBlock, maker: Maker, number: int, name: str, pieces: tuple[Piece, ...]
    ) -> SceneObject:
        return SceneObject(
            name=name,
            label=entry.label or maker.label,
            number=number,
            pieces=pieces,
            material=entry.material or maker.material,
            fill=entry.fill if entry.material else maker.fill,
            temperature_c=entry.temperature_c,
            is_foliage=maker.is_foliage and entry.mesh is None,
            path=self._path(entry),
        )

    def _path(self, entry: ObjectBlock) -> MovingPath | None:
        if len(entry.path) < 2:
            return None
        flat = self.world([waypoint.at for waypoint in entry.path])
        height = self.terrain.height_at(flat) + entry.height_m
        times = np.array([waypoint.time_s for waypoint in entry.path])
        if np.any(np.diff(times) <= 0.0):
            raise ValueError('path: time_s must rise from waypoint to waypoint')
        return MovingPath(times_s=times, places=np.column_stack([flat, height]))


def to_world(description: SceneDescription, points: list[Point]) -> Floats:
    """Return (east, north) of points of a scene's own frame, (n, 2)."""
    yaw = math.radians(description.yaw_deg)
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.asarray(np.array(points, float) @ np.array([[cos, sin], [-sin, cos]]))


def _checked(entry: ObjectBlock, maker: Maker) -> dict[str, Any]:
    for name in entry.options:
        if name not in maker.options:
            known = ', '.join(maker.options) or 'none'
            raise ValueError(f'with.{name}: unknown option of {entry.make}; known: {known}')
    return {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in entry.options.items()
    }


def _step_of(entry: ObjectBlock) -> float:
    return {'fence': 3.0, 'tape': 4.5}.get(entry.make or '', _LINE_STEP_M)


def _parts(course: Floats, piece_m: float) -> Iterator[Floats]:
    """Yield `course` in parts about `piece_m` long that share their ends."""
    run = run_of(course)
    count = max(1, round(float(run[-1]) / piece_m))
    cuts = np.searchsorted(run, np.linspace(0.0, run[-1], count + 1)[1:-1])
    bounds = [0, *cuts.tolist(), len(course) - 1]
    for start, end in itertools.pairwise(bounds):
        if end > start:
            yield course[start : end + 1]


def _inside(outline: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Return places within a polygon that are not close together while there is room."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    found: list[Floats] = []
    gap = 0.6 * math.sqrt(float(np.prod(high - low)) / count)
    for attempt in range(60 * count):
        place = rng.uniform(low, high)
        if attempt % (6 * count) == 6 * count - 1:
            gap *= 0.7
        if _is_inside(outline, place) and all(np.hypot(*(place - p)) > gap for p in found):
            found.append(place)
            if len(found) == count:
                return np.array(found)
    raise ValueError(f'scatter: no room for {count} in its outline')


def _is_inside(outline: Floats, place: Floats) -> bool:
    x, y = outline[:, 0], outline[:, 1]
    xn, yn = np.roll(x, -1), np.roll(y, -1)
    straddles = (y > place[1]) != (yn > place[1])
    with np.errstate(divide='ignore', invalid='ignore'):
        crossing = x + (place[1] - y) / (yn - y) * (xn - x)
    return bool(np.count_nonzero(straddles & (place[0] < crossing)) % 2)
