# SPDX-License-Identifier: Apache-2.0
"""Marks painted on the ground: polygons, discs and strokes, in metres east and north."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Colour = tuple[int, int, int]
Coordinates = Sequence[Sequence[float]] | NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Paint:
    """Colour and texture of a mark.

    Attributes
    ----------
    colour
        Red, green, blue, 0 to 255.
    grain
        Strength of the centimetre texture on it, 0 to 255.
    opacity
        1 hides what lies below, 0 is invisible.
    softness_m
        Width over which the edges of a translucent mark fade out, metres.
    """

    colour: Colour
    grain: int = 40
    opacity: float = 1.0
    softness_m: float = 0.0

    def lit(self, factor: float) -> 'Paint':
        """Return the paint in light of `factor` times the strength."""
        red, green, blue = (min(255, max(0, round(part * factor))) for part in self.colour)
        return Paint((red, green, blue), self.grain, self.opacity, self.softness_m)


Bounds = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """Polygons filled together with one paint: overlaps are painted once.

    Attributes
    ----------
    outlines
        Corners (n, 2) of each polygon.
    paint
        Paint of all polygons.
    is_faded
        Whether opacity grows from each polygon to the next, which must lie inside it.
    """

    outlines: tuple[Points, ...]
    paint: Paint
    is_faded: bool = False

    @property
    def bounds(self) -> Bounds:
        """West, south, east, north, with the soft edge."""
        reach = 2.0 * self.paint.softness_m
        # The first of faded outlines holds the others.
        outlines = self.outlines[:1] if self.is_faded else self.outlines
        corners = outlines[0] if len(outlines) == 1 else np.concatenate(outlines)
        (west, south), (east, north) = corners.min(axis=0), corners.max(axis=0)
        return float(west - reach), float(south - reach), float(east + reach), float(north + reach)


@dataclass(frozen=True, slots=True, eq=False)
class Dots:
    """Opaque discs, painted one over the other in their order.

    Attributes
    ----------
    centres : (n, 2)
        Centres, metres.
    radii_m : (n,)
    values
        Red, green, blue and grain of each, shape (n, 4), 0 to 255.
    """

    centres: Points
    radii_m: Points
    values: Points

    @property
    def bounds(self) -> Bounds:
        """West, south, east, north."""
        west, south = (self.centres - self.radii_m[:, None]).min(axis=0)
        east, north = (self.centres + self.radii_m[:, None]).max(axis=0)
        return float(west), float(south), float(east), float(north)


Mark = Shape | Dots


def polygon(points: Coordinates, paint: Paint) -> Shape:
    """Return a filled polygon, shape (n, 2)."""
    return Shape((np.asarray(points, float),), paint)


def disc(centre: Sequence[float] | Points, radius_m: float, paint: Paint) -> Dots:
    """Return one opaque disc."""
    value = np.array([[*paint.colour, paint.grain]], float)
    return Dots(np.asarray(centre, float).reshape(1, 2), np.array([radius_m]), value)


def stroke(points: Coordinates, width_m: float, paint: Paint) -> Shape:
    """Return a line of a width, as a polygon; it may bend, but not sharply."""
    return Shape((ribbon(points, width_m),), paint)


def ribbon(points: Coordinates, width_m: float) -> Points:
    """Return the outline of a line (n, 2) of a width."""
    line = np.asarray(points, float)
    normals = 0.5 * width_m * normals_of(line)
    return np.vstack([line + normals, (line - normals)[::-1]])


def normals_of(line: Points) -> Points:
    """Return the unit normals to the left of a line, at each of its points."""
    tangents = np.empty_like(line)
    tangents[1:-1] = line[2:] - line[:-2]
    tangents[0], tangents[-1] = line[1] - line[0], line[-1] - line[-2]
    normals = np.column_stack([-tangents[:, 1], tangents[:, 0]])
    unit: Points = normals / np.hypot(normals[:, 0], normals[:, 1])[:, None]
    return unit


class Layer:
    """Marks in painting order, found by place."""

    def __init__(self, marks: Iterable[Mark]) -> None:
        self._marks = tuple(marks)
        bounds = [mark.bounds for mark in self._marks]
        self._bounds = np.array(bounds, float).reshape(len(bounds), 4)

    def within(
        self, west: float, south: float, east: float, north: float
    ) -> Iterator[tuple[Mark, Bounds]]:
        """Yield, in order, the marks that may be seen there, each with its bounds."""
        b = self._bounds
        meets = (b[:, 0] <= east) & (b[:, 2] >= west) & (b[:, 1] <= north) & (b[:, 3] >= south)
        for index in np.flatnonzero(meets):
            yield self._marks[index], tuple(b[index].tolist())
