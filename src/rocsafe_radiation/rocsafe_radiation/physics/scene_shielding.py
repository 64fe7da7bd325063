# SPDX-License-Identifier: Apache-2.0
"""Length of material that the things of a scene put between a source and a detector."""

from collections.abc import Iterable, Mapping

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.solids.ray_boxes import GRAZING, boxes_reached
from rocsafe_geo.solids.scene_solids import SceneSolids, Thing
from rocsafe_geo.solids.solid import Solid
from rocsafe_radiation.physics.shielding import Coordinates

# Material of a thing: the material of `photons.materials` that stands for it, and the length of
# that which a metre of it equals. By density: photons of hundreds of keV see little else.
PHOTON_MATERIALS = {
    'steel': ('iron', 1.0),
    'iron': ('iron', 1.0),
    'lead': ('lead', 1.0),
    'concrete': ('concrete', 1.0),
    'brick': ('concrete', 0.78),
    'water': ('water', 1.0),
    'wood': ('water', 0.6),
}
# Rays at a time, so that memory stays small.
BLOCK = 2000


class SceneShielding:
    """The things of a scene as they shield; those of an unknown material do not.

    Parameters
    ----------
    scene
        Its things, where they stand at the start of the mission.
    """

    def __init__(self, scene: SceneSolids) -> None:
        self._frame = LocalFrame(scene.origin)
        self._things: list[Thing] = [
            thing for thing in scene.things if thing.material in PHOTON_MATERIALS
        ]
        self._solids = [Solid(thing.corners_enu_m) for thing in self._things]
        boxes = [(solid.whole.low, solid.whole.high) for solid in self._solids]
        self._lows, self._highs = np.array(boxes).reshape(-1, 2, 3).swapaxes(0, 1).astype(float)

    def lengths_m(self, starts: Coordinates, points: Coordinates) -> Mapping[str, FloatArray]:
        """Return by material the length within it of each ray, as `Shielding.lengths_m`."""
        ends = self._frame.to_enu(*points)
        totals: dict[str, FloatArray] = {}
        for row, start in enumerate(self._frame.to_enu(*starts)):
            for first in range(0, len(ends), BLOCK):
                block = slice(first, first + BLOCK)
                for material, lengths in self._lengths(start, ends[block]):
                    shape = (len(starts[0]), len(ends))
                    totals.setdefault(material, np.zeros(shape))[row, block] += lengths
        return totals

    def _lengths(self, start: FloatArray, ends: FloatArray) -> Iterable[tuple[str, FloatArray]]:
        ways = ends - start
        lengths = np.linalg.norm(ways, axis=1)
        directions = ways / np.maximum(lengths, GRAZING)[:, None]
        origins = np.broadcast_to(start, ways.shape)
        reached = boxes_reached(self._lows, self._highs, origins, directions, lengths)
        for index in np.flatnonzero(reached.any(axis=1)):
            thing, rays = self._things[index], np.flatnonzero(reached[index])
            material, share = PHOTON_MATERIALS[thing.material]
            inside = np.zeros(len(ends))
            inside[rays] = self._solids[index].inside_m(
                origins[rays], directions[rays], lengths[rays]
            )
            yield material, share * thing.fill * inside
