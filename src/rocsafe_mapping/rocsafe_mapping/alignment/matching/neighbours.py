# SPDX-License-Identifier: Apache-2.0
"""Which photographs may show the same ground, by where they should lie."""

import math

import numpy as np
import shapely

from rocsafe_mapping.alignment.model.photo import Photo, footprint
from rocsafe_mapping.alignment_options import NeighbourOptions


def outline(photo: Photo, options: NeighbourOptions) -> shapely.Polygon:
    """Return the ground that `photo` may show: a disc where its yaw is not known.

    A yaw that is wrong by half a turn, a common fault, does not change the outline of a nadir
    photograph.
    """
    corners = footprint(photo, photo.prior)
    reach = np.linalg.norm(corners[2] - corners[0]) / 2.0
    margin = min(options.margin_stds * photo.horizontal_std_m, options.most_margin_share * reach)
    if photo.has_yaw:
        return shapely.Polygon(corners).convex_hull.buffer(margin, quad_segs=2)
    return shapely.Point(photo.prior.centre[:2]).buffer(
        reach + margin, quad_segs=options.disc_sides
    )


class Neighbourhood:
    """Finds the photographs that may overlap one; they are added one by one.

    Parameters
    ----------
    options
        What a neighbour is.
    """

    def __init__(self, options: NeighbourOptions) -> None:
        self._options = options
        self._outlines: dict[str, shapely.Polygon] = {}
        self._cells: dict[tuple[int, int], list[str]] = {}
        self._cell_m = 0.0

    def add(self, photo: Photo) -> None:
        """Take in a photograph."""
        shape = outline(photo, self._options)
        if not self._outlines:
            west, south, east, north = shape.bounds
            self._cell_m = max(east - west, north - south)
        self._outlines[photo.name] = shape
        for cell in self._cells_of(shape):
            self._cells.setdefault(cell, []).append(photo.name)

    def remove(self, name: str) -> None:
        """Forget a photograph."""
        for cell in self._cells_of(self._outlines.pop(name)):
            self._cells[cell].remove(name)

    def of(self, name: str) -> tuple[str, ...]:
        """Return the names of the photographs that overlap `name` most, best first."""
        shape = self._outlines[name]
        near = {other for cell in self._cells_of(shape) for other in self._cells[cell]} - {name}
        shares = []
        for other in sorted(near):
            shared = shape.intersection(self._outlines[other]).area
            share = shared / min(shape.area, self._outlines[other].area)
            if share >= self._options.least_overlap_share:
                shares.append((-share, other))
        return tuple(other for _, other in sorted(shares)[: self._options.most])

    def pairs(self) -> list[tuple[str, str]]:
        """Return all pairs of neighbours, in order of their names."""
        found = {
            (min(name, other), max(name, other))
            for name in self._outlines
            for other in self.of(name)
        }
        return sorted(found)

    def _cells_of(self, shape: shapely.Polygon) -> list[tuple[int, int]]:
        west, south, east, north = (math.floor(edge / self._cell_m) for edge in shape.bounds)
        return [(x, y) for x in range(west, east + 1) for y in range(south, north + 1)]
