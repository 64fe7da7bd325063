# SPDX-License-Identifier: Apache-2.0
"""A scene as vehicles meet it."""

import numpy as np

from rocsafe_geo.motion.state import Enu
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.solids.rays import Solid, solid_of, touches


class SceneSurroundings:
    """Ground and standing things of a scene; what moves is not in the way.

    The triangles of a thing are sorted when somebody first comes near it.
    """

    def __init__(self, environment: Environment) -> None:
        self._terrain = environment.terrain
        self._things = [thing for thing in environment.objects if thing.path is None]
        bounds = np.array([thing.bounds for thing in self._things]).reshape(-1, 2, 3)
        self._low, self._high = bounds[:, 0], bounds[:, 1]
        self._top_m = float(self._high[:, 2].max(initial=-np.inf))
        self._solids: dict[int, Solid] = {}

    def ground_up_m(self, east_m: float, north_m: float) -> float:
        """Return the height of the ground at a place."""
        return float(self._terrain.height_at(np.array([[east_m, north_m]]))[0])

    def touched(self, place_enu: Enu, radius_m: float) -> str:
        """Return the name of a thing that a ball touches, the ground aside; empty: none."""
        if place_enu[2] > self._top_m + radius_m:
            return ''
        place = np.array(place_enu)
        is_near = (self._low - radius_m <= place) & (place <= self._high + radius_m)
        for index in np.flatnonzero(is_near.all(axis=1)).tolist():
            if index not in self._solids:
                self._solids[index] = solid_of(self._things[index])
            if touches(self._solids[index], place, radius_m):
                return self._things[index].name
        return ''
