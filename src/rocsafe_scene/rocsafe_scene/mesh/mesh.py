# SPDX-License-Identifier: Apache-2.0
"""Triangle meshes with colours, and their transformations."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rocsafe_geo.pinhole import rotation_enu_from_body
from rocsafe_scene.mesh.surfaces import Surface

# Arrays of any float type: meshes are built in double and kept in single precision.
Floats = NDArray[Any]
Colour = tuple[int, int, int]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh:
    """Triangles with normals, colours and surface coordinates.

    Attributes
    ----------
    points : (n, 3)
        Corners, metres.
    normals : (n, 3)
        Unit normals, outwards.
    places : (n, 2)
        Coordinates of the dirt texture, metres on the surface.
    colours
        Red, green, blue and `Surface` of each corner as bytes, (n, 4).
    triangles : (m, 3)
        Indices of corners, anticlockwise seen from outside.
    """

    points: Floats
    normals: Floats
    places: Floats
    colours: NDArray[np.uint8]
    triangles: NDArray[np.int32]

    def __post_init__(self) -> None:
        count = len(self.points)
        for name, width in (('points', 3), ('normals', 3), ('places', 2), ('colours', 4)):
            shape = getattr(self, name).shape
            if shape != (count, width):
                raise ValueError(f'{name} has shape {shape}: must be {(count, width)}')
        if self.triangles.size and not 0 <= self.triangles.min() <= self.triangles.max() < count:
            raise ValueError(f'triangles name corners outside 0 to {count - 1}')

    @property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates, (2, 3)."""
        # One coordinate at a time: several times as fast as reducing rows.
        columns = np.ascontiguousarray(self.points.T)
        return np.stack([columns.min(axis=1), columns.max(axis=1)])

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> 'Mesh':
        """Return the mesh shifted, metres."""
        return replace(self, points=self.points + np.array([x, y, z]))

    def turned(
        self, yaw_deg: float = 0.0, pitch_deg: float = 0.0, roll_deg: float = 0.0
    ) -> 'Mesh':
        """Return the mesh turned about the origin: roll about x, then pitch, then yaw."""
        return self.transformed(rotation_of(yaw_deg, pitch_deg, roll_deg))

    def transformed(self, rotation: Floats, offset: ArrayLike = (0.0, 0.0, 0.0)) -> 'Mesh':
        """Return the mesh after a rotation (3, 3) and a shift (3,)."""
        points = self.points @ rotation.T + np.asarray(offset, float)
        return replace(self, points=points, normals=self.normals @ rotation.T)

    def scaled(self, x: float, y: float, z: float) -> 'Mesh':
        """Return the mesh stretched along its axes; factors above 0."""
        factors = np.array([x, y, z])
        return replace(self, points=self.points * factors, normals=unit(self.normals / factors))

    def painted(self, colour: Colour, surface: Surface | None = None) -> 'Mesh':
        """Return the mesh in one colour, and of another surface if one is given."""
        colours = self.colours.copy()
        colours[:, :3] = colour
        if surface is not None:
            colours[:, 3] = surface
        return replace(self, colours=colours)

    def compact(self) -> 'Mesh':
        """Return the mesh in single precision."""
        return replace(
            self,
            points=self.points.astype(np.float32),
            normals=self.normals.astype(np.float32),
            places=self.places.astype(np.float32),
        )

    def flipped(self) -> 'Mesh':
        """Return the mesh with its inside out."""
        return replace(
            self, normals=-self.normals, triangles=np.ascontiguousarray(self.triangles[:, ::-1])
        )


def joined(parts: Iterable[Mesh]) -> Mesh:
    """Return one mesh of all `parts`.

    Raises
    ------
    ValueError
        If there are none.
    """
    meshes = list(parts)
    if not meshes:
        raise ValueError('parts are none: a mesh needs at least one')
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes[:-1])])
    return Mesh(
        points=np.concatenate([mesh.points for mesh in meshes]),
        normals=np.concatenate([mesh.normals for mesh in meshes]),
        places=np.concatenate([mesh.places for mesh in meshes]),
        colours=np.concatenate([mesh.colours for mesh in meshes]),
        triangles=np.concatenate(
            [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
        ).astype(np.int32),
    )


def made(
    points: ArrayLike,
    normals: ArrayLike,
    places: ArrayLike,
    triangles: ArrayLike,
    colour: Sequence[int] = (128, 128, 128),
) -> Mesh:
    """Return a matte mesh in one colour."""
    positions = np.asarray(points, float)
    colours = np.tile(np.array([*colour, Surface.MATTE], np.uint8), (len(positions), 1))
    return Mesh(
        points=positions,
        normals=unit(np.asarray(normals, float)),
        places=np.asarray(places, float),
        colours=colours,
        triangles=np.asarray(triangles, np.int32).reshape(-1, 3),
    )


def unit(vectors: Floats) -> Floats:
    """Return unit vectors in the directions of `vectors` (n, 3); zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0))


def rotation_of(yaw_deg: float, pitch_deg: float = 0.0, roll_deg: float = 0.0) -> Floats:
    """Return Rz(yaw) Ry(pitch) Rx(roll), (3, 3); positive pitch lowers the x axis (REP 103)."""
    return rotation_enu_from_body(*map(math.radians, (yaw_deg, pitch_deg, roll_deg)))
