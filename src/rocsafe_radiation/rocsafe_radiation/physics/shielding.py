# SPDX-License-Identifier: Apache-2.0
"""Length of each material between a source and a point."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_radiation.physics.photons import material

Coordinates = tuple[FloatArray, FloatArray, FloatArray]


class Shielding(Protocol):
    """The materials in the way of rays."""

    def lengths_m(self, starts: Coordinates, points: Coordinates) -> Mapping[str, FloatArray]:
        """Return by material the length within it of each ray from a start to a point, metres.

        `starts` and `points` are latitudes and longitudes in degrees and altitudes in metres, each
        of shape (m,) and (n,); lengths have shape (m, n). Air is left out: it fills all other
        space. Materials are those of `photons.materials`.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """An upright box of one material, in east, north, up of the mission frame.

    Attributes
    ----------
    material
        Name of its material.
    centre_enu_m
        Its centre.
    size_m
        Length, width and height, outside.
    yaw_rad
        Direction of its length, anticlockwise from east.
    wall_m
        Thickness of its six walls, metres; 0: it is solid.
    """

    material: str
    centre_enu_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    yaw_rad: float = 0.0
    wall_m: float = 0.0

    def __post_init__(self) -> None:
        material(self.material)
        if not all(0.0 < side < math.inf for side in self.size_m):
            raise ValueError(f'size_m = {self.size_m} of a box must be above 0')
        if not all(map(math.isfinite, (*self.centre_enu_m, self.yaw_rad))):
            raise ValueError(f'centre_enu_m = {self.centre_enu_m} of a box must be finite')
        if not 0.0 <= self.wall_m < min(self.size_m) / 2.0:
            raise ValueError(
                f'wall_m = {self.wall_m} of a box must be at least 0 and less than half its '
                f'shortest side, {min(self.size_m) / 2.0:g}'
            )

    def lengths_m(self, starts_enu: FloatArray, points_enu: FloatArray) -> FloatArray:
        """Return the length in the material of each ray from (m, 3) to (n, 3), shape (m, n)."""
        turn = self._rotation()
        starts = (starts_enu - np.array(self.centre_enu_m)) @ turn.T
        rays = (points_enu - np.array(self.centre_enu_m)) @ turn.T - starts[:, None]
        half = np.array(self.size_m) / 2.0
        shares = _shares_within(starts, rays, half)
        if self.wall_m > 0.0:
            shares = shares - _shares_within(starts, rays, half - self.wall_m)
        return np.asarray(shares * np.linalg.norm(rays, axis=-1))

    def _rotation(self) -> FloatArray:
        cosine, sine = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxShielding:
    """Boxes that stand in the frame of a mission; where two overlap, both count."""

    frame: LocalFrame
    boxes: tuple[Box, ...]

    def lengths_m(self, starts: Coordinates, points: Coordinates) -> Mapping[str, FloatArray]:
        """Return by material the length within it of each ray from a start to a point, metres."""
        starts_enu = self.frame.to_enu(*starts)
        points_enu = self.frame.to_enu(*points)
        lengths: dict[str, FloatArray] = {}
        for box in self.boxes:
            inside = box.lengths_m(starts_enu, points_enu)
            lengths[box.material] = lengths.get(box.material, 0.0) + inside
        return lengths


@dataclass(frozen=True, slots=True)
class JoinedShielding:
    """Several shieldings at once; where two overlap, both count."""

    parts: tuple[Shielding, ...]

    def lengths_m(self, starts: Coordinates, points: Coordinates) -> Mapping[str, FloatArray]:
        """Return by material the length within it of each ray from a start to a point, metres."""
        totals: dict[str, FloatArray] = {}
        for part in self.parts:
            for name, lengths in part.lengths_m(starts, points).items():
                totals[name] = totals.get(name, 0.0) + lengths
        return totals


def joined(parts: Sequence[Shielding]) -> Shielding | None:
    """Return `parts` as one shielding, None if there are none."""
    if len(parts) > 1:
        return JoinedShielding(tuple(parts))
    return parts[0] if parts else None


def _shares_within(starts: FloatArray, rays: FloatArray, half: FloatArray) -> FloatArray:
    """Return the share of each ray within a box about the origin, by the slab method.

    A ray is inside while it is between all three pairs of faces.
    """
    # A ray along a face never crosses it; a tiny step keeps the quotient finite.
    safe = np.where(np.abs(rays) < 1e-12, 1e-12, rays)
    bounds = np.stack([(-half - starts)[:, None] / safe, (half - starts)[:, None] / safe])
    enter = np.maximum(bounds.min(axis=0).max(axis=-1), 0.0)
    leave = np.minimum(bounds.max(axis=0).min(axis=-1), 1.0)
    return np.asarray(np.maximum(leave - enter, 0.0))
