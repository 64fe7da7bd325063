# SPDX-License-Identifier: Apache-2.0
"""Images of parts of the ground, placed in metres about the mission origin."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rocsafe_geo.arrays import FloatArray, ImageArray
from rocsafe_scene.errors import GroundError

# Only a camera that looks at the horizon would need more.
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
    """An image of a part of the ground.

    Attributes
    ----------
    image : (rows, columns, 3)
        Blue, green, red.
    pixel_from_ground
        Homography (3, 3) from (east, north, 1) to (column, row, 1); integer coordinates are pixel
        centres.
    """

    image: ImageArray
    pixel_from_ground: FloatArray


class Ground(Protocol):
    """A source of images of the ground."""

    def patch(self, bounds: GroundBounds, resolution_m: float) -> Patch:
        """Return an image of all of `bounds` with texels of at most `resolution_m`.

        Raises
        ------
        GroundError
            If there is no such image.
        """
        ...


def require_patch_size(columns: int, rows: int) -> None:
    """Raise GroundError if a patch would be larger than any camera needs."""
    if columns * rows > LARGEST_PATCH_PX:
        raise GroundError(
            f'ground picture of {columns} x {rows} px: must have {LARGEST_PATCH_PX} px at most'
        )


def south_up_homography(west_m: float, south_m: float, pixel_m: float) -> FloatArray:
    """Return the matrix ground -> pixel if columns run east and rows run north from a corner."""
    per_m = 1.0 / pixel_m
    return np.array(
        [
            [per_m, 0.0, -west_m * per_m - 0.5],
            [0.0, per_m, -south_m * per_m - 0.5],
            [0.0, 0.0, 1.0],
        ]
    )
