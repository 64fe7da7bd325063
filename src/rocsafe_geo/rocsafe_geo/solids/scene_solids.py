# SPDX-License-Identifier: Apache-2.0
"""Solids of a scene and heights of its ground, as plain values."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.terrain.height_grid import HeightGrid, height_at


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Thing:
    """A standing thing: closed parts of one material.

    Attributes
    ----------
    name
        Unique in its scene.
    material
        What it is made of, for instance ``steel``.
    fill
        Share of its volume that the material takes, above 0, at most 1.
    corners_enu_m : (m, 3, 3)
        Corners of its triangles, float32, anticlockwise seen from outside.
    """

    name: str
    material: str
    fill: float
    corners_enu_m: NDArray[np.float32]

    def __post_init__(self) -> None:
        if not 0.0 <= self.fill <= 1.0:
            raise ValueError(f'{self.name}: fill = {self.fill} must be within 0 and 1')
        shape = self.corners_enu_m.shape
        if len(shape) != 3 or shape[1:] != (3, 3) or not shape[0]:
            raise ValueError(f'{self.name}: corners_enu_m has shape {shape}, must be (m, 3, 3)')
        if not np.isfinite(self.corners_enu_m).all():
            raise ValueError(f'{self.name}: corners_enu_m must be finite')


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SceneSolids:
    """The standing things of a scene and its ground, about the origin of a mission.

    Attributes
    ----------
    origin
        Origin of the east, north, up frame of all coordinates.
    things
        What stands there; leaves and twigs are left out.
    ground
        Heights of the ground, from the finest grid to the coarsest, at least one.
    """

    origin: GeoPosition
    things: tuple[Thing, ...]
    ground: tuple[HeightGrid, ...]

    def __post_init__(self) -> None:
        if not math.isfinite(self.origin.altitude_m):
            raise ValueError('the altitude of the origin must be finite')
        if not self.ground:
            raise ValueError('ground must hold at least one grid of heights')

    def altitudes_m(self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike) -> FloatArray:
        """Return the altitude of the ground above the ellipsoid at n places, (n,), metres."""
        frame = LocalFrame(self.origin)
        latitudes = np.atleast_1d(np.asarray(latitudes_deg, np.float64))
        longitudes = np.atleast_1d(np.asarray(longitudes_deg, np.float64))
        level = np.full(len(latitudes), self.origin.altitude_m)
        places = frame.to_enu(latitudes, longitudes, level)
        places[:, 2] = height_at(self.ground, places[:, :2])
        return frame.to_geodetic(places)[:, 2]
