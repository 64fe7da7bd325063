# SPDX-License-Identifier: Apache-2.0
"""A scene graph for a pipe without shaders: each piece is there twice, for image and for labels.

For the labels each triangle is drawn in a colour that encodes its number.
"""

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from panda3d import core

from rocsafe_scene.errors import SceneError
from rocsafe_scene.graphics import upload
from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.mesh.coarse import clustered
from rocsafe_scene.mesh.mesh import Floats, Mesh, rotation_of, unit
from rocsafe_scene.parts.thinning import LEAFY, coarser
from rocsafe_scene.scene.environment import GROUND_NUMBER, Environment, Piece, SceneObject
from rocsafe_scene.scene.sunlight import Lighting

# Camera mask bits: one for the image, one for the numbers.
LOOK, KNOW = (core.BitMask32.bit(number) for number in range(2))
_INNER_CELLS, _OUTER_CELLS, _FAR_CELLS = 32, 24, 20
_LARGEST_PX = 4096
# Distances, metres, up to which plants and other objects are drawn in full, and at all. Simpler
# meshes keep one corner in each cube of this size, if they have more triangles than this.
_LEAVES_M, _FINE_M, _BEYOND_M, _CELL_M, _FEW = 90.0, 60.0, 9000.0, 0.16, 60
# Brightness of surfaces lit by the sky alone, what the sun adds, and what clouds add to the sky.
_SKY_LIGHT, _SUN_LIGHT, _OVERCAST_LIGHT = 0.55, 0.6, 0.3


_MOST_TRIANGLES = 2**24 - 1


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """All triangles of a scene by number; 0 is the sky.

    Attributes
    ----------
    corners : (n, 3, 3)
        Corners in the frame of the owner, metres.
    owners : (n,)
        Index of the owner of each triangle.
    numbers, kinds
        Instance and class of each owner; class -1 is the ground, whose map has the classes.
    turns, places
        Rotation (k, 3, 3) and place (k, 3) of each owner in east, north, up.
    """

    corners: NDArray[np.float32]
    owners: NDArray[np.int32]
    numbers: NDArray[np.uint32]
    kinds: NDArray[np.int16]
    turns: Floats
    places: Floats

    def placed(self, chosen: NDArray[Any]) -> Floats:
        """Return the corners of chosen triangles in east, north, up, (n, 3, 3)."""
        owner = self.owners[chosen]
        turned = np.einsum('nij,nkj->nki', self.turns[owner], self.corners[chosen].astype(float))
        return np.asarray(turned + self.places[owner][:, None])


