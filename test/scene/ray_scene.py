# SPDX-License-Identifier: Apache-2.0
"""A scene by casting rays: the truth that renderers and obstacles are compared with."""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.solids.solid import Solid, blocks, crossings
from rocsafe_scene.scene.environment import GROUND_NUMBER
from rocsafe_scene.solids.solids_export import triangles_of

# The ground is sought in steps that grow with the distance, then halved to a hair.
FIRST_STEP_M, STEP_GROWTH, HALVINGS, REACH_M = 0.35, 1.015, 34, 6000.0


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """Distance to what each of n rays meets first, infinite for nothing, and its number, or 0."""

    distances_m: np.ndarray
    numbers: np.ndarray


class RayScene:
    """What stands in a scene at the start of the mission."""

    def __init__(self, environment):
        self.terrain = environment.terrain
        self.things = [(thing, Solid(triangles_of(thing))) for thing in environment.objects]

    def first_hits(self, origins, directions):
        """Return what rays from `origins` (n, 3) in unit `directions` (n, 3) meet first."""
        found = self._ground(origins, directions)
        numbers = np.where(np.isfinite(found), GROUND_NUMBER, 0)
        for thing, solid in self.things:
            rays = solid.whole.reached(origins, directions, found)
            distance = nearest(solid, thing.is_foliage, origins[rays], directions[rays])
            is_nearer = distance < found[rays]
            found[rays[is_nearer]] = distance[is_nearer]
            numbers[rays[is_nearer]] = thing.number
        return Hits(found, numbers)

    def touched(self, place, radius_m):
        """Return the name of the first thing that a ball about `place` touches, '' if none."""
        names = (thing.name for thing, solid in self.things if solid.touches(place, radius_m))
        return next(names, '')

    def _ground(self, origins, directions):
        def above(rays, distance):
            places = origins[rays] + directions[rays] * distance[:, None]
            return places[:, 2] - self.terrain.height_at(places[:, :2])

        low, high = np.zeros(len(origins)), np.full(len(origins), np.inf)
        searching = np.arange(len(origins))
        reach, step = 0.0, FIRST_STEP_M
        while len(searching) and reach < REACH_M:
            reach, step = reach + step, step * STEP_GROWTH
            is_below = above(searching, np.full(len(searching), reach)) <= 0.0
            high[searching[is_below]] = reach
            low[searching] = np.where(is_below, reach - step / STEP_GROWTH, reach)
            searching = searching[~is_below]
        rays = np.flatnonzero(np.isfinite(high))
        for _ in range(HALVINGS):
            middle = 0.5 * (low[rays] + high[rays])
            is_below = above(rays, middle) <= 0.0
            high[rays[is_below]], low[rays[~is_below]] = middle[is_below], middle[~is_below]
        return high


def nearest(solid, has_two_sides, origins, directions):
    """Return the distance to the first triangle in front of which a ray sees the outside."""
    found = np.full(len(origins), np.inf)
    for cluster in solid.clusters:
        for block in blocks(cluster.reached(origins, directions, found)):
            distance, cosine = crossings(cluster, origins[block], directions[block])
            is_seen = (distance > 0.0) & (has_two_sides | (cosine < 0.0))
            closest = np.where(is_seen, distance, np.inf).min(axis=1)
            found[block] = np.minimum(found[block], closest)
    return found
