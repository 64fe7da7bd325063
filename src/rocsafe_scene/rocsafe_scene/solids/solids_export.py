# SPDX-License-Identifier: Apache-2.0
"""Solids and ground of a scene as plain values, for the file that other packages read."""

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.scene_solids import SceneSolids, Thing
from rocsafe_scene.scene.building import check, terrain_of
from rocsafe_scene.scene.catalogue import maker_of
from rocsafe_scene.scene.description import ObjectBlock, SceneDescription
from rocsafe_scene.scene.environment import SceneObject


def solids_of(description: SceneDescription, seed: int, origin: GeoPosition) -> SceneSolids:
    """Return the solids of a scene at the start of a mission, without leaves and twigs.

    Parameters
    ----------
    description
        The scene.
    seed, origin
        Those of the mission.

    Raises
    ------
    SceneError
        In one line, if an entry cannot be made.
    """
    closed = [entry for entry in description.objects if not _is_foliage(entry)]
    objects = check(description.model_copy(update={'objects': closed}), seed, origin)
    return SceneSolids(
        origin=origin,
        things=tuple(_thing(each) for each in objects if not each.is_foliage),
        ground=terrain_of(description, seed, origin).grids,
    )


def triangles_of(thing: SceneObject) -> NDArray[np.float32]:
    """Return the corners of a thing's triangles at the start of the mission, (m, 3, 3), metres."""
    corners = np.concatenate(
        [piece.points()[piece.mesh.triangles] for piece in thing.pieces]
    ).astype(np.float32)
    if thing.path is not None:
        corners = corners + thing.path.places[0].astype(np.float32)
    return corners


def _thing(thing: SceneObject) -> Thing:
    return Thing(
        name=thing.name,
        material=thing.material,
        fill=thing.fill,
        corners_enu_m=triangles_of(thing),
    )


def _is_foliage(entry: ObjectBlock) -> bool:
    return entry.make is not None and maker_of(entry.make).is_foliage
