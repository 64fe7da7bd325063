# SPDX-License-Identifier: Apache-2.0
"""How much of which material lies between a source and a point."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.photons import material

Array = NDArray[np.float64]
Coordinates = tuple[Array, Array, Array]


class Shielding(Protocol):
    """Whatever knows the materials of a scene."""

    def lengths_m(self, source: GeoPosition, points: Coordinates) -> Mapping[str, Array]:
        """Return by material the length of each ray from `source` within it, metres.

        `points` are latitudes and longitudes in degrees and altitudes in metres, each of shape
        (n,); so are the lengths. Air is left out: it is where nothing else is.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """An upright box of one material, in east, north, up of the mission frame.

    Attributes
    ----------
    material: name of its material.
    centre_enu_m: its centre.
    size_m: length, width and height.
    yaw_rad: direction of its length, anticlockwise from east.
    """

    material: str
    centre_enu_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    yaw_rad: float = 0.0

    def __post_init__(self) -> None:
        material(self.material)
        if not all(0.0 < size < math.inf for size in self.size_m):
            raise ValueError(f'size_m = {self.size_m} must be above 0 and finite')
        if not all(map(math.isfinite, (*self.centre_enu_m, self.yaw_rad))):
            raise ValueError('centre_enu_m and yaw_rad must be finite')

    def lengths_m(self, source_enu: Array, points_enu: Array) -> Array:
        """Return the length within the box of each ray from `source_enu` to `points_enu` (n, 3).

        By the slab method: the ray is inside while it is between all three pairs of faces.
        """
        turn = self._rotation()
        half = np.array(self.size_m) / 2.0
        start = turn @ (source_enu - np.array(self.centre_enu_m))
        rays = (points_enu - source_enu) @ turn.T
        # A ray along a face never crosses it; a tiny step keeps the quotient finite.
        safe = np.where(np.abs(rays) < 1e-12, 1e-12, rays)
        bounds = np.stack([(-half - start) / safe, (half - start) / safe])
        enter = np.maximum(bounds.min(axis=0).max(axis=1), 0.0)
        leave = np.minimum(bounds.max(axis=0).min(axis=1), 1.0)
        return np.asarray(np.maximum(leave - enter, 0.0) * np.linalg.norm(rays, axis=1))

    def _rotation(self) -> Array:
        cosine, sine = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxShielding:
    """Boxes that stand in the frame of a mission; where two overlap, both count."""

    frame: LocalFrame
    boxes: tuple[Box, ...]

    def lengths_m(self, source: GeoPosition, points: Coordinates) -> Mapping[str, Array]:
        """Return by material the length of each ray within it, metres."""
        source_enu = self.frame.enu_of(source)
        points_enu = self.frame.to_enu(*points)
        lengths: dict[str, Array] = {}
        for box in self.boxes:
            inside = box.lengths_m(source_enu, points_enu)
            lengths[box.material] = lengths.get(box.material, 0.0) + inside
        return lengths