class SoftwareSceneGraph:
    """Everything that is drawn, under one root node.

    Parameters
    ----------
    environment
        Scene to draw.
    lighting
        Light of the scene.
    """

    def __init__(self, environment: Environment, lighting: Lighting) -> None:
        self.root = core.NodePath('scene')
        self.ground_maps = (environment.inner, environment.outer)
        self._moving: list[tuple[int, SceneObject, Any]] = []
        self._meshes: dict[int, list[Mesh]] = {}
        self._sun = np.array(lighting.sun_direction)
        sun_share = min(1.0, max(lighting.sun) / 3.0)
        self._sun_light = _SUN_LIGHT * sun_share
        self._sky_light = _SKY_LIGHT + _OVERCAST_LIGHT * (1.0 - sun_share)
        # The sky is the first owner, and triangle 0 is its.
        self._owners = [(0, class_number('sky')), (GROUND_NUMBER, -1)]
        self._corners: list[NDArray[np.float32]] = [np.zeros((1, 3, 3), np.float32)]
        self._owner_of = [np.zeros(1, np.int32)]
        self._count = 1
        self._add_ground(environment)
        for thing in environment.objects:
            self._add(thing)
        self.triangles = self._triangles()

    def _triangles(self) -> Triangles:
        count = len(self._owners)
        return Triangles(
            corners=np.concatenate(self._corners),
            owners=np.concatenate(self._owner_of),
            numbers=np.array([number for number, _ in self._owners], np.uint32),
            kinds=np.array([kind for _, kind in self._owners], np.int16),
            turns=np.tile(np.eye(3), (count, 1, 1)),
            places=np.zeros((count, 3)),
        )

    def move(self, time_s: float) -> None:
        """Move objects to their places at a time, seconds after the start."""
        for owner, thing, node in self._moving:
            assert thing.path is not None  # noqa: S101 - only such are kept
            place, yaw = thing.path.shift_at(time_s)
            node.setPosHpr(*place.tolist(), float(np.degrees(yaw)), 0.0, 0.0)
            self.triangles.turns[owner] = rotation_of(float(np.degrees(yaw)))
            self.triangles.places[owner] = place

    def _lit(self, mesh: Mesh, turn: Floats, *, is_foliage: bool = False) -> Mesh:
        """Return a mesh with the colours it has in the light when it is turned by `turn`."""
        facing = unit(mesh.normals @ turn.T) @ self._sun
        share = 0.4 + 0.3 * np.abs(facing) if is_foliage else np.maximum(facing, 0.0)
        level = self._sky_light + self._sun_light * share
        colours = mesh.colours.copy()
        colours[:, :3] = np.clip(mesh.colours[:, :3] * level[:, None], 0.0, 255.0)
        colours[:, 3] = 255
        return replace(mesh, colours=colours)

    def _add_ground(self, environment: Environment) -> None:
        terrain = environment.terrain
        for grid, cells, hole, picture in (
            (terrain.inner, _INNER_CELLS, None, environment.inner),
            (terrain.outer, _OUTER_CELLS, terrain.inner, environment.outer),
            (terrain.far, _FAR_CELLS, terrain.outer, environment.outer),
        ):
            parent = self.root.attachNewNode('ground')
            parent.setTexture(_ground_texture(picture))
            for mesh in upload.grid_meshes(grid, cells, hole):
                laid = _with_places(self._lit(mesh, np.eye(3)), picture)
                seen = parent.attachNewNode(upload.geom_node('ground', laid))
                seen.hide(KNOW)
                self._know(parent, mesh.points[mesh.triangles], 1)

    def _add(self, thing: SceneObject) -> None:
        parent = self.root.attachNewNode(thing.name)
        parent.setTextureOff()
        if thing.is_foliage:
            parent.setTwoSided(True)
        owner = len(self._owners)
        self._owners.append((thing.number, class_number(thing.label)))
        for piece in thing.pieces:
            self._add_piece(parent, thing, piece, owner)
        if thing.path is not None:
            self._moving.append((owner, thing, parent))

    def _add_piece(self, parent: Any, thing: SceneObject, piece: Piece, owner: int) -> None:
        offset = np.zeros(3) if thing.path is not None else piece.offset
        meshes = self._steps(thing, piece)
        fine_m = _LEAVES_M if thing.label in LEAFY else _FINE_M
        steps = core.LODNode('steps')
        middle = piece.rotation @ piece.mesh.bounds.mean(axis=0) + offset
        steps.setCenter(core.LPoint3f(*(float(value) for value in middle)))
        below = parent.attachNewNode(steps)
        for number, mesh in enumerate(meshes):
            is_last = number == len(meshes) - 1
            steps.addSwitch(_BEYOND_M if is_last else fine_m, fine_m * number)
            lit = self._lit(mesh, piece.rotation, is_foliage=thing.is_foliage)
            placed = replace(lit, points=mesh.points @ piece.rotation.T + offset)
            step = below.attachNewNode('step')
            seen = step.attachNewNode(upload.geom_node(thing.name, placed))
            seen.hide(KNOW)
            self._know(step, placed.points[placed.triangles], owner)

    def _steps(self, thing: SceneObject, piece: Piece) -> list[Mesh]:
        """Return the mesh of a piece, and a simpler one for larger distances."""
        key = id(piece.mesh)
        if key not in self._meshes:
            mesh = piece.mesh
            is_small = len(mesh.triangles) < _FEW
            self._meshes[key] = (
                coarser(mesh)[2:] if thing.label in LEAFY
                else [mesh] if is_small else [mesh, clustered(mesh, _CELL_M)]
            )  # fmt: skip
        return self._meshes[key]

    def _know(self, parent: Any, corners: Floats, owner: int) -> None:
        """Add triangles, corners (n, 3, 3) in the frame of `parent`, in the colours of numbers."""
        count = len(corners)
        if self._count + count > _MOST_TRIANGLES:
            raise SceneError(f'more than {_MOST_TRIANGLES} triangles: too many for this pipe')
        numbers = np.arange(self._count, self._count + count)
        node = parent.attachNewNode(_numbered_node(corners, numbers))
        node.hide(LOOK)
        self._corners.append(corners.astype(np.float32))
        self._owner_of.append(np.full(count, owner, np.int32))
        self._count += count


def _bytes(numbers: NDArray[Any]) -> NDArray[np.uint8]:
    """Return numbers as red, green, blue and full opacity, (n, 4)."""
    parts = [(numbers >> shift) & 255 for shift in (16, 8, 0)]
    return np.stack([*parts, np.full_like(numbers, 255)], axis=-1).astype(np.uint8)


def _numbered_node(corners: Floats, numbers: NDArray[Any]) -> Any:
    """Return a node whose triangles (n, 3, 3) have the colours of their numbers (n,)."""
    count = 3 * len(corners)
    normals = np.zeros((count, 3))
    mesh = Mesh(
        points=corners.reshape(-1, 3),
        normals=normals,
        places=normals[:, :2],
        colours=np.repeat(_bytes(numbers), 3, axis=0),
        triangles=np.arange(count, dtype=np.int32).reshape(-1, 3),
    )
    return upload.geom_node('numbered', mesh)


def _with_places(mesh: Mesh, ground: GroundMap) -> Mesh:
    """Return a piece of ground with texture coordinates in the ground map."""
    width, height = ground.size_m
    places = (mesh.points[:, :2] - [ground.west_m, ground.south_m]) / [width, height]
    return replace(mesh, places=places)


def _ground_texture(ground: GroundMap) -> Any:
    """Return the ground map as a texture of a size that the pipe can take."""
    rows, columns = ground.colours.shape[:2]
    size = tuple(min(_LARGEST_PX, 1 << (side - 1).bit_length()) for side in (columns, rows))
    image = cv2.resize(ground.colours, size, interpolation=cv2.INTER_AREA)
    return upload.colour_texture('ground', np.asarray(image, np.uint8))
