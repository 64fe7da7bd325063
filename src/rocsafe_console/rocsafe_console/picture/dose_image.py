# SPDX-License-Identifier: Apache-2.0
"""The dose map as a picture with transparent ground, and the corners at which it lies."""

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from PIL import Image

from rocsafe_geo.frame import LocalFrame
from rocsafe_view.palette import ramp_colour

# What the cells 0 and 100 of hazard/dose_map mean.
LOWEST_USVH, DECADES = 0.1, 6.0
# Below it, the ground is shown and not the dose: natural background is about 0.1 uSv/h.
LEAST_SHOWN_USVH = 0.2
# Low dose rates hide the ground less.
_OPACITIES = (45, 190)


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """Cells of a map in the frame of the mission, south row first.

    Attributes
    ----------
    cells
        0 to 100, negative: unknown.
    columns
        Cells in a row.
    corner_m
        East and north of the south-west corner.
    cell_m
        Side of a cell.
    """

    cells: Sequence[int]
    columns: int
    corner_m: tuple[float, float]
    cell_m: float

    def __post_init__(self) -> None:
        if self.columns < 1 or not self.cells or len(self.cells) % self.columns:
            raise ValueError(f'{len(self.cells)} cells: must be full rows of {self.columns}')
        if not self.cell_m > 0.0:
            raise ValueError(f'cell_m = {self.cell_m}: must be positive')

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.cells) // self.columns


def png_of(grid: Grid) -> bytes:
    """Return the dose map as PNG, north up, in the colours of `colour_scale`."""
    values = np.asarray(grid.cells, dtype=np.int16).reshape(grid.rows, grid.columns)[::-1]
    indexes = np.where((values < 0) | (values > 100), 0, values).astype(np.uint8)
    buffer = BytesIO()
    picture = Image.fromarray(_TABLE[indexes], 'RGBA')
    picture.save(buffer, 'PNG', compress_level=3)
    return buffer.getvalue()


def corners_of(grid: Grid, frame: LocalFrame) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return latitude and longitude in degrees of the south-west and the north-east corner."""
    east, north = grid.corner_m
    far = (east + grid.columns * grid.cell_m, north + grid.rows * grid.cell_m, 0.0)
    south_west, north_east = frame.to_geodetic([(east, north, 0.0), far])[:, :2].tolist()
    return (south_west[0], south_west[1]), (north_east[0], north_east[1])


def colour_scale() -> list[tuple[float, str]]:
    """Return dose rates in uSv/h, one a decade, with their colours."""
    decades = range(round(DECADES) + 1)
    return [(LOWEST_USVH * 10.0**n, ramp_colour(n / DECADES)) for n in decades]


def _table() -> 'np.ndarray[tuple[int, ...], np.dtype[np.uint8]]':
    rows = np.zeros((101, 4), np.uint8)
    low, high = _OPACITIES
    for cell in range(101):
        if LOWEST_USVH * 10.0 ** (DECADES * cell / 100.0) >= LEAST_SHOWN_USVH:
            opacity = low + (high - low) * cell // 100
            rows[cell] = (*bytes.fromhex(ramp_colour(cell / 100.0)[1:]), opacity)
    return rows


_TABLE = _table()
