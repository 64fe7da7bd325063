# SPDX-License-Identifier: Apache-2.0
"""Places of the parts of a source: along a line, over an area, or moving.

A source that is not a point is divided into points of equal strength. Nearer to it than twice the
distance of neighbouring points, their dose rate differs from that of the whole by more than 2 %.
That distance is half a metre for all but the largest sources.
"""

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import shapely
from shapely.geometry import Polygon

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition

SMALLEST_STEP_M = 0.5
MOST_PARTS = 400


class SourceShape(Protocol):
    """The places of a source at any time."""

    def places(self, time_s: float, /) -> FloatArray:
        """Return latitude, longitude in degrees, altitude in metres of each part, (parts, 3).

        All parts are of the same strength. `time_s` counts from the start of the mission.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class PointShape:
    """A source at one place."""

    place: GeoPosition

    def places(self, _time_s: float, /) -> FloatArray:
        """Return the place; the time does not matter."""
        return _rows((self.place,))


@dataclass(frozen=True, slots=True, kw_only=True)
class LineShape:
    """A source spread evenly along a line through `corners`, straight between them."""

    corners: tuple[GeoPosition, ...]
    _parts: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if len(self.corners) < 2:
            raise ValueError(f'a line has {len(self.corners)} corners, must have at least 2')
        frame = LocalFrame(self.corners[0])
        corners = frame.to_enu(*_rows(self.corners).T)
        along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
        if along[-1] <= 0.0:
            raise ValueError('a line must be longer than 0 m')
        count = min(MOST_PARTS, max(2, math.ceil(along[-1] / SMALLEST_STEP_M)))
        middles = (np.arange(count) + 0.5) * along[-1] / count
        parts = np.stack([np.interp(middles, along, axis) for axis in corners.T], axis=1)
        object.__setattr__(self, '_parts', frame.to_geodetic(parts))

    def places(self, _time_s: float, /) -> FloatArray:
        """Return the middles of equal pieces of the line; the time does not matter."""
        return self._parts


@dataclass(frozen=True, slots=True, kw_only=True)
class AreaShape:
    """A source spread evenly over the polygon `corners`, at their mean altitude."""

    corners: tuple[GeoPosition, ...]
    _parts: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if len(self.corners) < 3:
            raise ValueError(f'an area has {len(self.corners)} corners, must have at least 3')
        frame = LocalFrame(self.corners[0])
        corners = frame.to_enu(*_rows(self.corners).T)
        polygon = Polygon(corners[:, :2])
        if not polygon.is_valid or polygon.area <= 0.0:
            raise ValueError('the edges of an area must not cross or coincide')
        inside = _grid_inside(polygon)
        parts = np.column_stack([inside, np.full(len(inside), corners[:, 2].mean())])
        object.__setattr__(self, '_parts', frame.to_geodetic(parts))

    def places(self, _time_s: float, /) -> FloatArray:
        """Return the nodes of a square grid within the polygon; the time does not matter."""
        return self._parts


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackShape:
    """A moving point source: at `times_s` it is at `stops`, in between on the straight line.

    Before the first time it waits at the first stop, after the last it stays at the last.
    """

    times_s: tuple[float, ...]
    stops: tuple[GeoPosition, ...]

    def __post_init__(self) -> None:
        if len(self.times_s) != len(self.stops) or not self.stops:
            raise ValueError(
                f'a track has {len(self.times_s)} times and {len(self.stops)} stops: must be as '
                'many, at least 1'
            )
        times_s = np.array(self.times_s)
        if not np.isfinite(times_s).all() or not (np.diff(times_s) > 0.0).all():
            raise ValueError(f'times_s = {list(self.times_s)} of a track must rise')

    def places(self, time_s: float, /) -> FloatArray:
        """Return the place at `time_s`."""
        # Stops are close together: interpolation in degrees is as good as in metres.
        stops = _rows(self.stops)
        return np.array([[np.interp(time_s, self.times_s, axis) for axis in stops.T]])


def _rows(positions: tuple[GeoPosition, ...]) -> FloatArray:
    return np.array([(p.latitude_deg, p.longitude_deg, p.altitude_m) for p in positions])


def _grid_inside(polygon: Polygon) -> FloatArray:
    """Return nodes of a square grid within `polygon`, east and north, at least one."""
    step = max(SMALLEST_STEP_M, math.sqrt(polygon.area / MOST_PARTS))
    west, south, east, north = polygon.bounds
    axes = (np.arange(low + step / 2, high, step) for low, high in ((west, east), (south, north)))
    nodes = np.stack([part.ravel() for part in np.meshgrid(*axes)], axis=1)
    inside: FloatArray = nodes[shapely.contains_xy(polygon, nodes)] if len(nodes) else nodes
    if len(inside):
        return inside
    middle = polygon.representative_point()
    return np.array([[middle.x, middle.y]])
