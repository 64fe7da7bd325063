# SPDX-License-Identifier: Apache-2.0
"""Ground and obstacles of a scene for simulated vehicles."""

import math

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.solids.ray_boxes import boxes_reached
from rocsafe_geo.solids.solid import Solid
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.solids.solids_export import triangles_of

# The ground is sought along a ray in such steps, m, and then by so many halvings of one.
GROUND_STEP_M, HALVINGS = 0.25, 12


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
            if self._solid(index).touches(place, radius_m):
                return self._things[index].name
        return ''

    def first_hit_m(self, place_enu: Enu, direction_enu: Enu, limit_m: float) -> float:
        """Return the distance along a unit direction to the ground or a thing, metres.

        Infinite if there is nothing up to `limit_m`.
        """
        origin, direction = np.array([place_enu]), np.array([direction_enu])
        found = self._to_ground_m(origin, direction, limit_m)
        reach = np.array([min(found, limit_m)])
        reached = boxes_reached(self._low, self._high, origin, direction, reach)
        for index in np.flatnonzero(reached.any(axis=1)).tolist():
            found = min(found, self._solid(index).first_hit_m(origin, direction, reach))
        return found

    def _to_ground_m(self, origin: FloatArray, direction: FloatArray, limit_m: float) -> float:
        def is_below(distances_m: FloatArray) -> BoolArray:
            places = origin + distances_m[:, None] * direction
            return np.asarray(places[:, 2] <= self._terrain.height_at(places[:, :2]))

        steps = np.append(np.arange(0.0, limit_m, GROUND_STEP_M), limit_m)
        below = is_below(steps)
        if not below.any():
            return math.inf
        first = int(below.argmax())
        low, high = float(steps[max(first - 1, 0)]), float(steps[first])
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_below(np.array([middle]))[0] else (middle, high)
        return high

    def _solid(self, index: int) -> Solid:
        if index not in self._solids:
            self._solids[index] = Solid(triangles_of(self._things[index]))
        return self._solids[index]
