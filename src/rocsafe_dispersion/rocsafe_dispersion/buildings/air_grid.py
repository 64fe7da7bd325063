# SPDX-License-Identifier: Apache-2.0
"""A box of cells over a site, and which of them are solid."""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_count, require_finite, require_positive

LARGEST_CELLS = 20_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class AirGrid:
    """Where the cells lie; index order is east, north, up.

    Attributes
    ----------
    west_m, south_m, bottom_m
        East, north and up of the lowest corner of the first cell, metres.
    cell_m, layer_m
        Horizontal and vertical size of a cell, metres.
    columns, rows, layers
        Number of cells to the east, to the north and upwards, 4 to 2000.
    """

    west_m: float
    south_m: float
    bottom_m: float
    cell_m: float
    layer_m: float
    columns: int
    rows: int
    layers: int

    def __post_init__(self) -> None:
        for name in ('west_m', 'south_m', 'bottom_m'):
            require_finite(name, getattr(self, name), 'm')
        require_positive('cell_m', self.cell_m, 'm')
        require_positive('layer_m', self.layer_m, 'm')
        for name in ('columns', 'rows', 'layers'):
            require_count(name, getattr(self, name), 4, 2000)
        if np.prod(self.shape) > LARGEST_CELLS:
            raise ValueError(f'{self.shape} cells: must be at most {LARGEST_CELLS}')

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of cells to the east, to the north and upwards."""
        return self.columns, self.rows, self.layers

    @property
    def sizes_m(self) -> FloatArray:
        """Size of a cell to the east, to the north and upwards, (3,), metres."""
        return np.array([self.cell_m, self.cell_m, self.layer_m])

    @property
    def corner_m(self) -> FloatArray:
        """Lowest corner of the first cell, (3,), metres."""
        return np.array([self.west_m, self.south_m, self.bottom_m])

    def middles_m(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return east of the columns, north of the rows and up of the layers, metres."""
        east, north, up = (
            corner + size * (np.arange(count) + 0.5)
            for corner, size, count in zip(self.corner_m, self.sizes_m, self.shape, strict=True)
        )
        return east, north, up
