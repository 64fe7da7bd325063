# SPDX-License-Identifier: Apache-2.0
"""Height and slope of the ground below a survey, in the frame of the mission."""

from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.solids.ground_heights import GroundHeights
from rocsafe_radiation.errors import RadiationError

# Margin around readings in which the ground is known, metres; beyond it goes on level.
MARGIN_M, LEAST_MARGIN_M = 150.0, 75.0
MOST_CELLS_A_SIDE, SMALLEST_CELL_M = 350, 1.0


class GroundError(RadiationError):
    """The height of the ground is not known."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ground:
    """Heights at the nodes of a grid, linear in between; beyond the rim, those of the rim.

    By default the ground is level, at 0.

    Attributes
    ----------
    corner_m
        East and north of the south-western node.
    cell_m
        Distance of nodes.
    ups_m
        Heights in the mission's frame, shape (rows to the north, columns to the east), metres.
    """

    corner_m: tuple[float, float] = (0.0, 0.0)
    cell_m: float = 1.0
    ups_m: FloatArray = field(default_factory=lambda: np.zeros((1, 1)))

    def __post_init__(self) -> None:
        if self.ups_m.ndim != 2 or not self.ups_m.size or not np.isfinite(self.ups_m).all():
            raise ValueError('ups_m must be a table of finite heights')
        if not self.cell_m > 0.0:
            raise ValueError(f'cell_m = {self.cell_m} must be above 0')

    @property
    def is_level(self) -> bool:
        """Whether it is level, at 0."""
        return self.ups_m.size == 1 and float(self.ups_m[0, 0]) == 0.0

    def reaches(self, places_m: FloatArray) -> bool:
        """Return whether it is known around all places (n, 2)."""
        low = np.array(self.corner_m)
        high = low + self.cell_m * (np.array(self.ups_m.shape[::-1]) - 1.0)
        inside = (places_m >= low + LEAST_MARGIN_M) & (places_m <= high - LEAST_MARGIN_M)
        return bool(inside.all())

    def ups_at(self, places_m: FloatArray) -> FloatArray:
        """Return the height of the ground at places (..., 2)."""
        if self.ups_m.size == 1:
            return np.full(places_m.shape[:-1], self.ups_m[0, 0])
        _, (down, over), corners = self._cells(places_m)
        south = corners[0] + over * (corners[1] - corners[0])
        north = corners[2] + over * (corners[3] - corners[2])
        return np.asarray(south + down * (north - south))

    def slopes_at(self, places_m: FloatArray) -> FloatArray:
        """Return the slope of the ground to the east and to the north, (..., 2)."""
        if self.ups_m.size == 1:
            return np.zeros(places_m.shape)
        (row, column), (down, over), corners = self._cells(places_m)
        rows, columns = self.ups_m.shape
        inside_x = (column > 0.0) & (column < columns - 1.0)
        inside_y = (row > 0.0) & (row < rows - 1.0)
        east = (1.0 - down) * (corners[1] - corners[0]) + down * (corners[3] - corners[2])
        north = (1.0 - over) * (corners[2] - corners[0]) + over * (corners[3] - corners[1])
        return np.stack([east * inside_x, north * inside_y], axis=-1) / self.cell_m

    def raised(self, sources: FloatArray) -> FloatArray:
        """Return east, north, up of places given by east, north and height above, (k, 3)."""
        if self.is_level:
            return sources
        places = sources.copy()
        places[:, 2] += self.ups_at(places[:, :2])
        return places

    def follow(self, slopes: FloatArray, sources: FloatArray) -> None:
        """Add to derivatives by east and north the part that comes from the slope of the ground.

        The first of `slopes` (k, parameters, n) are those by east, north and up of each source.
        """
        if not self.is_level:
            slopes[:, :2] += self.slopes_at(sources[:, :2])[:, :, None] * slopes[:, 2:3]

    def tilted(self, covariance: FloatArray, place_m: FloatArray) -> FloatArray:
        """Return a covariance with up, the third, in place of the height above the ground."""
        turn = np.eye(len(covariance))
        turn[2, :2] = self.slopes_at(place_m[:2])
        return np.asarray(turn @ covariance @ turn.T)

    def _cells(
        self, places_m: FloatArray
    ) -> tuple[
        tuple[FloatArray, FloatArray],
        tuple[FloatArray, FloatArray],
        tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    ]:
        """Return row and column, the fraction within the cell, and the heights of its corners."""
        rows, columns = self.ups_m.shape
        column = np.clip((places_m[..., 0] - self.corner_m[0]) / self.cell_m, 0.0, columns - 1.0)
        row = np.clip((places_m[..., 1] - self.corner_m[1]) / self.cell_m, 0.0, rows - 1.0)
        west = np.minimum(column.astype(np.intp), max(columns - 2, 0))
        south = np.minimum(row.astype(np.intp), max(rows - 2, 0))
        east, north = np.minimum(west + 1, columns - 1), np.minimum(south + 1, rows - 1)
        ups = self.ups_m
        corners = (ups[south, west], ups[south, east], ups[north, west], ups[north, east])
        return (row, column), (row - south, column - west), corners


LEVEL = Ground()


def ground_over(heights: GroundHeights, frame: LocalFrame, places_m: FloatArray) -> Ground:
    """Return the ground under and around places (n, 2) of `frame`.

    Unknown ground is as high as the nearest known ground to the east or west, or else to the north
    or south.

    Raises
    ------
    GroundError
        If it is known nowhere there.
    """
    low, high = places_m.min(axis=0) - MARGIN_M, places_m.max(axis=0) + MARGIN_M
    cell = max(SMALLEST_CELL_M, float((high - low).max()) / MOST_CELLS_A_SIDE)
    columns, rows = (int(count) for count in np.ceil((high - low) / cell) + 1)
    east, north = low[0] + cell * np.arange(columns), low[1] + cell * np.arange(rows)
    nodes = np.stack([*np.meshgrid(east, north), np.zeros((rows, columns))], axis=-1)
    geodetic = frame.to_geodetic(nodes.reshape(-1, 3))
    altitudes = heights.altitudes_m(geodetic[:, 0], geodetic[:, 1])
    known = np.isfinite(altitudes)
    if not known.any():
        latitude, longitude = np.median(geodetic[:, :2], axis=0).tolist()
        raise GroundError(f'the terrain has no height about {latitude:.6f}, {longitude:.6f}')
    ups = np.full(len(altitudes), np.nan)
    ups[known] = frame.to_enu(geodetic[known, 0], geodetic[known, 1], altitudes[known])[:, 2]
    return Ground(
        corner_m=(float(low[0]), float(low[1])),
        cell_m=cell,
        ups_m=_filled(ups.reshape(rows, columns)),
    )


def _filled(ups: FloatArray) -> FloatArray:
    """Return heights with gaps closed along rows, then along columns."""
    for table in (ups, ups.T):
        for row in table:
            known = np.flatnonzero(np.isfinite(row))
            if 0 < known.size < row.size:
                row[:] = np.interp(np.arange(row.size), known, row[known])
    return ups
