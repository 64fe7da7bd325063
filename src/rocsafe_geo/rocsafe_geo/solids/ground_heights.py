# SPDX-License-Identifier: Apache-2.0
"""Heights of the ground from a file: an elevation model, or the solids of a scene."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.solids_file import SUFFIX, read_solids
from rocsafe_geo.terrain.terrain_file import read_terrain


class GroundHeights(Protocol):
    """How high the ground is at any place."""

    def altitudes_m(self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike) -> FloatArray:
        """Return the altitude of the ground above the ellipsoid, (n,); NaN where unknown."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class ShiftedHeights:
    """Heights above another level surface, for instance the geoid, shifted to the ellipsoid."""

    heights: GroundHeights
    shift_m: float

    def altitudes_m(self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike) -> FloatArray:
        """Return the altitude of the ground above the ellipsoid, (n,); NaN where unknown."""
        return self.heights.altitudes_m(latitudes_deg, longitudes_deg) + self.shift_m


def read_heights(file: str | Path, shift_m: float = 0.0) -> GroundHeights:
    """Return the heights of the ground in a file.

    Parameters
    ----------
    file
        A ``.npz`` file of a scene's solids, or else a GeoTIFF of heights.
    shift_m
        Added to the heights of the file, metres.

    Raises
    ------
    ValueError
        In one line, if the file is not there or holds no heights.
    """
    path = Path(file)
    is_scene = path.suffix == SUFFIX
    heights: GroundHeights = read_solids(path) if is_scene else read_terrain(path)
    return ShiftedHeights(heights=heights, shift_m=shift_m) if shift_m else heights


def shift_to_m(heights: GroundHeights, known: Sequence[GeoPosition]) -> float:
    """Return the mean difference of known altitudes of the ground to `heights`, metres.

    Parameters
    ----------
    heights
        Of the ground, above any one level surface.
    known
        Places on the ground; none: the difference is 0.

    Raises
    ------
    ValueError
        If `heights` has none at a place.
    """
    if not known:
        return 0.0
    found = heights.altitudes_m(
        [place.latitude_deg for place in known], [place.longitude_deg for place in known]
    )
    for place, height in zip(known, found.tolist(), strict=True):
        if not np.isfinite(height):
            raise ValueError(
                f'the terrain has no height at {place.latitude_deg:.6f}, '
                f'{place.longitude_deg:.6f}: must cover the places of known altitude'
            )
    return float(np.mean([place.altitude_m for place in known] - found))
