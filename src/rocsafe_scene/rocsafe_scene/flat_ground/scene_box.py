# SPDX-License-Identifier: Apache-2.0
"""Boxes around the objects of a scene, for viewers that draw markers."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    # Vehicles read boxes of files only, without the modules that build scenes.
    from rocsafe_scene.scene.environment import Piece, SceneObject

# Objects that are smaller than this in every direction get no box, metres.
SMALLEST_BOX_M = 0.8
_DIGITS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneBox:
    """The smallest box, in its own axes, around one piece of an object.

    Attributes
    ----------
    name
        Name of the object in its scene.
    label
        Class of the object.
    position_enu
        Centre: metres east, north and up of the mission origin.
    quaternion
        Rotation from the axes of the box to east, north, up: x, y, z, w.
    size_m
        Extents along the axes of the box, metres.
    """

    name: str
    label: str
    position_enu: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    size_m: tuple[float, float, float]


def boxes_of(
    objects: Iterable['SceneObject'], half_m: tuple[float, float]
) -> tuple[SceneBox, ...]:
    """Return the boxes of all but small objects.

    Parameters
    ----------
    objects
        Of a scene as built.
    half_m
        Half extents, east and north, of the area about the origin within which boxes are wanted.
    """
    boxes = (_box(thing, piece) for thing in objects for piece in thing.pieces)
    return tuple(
        box
        for box in boxes
        if max(box.size_m) >= SMALLEST_BOX_M
        and all(abs(at) <= half for at, half in zip(box.position_enu[:2], half_m, strict=True))
    )


def _box(thing: 'SceneObject', piece: 'Piece') -> SceneBox:
    # Imported here: it takes half a second, and vehicles do not need it.
    from scipy.spatial.transform import Rotation

    low, high = piece.mesh.bounds
    # The rotation may also scale, alike in all directions.
    scale = float(np.linalg.norm(piece.rotation[:, 0]))
    centre = piece.rotation @ (0.5 * (low + high)) + piece.offset
    east, north, up = centre.round(_DIGITS).tolist()
    length, width, height = (scale * (high - low)).round(_DIGITS).tolist()
    x, y, z, w = Rotation.from_matrix(piece.rotation / scale).as_quat().round(_DIGITS + 2).tolist()
    return SceneBox(
        name=thing.name,
        label=thing.label,
        position_enu=(east, north, up),
        quaternion=(x, y, z, w),
        size_m=(length, width, height),
    )
