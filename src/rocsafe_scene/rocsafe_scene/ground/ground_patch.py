# SPDX-License-Identifier: Apache-2.0
"""Pictures of the ground, in metres about the mission origin."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_scene.errors import GroundError
from rocsafe_scene.painting.canvas import Image

# More than this is asked for only by a camera that looks at the horizon.
LARGEST_PATCH_PX = 200_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundBounds:
    """A rectangle on the ground, metres east and north."""

    west_m: float
    south_m: float
    east_m: float
    north_m: float

    def __post_init__(self) -> None:
        values = (self.west_m, self.south_m, self.east_m, self.north_m)
        if not all(map(math.isfinite, values)):
            raise ValueError(f'bounds are {values}: must be finite')
        if self.west_m >= self.east_m or self.south_m >= self.north_m:
            raise ValueError(f'bounds are {values}: must have west < east and south < north')


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A picture of a piece of ground.

    Attributes
    ----------
    image : blue, green, red; shape (rows, columns, 3).
    pixel_from_ground : homography (3, 3) from (east, north, 1) to (column, row, 1); integer
        coordinates are pixel centres.
    """

    image: Image
    pixel_from_ground: FloatArray


class Ground(Protocol):
    """Where pictures of the ground come from."""

    def patch(self, bounds: GroundBounds, resolution_m: float) -> Patch:
        """Return a picture of all of `bounds` with texels of at most `resolution_m`.

        Raises
        ------
        GroundError: if the picture cannot be had.
        """
        ...


def require_patch_size(columns: int, rows: int) -> None:
    """Raise GroundError if a patch would be larger than any camera needs."""
    if columns * rows > LARGEST_PATCH_PX:
        raise GroundError(
            f'ground picture of {columns} x {rows} px: must have {LARGEST_PATCH_PX} px at most'
        )


def south_up_homography(west_m: float, south_m: float, pixel_m: float) -> FloatArray:
    """Return ground -> pixel where columns run east and rows run north from an outer corner."""
    per_m = 1.0 / pixel_m
    return np.array(
        [
            [per_m, 0.0, -west_m * per_m - 0.5],
            [0.0, per_m, -south_m * per_m - 0.5],
            [0.0, 0.0, 1.0],
        ]
    )
