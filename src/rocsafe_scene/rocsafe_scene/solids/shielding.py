# SPDX-License-Identifier: Apache-2.0
"""What a scene's things put between a source and a detector: lengths by material.

This serves the interface `Shielding` of the radiation core, which names it in a parameter and
knows nothing of scenes: ``rocsafe_scene.solids.shielding:scene_shielding``. Things shield where
they stand at the start of the mission; leaves and twigs do not.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.building import check
from rocsafe_scene.scene.catalogue import maker_of
from rocsafe_scene.scene.description import ObjectBlock
from rocsafe_scene.scene.environment import SceneObject
from rocsafe_scene.scene.scene_file import read_scene
from rocsafe_scene.solids.ray_boxes import GRAZING, boxes_reached
from rocsafe_scene.solids.rays import Solid, inside_m, solid_of

Coordinates = tuple[Floats, Floats, Floats]
# Materials of photons that things are of, and lengths of these in one of those: by density, as
# photons of hundreds of keV see little else.
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
    """The closed things of a scene.

    Parameters
    ----------
    frame: of the mission.
    things: in metres about its origin; foliage and unknown materials are left out.
    """

    def __init__(self, frame: LocalFrame, things: Iterable[SceneObject]) -> None:
        self._frame = frame
        self._solids: list[Solid] = [
            solid_of(thing)
            for thing in things
            if thing.material in PHOTON_MATERIALS and not thing.is_foliage
        ]
        boxes = [(solid.whole.low, solid.whole.high) for solid in self._solids]
        self._lows, self._highs = np.array(boxes).reshape(-1, 2, 3).swapaxes(0, 1).astype(float)

    def lengths_m(self, starts: Coordinates, points: Coordinates) -> Mapping[str, Floats]:
        """Return by material the length within it of each ray from a start to a point, metres.

        `starts` and `points` are latitudes and longitudes in degrees and altitudes in metres,
        each of shape (m,) and (n,); lengths have shape (m, n).
        """
        ends = self._frame.to_enu(*points)
        totals: dict[str, Floats] = {}
        for row, start in enumerate(self._frame.to_enu(*starts)):
            for first in range(0, len(ends), BLOCK):
                block = slice(first, first + BLOCK)
                for material, lengths in self._lengths(start, ends[block]):
                    shape = (len(starts[0]), len(ends))
                    totals.setdefault(material, np.zeros(shape))[row, block] += lengths
        return totals

    def _lengths(self, start: Floats, ends: Floats) -> Iterable[tuple[str, Floats]]:
        ways = ends - start
        lengths = np.linalg.norm(ways, axis=1)
        directions = ways / np.maximum(lengths, GRAZING)[:, None]
        origins = np.broadcast_to(start, ways.shape)
        reached = boxes_reached(self._lows, self._highs, origins, directions, lengths)
        for index in np.flatnonzero(reached.any(axis=1)):
            solid, rays = self._solids[index], np.flatnonzero(reached[index])
            material, share = PHOTON_MATERIALS[solid.thing.material]
            inside = np.zeros(len(ends))
            inside[rays] = inside_m(solid, origins[rays], directions[rays], lengths[rays])
            yield material, share * solid.thing.fill * inside


def scene_shielding(file: str, seed: int, origin: GeoPosition) -> SceneShielding:
    """Return what the scene of `file` puts in the way, with `seed` and `origin` of the mission.

    Raises
    ------
    SceneError: in one line, if it cannot be read or made.
    """
    described = read_scene(Path(file))
    solid = [entry for entry in described.objects if not _is_foliage(entry)]
    things = check(described.model_copy(update={'objects': solid}), seed, origin)
    return SceneShielding(LocalFrame(origin), things)


def _is_foliage(entry: ObjectBlock) -> bool:
    return entry.make is not None and maker_of(entry.make).is_foliage
