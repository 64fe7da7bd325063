# SPDX-License-Identifier: Apache-2.0
"""Ground and obstacles of a scene for simulated vehicles."""

import numpy as np

from rocsafe_geo.motion.state import Enu
from rocsafe_geo.solids.solid import Solid
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.solids.solids_export import triangles_of


class SceneSurroundings:
    """Ground and standing things of a scene; moving things are not obstacles.

    The triangles of a thing are put into clusters when a vehicle first comes near it.

    Parameters
    ----------
    environment
        The scene as built.
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
        """Return the name of a thing that a ball about `place_enu` touches, '' if none.

        The ground is not looked at.
        """
        if place_enu[2] > self._top_m + radius_m:
            return ''
        place = np.array(place_enu)
        is_near = (self._low - radius_m <= place) & (place <= self._high + radius_m)
        for index in np.flatnonzero(is_near.all(axis=1)).tolist():
            if index not in self._solids:
                self._solids[index] = Solid(triangles_of(self._things[index]))
            if self._solids[index].touches(place, radius_m):
                return self._things[index].name
        return ''
