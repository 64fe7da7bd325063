# SPDX-License-Identifier: Apache-2.0
"""First guess of the wind around buildings: slow air before them, back flow and wake behind.

Röckle 1990 as in Kaplan and Dinar 1996 (Atmos. Environ. 30, 4197), for blocks across the wind.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.wind.air_grid import AirGrid
from rocsafe_geo.wind.wind_vector import WindVector


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A building as a block along and across the wind.

    Attributes
    ----------
    along_m, across_m
        Its middle in the frame of the wind, metres.
    length_m, width_m, height_m
        Its size along and across the wind and upwards, metres.
    """

    along_m: float
    across_m: float
    length_m: float
    width_m: float
    height_m: float

    @property
    def cavity_m(self) -> float:
        """Length of the back flow behind it, metres."""
        slenderness = np.clip(self.length_m / self.height_m, 0.3, 3.0) ** 0.3
        ratio = self.width_m / self.height_m
        return float(1.8 * self.width_m / (slenderness * (1.0 + 0.24 * ratio)))

    @property
    def upwind_m(self) -> float:
        """Length of the slow air before it, metres."""
        return 2.0 * self.width_m / (1.0 + 0.8 * self.width_m / self.height_m)


def blocks_of(grid: AirGrid, heights_m: FloatArray, wind: WindVector) -> Iterator[Block]:
    """Yield the buildings of a site as blocks.

    Parameters
    ----------
    grid
        Its cells.
    heights_m : (columns, rows)
        Height of what stands there above the ground, metres.
    wind
        The wind.
    """
    labels, count = ndimage.label(heights_m > 0.0)
    along, across = _wind_frame(grid, wind)
    for number, box in enumerate(ndimage.find_objects(labels, max_label=count), 1):
        own = labels[box] == number
        first, second = along[box][own], across[box][own]
        yield Block(
            along_m=float(first.max() + first.min()) / 2.0,
            across_m=float(second.max() + second.min()) / 2.0,
            length_m=float(np.ptp(first)) + grid.cell_m,
            width_m=float(np.ptp(second)) + grid.cell_m,
            height_m=float(heights_m[box][own].max()),
        )


def _wind_frame(grid: AirGrid, wind: WindVector) -> tuple[FloatArray, FloatArray]:
    """Return the place of each (column, row) along and across the wind, metres."""
    east, north, _ = grid.middles_m()
    e, n = wind.towards_east_mps / wind.speed_mps, wind.towards_north_mps / wind.speed_mps
    x, y = np.meshgrid(east, north, indexing='ij')
    return x * e + y * n, y * e - x * n


def wake_factors(
    grid: AirGrid, above_ground_m: FloatArray, heights_m: FloatArray, wind: WindVector
) -> FloatArray:
    """Return by what the undisturbed wind is multiplied in each cell, of the shape of `grid`.

    Parameters
    ----------
    grid
        Cells.
    above_ground_m : (columns, rows, layers)
        Height of the middle of each cell above the ground, metres.
    heights_m : (columns, rows)
        Height of what stands there above the ground, metres.
    wind
        Undisturbed wind; its speed must be above 0.
    """
    factors = np.ones(grid.shape)
    along, across = _wind_frame(grid, wind)
    for block in blocks_of(grid, heights_m, wind):
        reach = block.length_m / 2.0 + 3.0 * block.cavity_m
        near = (np.abs(along - block.along_m) < max(reach, block.upwind_m + block.length_m)) & (
            np.abs(across - block.across_m) < block.width_m / 2.0
        )
        if not near.any():
            continue
        places = (along[near] - block.along_m, across[near] - block.across_m)
        own = _block_factors(block, *places, above_ground_m[near])
        # Where zones of two buildings meet, the slower air counts.
        factors[near] = np.minimum(factors[near], own)
    return factors


def _block_factors(
    block: Block, along_m: FloatArray, across_m: FloatArray, up_m: FloatArray
) -> FloatArray:
    """Return the factors of one block at n columns (n, layers)."""
    height = np.clip(up_m / block.height_m, 0.0, None)
    bulge = np.clip(1.0 - height**2, 0.0, 1.0)
    narrow = np.sqrt(np.clip(1.0 - (2.0 * across_m / block.width_m) ** 2, 0.0, 1.0))[:, None]
    behind = (along_m - block.length_m / 2.0)[:, None]
    before = (-along_m - block.length_m / 2.0)[:, None]
    cavity = block.cavity_m * narrow * np.sqrt(bulge)
    is_low: BoolArray = height < 1.0
    # Behind: back flow in the cavity, then a wake three times as long that fades.
    at = np.maximum(behind, 1e-9)
    back = -((1.0 - np.minimum(at / np.maximum(cavity, 1e-9), 1.0)) ** 2)
    wake = 1.0 - np.minimum(cavity / at, 1.0) ** 1.5
    factor = np.where(is_low & (behind > 0.0) & (behind < cavity), back, 1.0)
    in_wake = is_low & (behind >= cavity) & (behind < 3.0 * cavity) & (behind > 0.0)
    factor = np.where(in_wake, wake, factor)
    slow = block.upwind_m * narrow * np.sqrt(np.clip(1.0 - (height / 0.6) ** 2, 0.0, 1.0))
    return np.where((before > 0.0) & (before < slow), 0.0, factor)
