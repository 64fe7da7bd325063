# SPDX-License-Identifier: Apache-2.0
"""The ground of a scene as others ask for it: altitudes at latitudes and longitudes.

This serves the interface `GroundHeights` of the radiation core, which names it in a parameter and
knows nothing of scenes: ``rocsafe_scene.solids.ground_heights:scene_heights``.
"""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.ground.terrain import Terrain
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.building import terrain_of
from rocsafe_scene.scene.scene_file import read_scene


class SceneHeights:
    """The ground of a scene in the frame of a mission."""

    def __init__(self, terrain: Terrain, frame: LocalFrame) -> None:
        self._terrain, self._frame = terrain, frame

    def altitudes_m(self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike) -> Floats:
        """Return the altitude of the ground above the ellipsoid, (n,)."""
        latitudes = np.atleast_1d(np.asarray(latitudes_deg, np.float64))
        longitudes = np.atleast_1d(np.asarray(longitudes_deg, np.float64))
        level = np.full(len(latitudes), self._frame.origin.altitude_m)
        places = self._frame.to_enu(latitudes, longitudes, level)
        places[:, 2] = self._terrain.height_at(places[:, :2])
        return self._frame.to_geodetic(places)[:, 2]


def scene_heights(file: str, seed: int, known: tuple[GeoPosition, ...]) -> SceneHeights:
    """Return the ground of the scene of `file`, made with `seed` about the first place.

    Raises
    ------
    ValueError: if no place is given.
    SceneError: in one line, if the scene cannot be read or made.
    """
    if not known:
        raise ValueError('the origin of the mission must be the first of the places')
    origin = known[0]
    return SceneHeights(terrain_of(read_scene(Path(file)), seed, origin), LocalFrame(origin))
