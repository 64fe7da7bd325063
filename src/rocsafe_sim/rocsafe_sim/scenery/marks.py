# SPDX-License-Identifier: Apache-2.0
"""Marks that make up the painted scene: polygons, discs and strokes, in metres east and north."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]
Colour = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Paint:
    """How a surface looks.

    Attributes
    ----------
    colour : red, green, blue, 0 to 255.
    grain : strength of the centimetre texture on it, 0 to 255.
    opacity : 1 hides what lies below, 0 would be invisible.
    softness_m : width over which its edges fade out; only if it is translucent.
    """

    colour: Colour
    grain: int = 40
    opacity: float = 1.0
    softness_m: float = 0.0

    def lit(self, factor: float) -> 'Paint':
        """Return the paint in light of `factor` times the strength."""
        red, green, blue = (min(255, max(0, round(part * factor))) for part in self.colour)
        return Paint((red, green, blue), self.grain, self.opacity, self.softness_m)


@dataclass(frozen=True, slots=True, eq=False)
class Mark:
    """One polygon, or one disc if it has a single point, filled with one paint."""

    points: Points
    paint: Paint
    radius_m: float = 0.0

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """West, south, east, north, with the soft edge."""
        reach = self.radius_m + 2.0 * self.paint.softness_m
        west, south = self.points.min(axis=0) - reach
        east, north = self.points.max(axis=0) + reach
        return west, south, east, north


def polygon(points: ArrayLike, paint: Paint) -> Mark:
    """Return a filled polygon, shape (n, 2)."""
    return Mark(np.asarray(points, float), paint)


def disc(centre: ArrayLike, radius_m: float, paint: Paint) -> Mark:
    """Return a filled disc."""
    return Mark(np.asarray(centre, float).reshape(1, 2), paint, radius_m)


def stroke(points: ArrayLike, width_m: float, paint: Paint) -> Mark:
    """Return a line of a width, as a polygon; it may bend, but not sharply."""
    line = np.asarray(points, float)
    tangents = np.gradient(line, axis=0) if len(line) > 2 else np.repeat(
        line[1:] - line[:1], 2, axis=0
    )
    normals = np.column_stack([-tangents[:, 1], tangents[:, 0]])
    normals *= 0.5 * width_m / np.linalg.norm(normals, axis=1, keepdims=True)
    return Mark(np.vstack([line + normals, (line - normals)[::-1]]), paint)


@dataclass(frozen=True, slots=True)
class Placing:
    """Where a thing stands and how it is turned: local x forward, y left -> east, north."""

    east_m: float
    north_m: float
    yaw_rad: float = 0.0

    def to_world(self, points: ArrayLike) -> Points:
        """Return local points (n, 2) in the world."""
        local = np.asarray(points, float)
        cos, sin = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        turned = local @ np.array([[cos, sin], [-sin, cos]])
        return turned + np.array([self.east_m, self.north_m])

    def moved(self, x_m: float, y_m: float, turn_rad: float = 0.0) -> 'Placing':
        """Return the placing of a part that stands at local (x, y), turned."""
        east, north = self.to_world([[x_m, y_m]])[0]
        return Placing(float(east), float(north), self.yaw_rad + turn_rad)


def rectangle(placing: Placing, length_m: float, width_m: float, paint: Paint) -> Mark:
    """Return a rectangle centred on and turned with `placing`."""
    x, y = 0.5 * length_m, 0.5 * width_m
    return polygon(placing.to_world([[-x, -y], [x, -y], [x, y], [-x, y]]), paint)


class Layer:
    """Marks in painting order, found by place."""

    def __init__(self, marks: Iterable[Mark]) -> None:
        self._marks = tuple(marks)
        bounds = [mark.bounds for mark in self._marks]
        self._bounds = np.array(bounds, float).reshape(len(bounds), 4)

    def within(self, west: float, south: float, east: float, north: float) -> Iterable[Mark]:
        """Yield, in order, the marks whose bounds meet those given."""
        b = self._bounds
        meets = (b[:, 0] <= east) & (b[:, 2] >= west) & (b[:, 1] <= north) & (b[:, 3] >= south)
        return (self._marks[index] for index in np.flatnonzero(meets))
