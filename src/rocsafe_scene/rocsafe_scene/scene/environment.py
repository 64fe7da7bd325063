# SPDX-License-Identifier: Apache-2.0
"""A scene as built: terrain, ground maps, objects with their labels."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.ground.terrain import Terrain
from rocsafe_scene.mesh.mesh import Floats, Mesh
from rocsafe_scene.scene.description import SceneDescription

SKY_NUMBER, GROUND_NUMBER, FIRST_OBJECT_NUMBER = 0, 1, 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Piece:
    """A placed mesh; several pieces may share one mesh.

    Attributes
    ----------
    mesh
        Mesh in its own coordinates.
    rotation : (3, 3)
        Rotation from own axes to east, north, up; may include one scale factor.
    offset : (3,)
        Place of the origin of the mesh, metres.
    """

    mesh: Mesh
    rotation: Floats
    offset: Floats

    def points(self) -> Floats:
        """Return the corners in east, north, up, (n, 3)."""
        return np.asarray(self.mesh.points @ self.rotation.T + self.offset)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MovingPath:
    """Places of a moving object: `places` (k, 3) at `times_s` (k,)."""

    times_s: Floats
    places: Floats

    def shift_at(self, time_s: float) -> tuple[Floats, float]:
        """Return the place at a time, (3,), and the yaw of the motion there, rad."""
        times = self.times_s
        at = min(max(int(times.searchsorted(time_s)), 1), len(times) - 1)
        start, step = self.places[at - 1], self.places[at] - self.places[at - 1]
        span_s = float(times[at] - times[at - 1])
        share = min(max((time_s - float(times[at - 1])) / span_s, 0.0), 1.0) if span_s else 1.0
        return start + share * step, math.atan2(step[1], step[0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SceneObject:
    """An object of a scene.

    Attributes
    ----------
    name
        Unique name.
    label
        Class name.
    number
        Instance number in the labels, from `FIRST_OBJECT_NUMBER` on.
    pieces
        Pieces of its surface.
    material
        Material for rays.
    fill
        Share of the volume that the material fills, 0 to 1.
    temperature_c
        Temperature of the surface, degrees Celsius.
    is_foliage
        Whether polygons are visible from both sides.
    path
        Path of a moving object; None if it stands.
    """

    name: str
    label: str
    number: int
    pieces: tuple[Piece, ...]
    material: str = 'steel'
    fill: float = 1.0
    temperature_c: float = 15.0
    is_foliage: bool = False
    path: MovingPath | None = None

    @property
    def bounds(self) -> Floats:
        """Lowest and highest east, north, up, (2, 3)."""
        corners = np.concatenate([piece.points() for piece in self.pieces])
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @property
    def triangle_count(self) -> int:
        """Number of triangles of all pieces."""
        return sum(len(piece.mesh.triangles) for piece in self.pieces)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Environment:
    """All of a scene, in metres about the mission origin.

    Attributes
    ----------
    description
        Description from which it was built.
    seed
        Seed of everything random in it.
    terrain
        Shape of the ground.
    inner, outer
        Ground maps near the origin and around.
    objects
        Objects by rising number.
    tufts
        Meshes of long grass, which counts as ground.
    """

    description: SceneDescription
    seed: int
    terrain: Terrain
    inner: GroundMap
    outer: GroundMap
    objects: tuple[SceneObject, ...]
    tufts: Sequence[Mesh] = ()
