# SPDX-License-Identifier: Apache-2.0
"""Maps of hazards as pictures with transparent ground, and the corners at which they lie."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from PIL import Image

from rocsafe_geo.frame import LocalFrame
from rocsafe_view.palette import gas_colour, ramp_colour

# Low values hide the ground less.
_OPACITIES = (45, 190)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """What the cells of a map mean, and their colours.

    Attributes
    ----------
    lowest
        Value of the cells 0, in the unit of the map.
    decades
        Cells 100 are 10 to this power as much.
    least_shown
        Below it, the ground is shown and not the hazard.
    colour
        Colour ``#rrggbb`` of a fraction of the scale, 0 to 1.
    """

    lowest: float
    decades: float
    least_shown: float
    colour: Callable[[float], str]

    def stops(self) -> list[tuple[float, str]]:
        """Return values, one a decade, with their colours."""
        count = round(self.decades)
        return [(self.lowest * 10.0**n, self.colour(n / self.decades)) for n in range(count + 1)]

    def table(self) -> 'np.ndarray[tuple[int, ...], np.dtype[np.uint8]]':
        """Return red, green, blue and opacity of the cells 0 to 100, 0 to 255."""
        rows = np.zeros((101, 4), np.uint8)
        low, high = _OPACITIES
        for cell in range(101):
            if self.lowest * 10.0 ** (self.decades * cell / 100.0) >= self.least_shown:
                opacity = low + (high - low) * cell // 100
                rows[cell] = (*bytes.fromhex(self.colour(cell / 100.0)[1:]), opacity)
        return rows


# The scales of hazard/dose_map, uSv/h, and of hazard/plume, ppm. Natural background is about
# 0.1 uSv/h; no gas sensor for the field sees less than some hundredths of a ppm.
DOSE = Scale(lowest=0.1, decades=6.0, least_shown=0.2, colour=ramp_colour)
PLUME = Scale(lowest=0.01, decades=6.0, least_shown=0.05, colour=gas_colour)


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


def png_of(grid: Grid, scale: Scale) -> bytes:
    """Return a map as PNG, north up, in the colours of `scale`."""
    values = np.asarray(grid.cells, dtype=np.int16).reshape(grid.rows, grid.columns)[::-1]
    indexes = np.where((values < 0) | (values > 100), 0, values).astype(np.uint8)
    buffer = BytesIO()
    picture = Image.fromarray(scale.table()[indexes], 'RGBA')
    picture.save(buffer, 'PNG', compress_level=3)
    return buffer.getvalue()


def corners_of(grid: Grid, frame: LocalFrame) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return latitude and longitude in degrees of the south-west and the north-east corner."""
    east, north = grid.corner_m
    far = (east + grid.columns * grid.cell_m, north + grid.rows * grid.cell_m, 0.0)
    south_west, north_east = frame.to_geodetic([(east, north, 0.0), far])[:, :2].tolist()
    return (south_west[0], south_west[1]), (north_east[0], north_east[1])
