# SPDX-License-Identifier: Apache-2.0
"""A box of cells over a site, and velocities at the faces of its cells."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_count, require_finite, require_positive

LARGEST_CELLS = 20_000_000
Cells = NDArray[np.float32]


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceVelocities:
    """Velocities at the faces of the cells of a grid, m/s.

    Attributes
    ----------
    east : (columns + 1, rows, layers)
        Through the faces to the west and east of the cells.
    north : (columns, rows + 1, layers)
        Through the faces to the south and north.
    up : (columns, rows, layers + 1)
        Through the faces below and above.
    """

    east: Cells
    north: Cells
    up: Cells

    @property
    def parts(self) -> tuple[Cells, Cells, Cells]:
        """The three arrays."""
        return self.east, self.north, self.up

    def require_fits(self, grid: AirGrid, name: str) -> None:
        """Raise a ValueError unless they are finite and have the shapes of `grid`."""
        for axis, part in enumerate(self.parts):
            shape = tuple(size + (axis == i) for i, size in enumerate(grid.shape))
            if np.shape(part) != shape or not np.isfinite(part).all():
                raise ValueError(f'{name}: velocities must be finite and have the shape {shape}')

    def divergence(self, grid: AirGrid) -> Cells:
        """Return what leaves each cell, 1/s, of the shape of `grid`."""
        sizes = grid.sizes_m.astype(np.float32)
        return sum_of(np.diff(part, axis=i) / sizes[i] for i, part in enumerate(self.parts))


def sum_of(parts: Any) -> Cells:
    """Return the sum of arrays."""
    first, *others = parts
    for part in others:
        first += part
    return np.asarray(first)
