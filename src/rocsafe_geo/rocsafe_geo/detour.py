# SPDX-License-Identifier: Apache-2.0
"""Shortest paths around zones to one place, and the rule by which a path keeps clear of them.

A shortest path among polygons bends only at their corners (Lozano-Perez and Wesley, 1979). Zones
are widened by a clearance. The corners at which paths bend lie 1 mm further out, so that rounding
does not make a path touch the zone.
"""

from collections.abc import Sequence

import numpy as np
import shapely

from rocsafe_geo.arrays import BoolArray, FloatArray

Place = tuple[float, float]
Ring = tuple[Place, ...]

_MARGIN_M = 1e-3
# A vehicle at the clearance may be this far inside it after a change of frame; it is still
# outside.
_SLACK_M = 0.02
# A leg may be this much nearer to a zone than the clearance: routes are drawn in other planes than
# those in which they are checked, and a vehicle stops some decimetres off.
LEG_SLACK_M = 1.0
# Without a clearance a leg may cut a zone by this much, for rounding.
_CUT_M = 0.05


def zone_on_way(
    zones: Sequence[Ring], clearance_m: float, way: Sequence[Place]
) -> tuple[int, int] | None:
    """Return the first leg of a way that is too near to a zone, and that zone, counted from 1.

    An end of the way that is itself nearer than the clearance counts with its own distance: a
    vehicle may leave from there, but not go nearer. From inside a zone no leg is free.

    Parameters
    ----------
    zones
        Outlines of the zones, (east, north) in metres.
    clearance_m
        Distance to keep from them, metres; `LEG_SLACK_M` less is taken.
    way
        Two or more places in order, (east, north) in metres.

    Returns
    -------
    Numbers of the leg and of the zone; None: the way is free.
    """
    if not zones:
        return None
    places = np.asarray(way, dtype=float)
    legs = shapely.linestrings(np.stack([places[:-1], places[1:]], axis=1))
    begin, end = shapely.points(places[[0, -1]])
    faults: list[tuple[int, int]] = []
    for number, zone in enumerate(zones, start=1):
        whole = shapely.make_valid(shapely.Polygon(zone))
        inner = shapely.buffer(whole, -_CUT_M)
        shape = whole if shapely.is_empty(inner) else inner
        limits_m = np.full(len(legs), max(clearance_m - LEG_SLACK_M, 0.0))
        limits_m[0] = min(limits_m[0], shapely.distance(shape, begin) - _CUT_M)
        limits_m[-1] = min(limits_m[-1], shapely.distance(shape, end) - _CUT_M)
        distances_m = shapely.distance(shape, legs)
        near = np.flatnonzero((distances_m <= 0.0) | (distances_m < limits_m))
        faults += [(int(leg) + 1, number) for leg in near[:1]]
    return min(faults, default=None)


class WaysAround:
    """Shortest paths to `goal`; places are (east, north) in metres.

    Parameters
    ----------
    zones
        Outlines of the zones, which no path may cross.
    clearance_m
        Distance to keep from the zones, metres.
    goal
        End of all paths.
    """

    def __init__(self, zones: Sequence[Ring], clearance_m: float, goal: Place) -> None:
        union = shapely.union_all([shapely.make_valid(shapely.Polygon(zone)) for zone in zones])
        self._closed = _widened(union, clearance_m - _SLACK_M)
        self._outline = shapely.boundary(_widened(union, clearance_m + _MARGIN_M))
        shapely.prepare(self._closed)
        corners = shapely.get_coordinates(self._outline)
        self._corners = np.unique(corners, axis=0)
        self._goal = goal
        self._left_m, self._next = self._ways()

    def bends(self, place: Place) -> list[Place]:
        """Return the bends of the path from `place`.

        From inside a zone or its clearance the path first leads out at the nearest point. If the
        zones enclose the goal, the path is straight, as no other exists.
        """
        if not shapely.intersects_xy(self._closed, *place):
            return self._bends_outside(place)
        line = shapely.shortest_line(shapely.Point(place), self._outline)
        east, north = shapely.get_coordinates(line)[-1].tolist()
        return [(east, north), *self._bends_outside((east, north))]

    def _bends_outside(self, place: Place) -> list[Place]:
        here = np.array([place])
        if self._sees(here, np.array([self._goal]))[0, 0]:
            return []
        lengths = _distances(here, self._corners) + self._left_m
        lengths[~self._sees(here, self._corners)] = np.inf
        corner = int(lengths[0].argmin())
        if np.isinf(lengths[0, corner]):
            return []
        path = [corner]
        while self._next[path[-1]] >= 0:
            path.append(int(self._next[path[-1]]))
        return [(east, north) for east, north in self._corners[path].tolist()]

    def _ways(self) -> tuple[FloatArray, list[int]]:
        """Return the distance left from each corner, and its next corner (Dijkstra, 1959)."""
        steps = _distances(self._corners, self._corners)
        steps[~self._sees(self._corners, self._corners)] = np.inf
        goal = np.array([self._goal])
        left = _distances(self._corners, goal)[:, 0]
        left[~self._sees(self._corners, goal)[:, 0]] = np.inf
        following = [-1] * len(left)
        is_open = np.ones(len(left), dtype=bool)
        while is_open.any():
            nearest = int(np.where(is_open, left, np.inf).argmin())
            if not is_open[nearest] or np.isinf(left[nearest]):
                break
            is_open[nearest] = False
            through = left[nearest] + steps[:, nearest]
            for corner in np.flatnonzero(is_open & (through < left)).tolist():
                left[corner], following[corner] = through[corner], nearest
        return left, following

    def _sees(self, a: FloatArray, b: FloatArray) -> BoolArray:
        """Return which straight lines from a (n, 2) to b (k, 2) cross no zone, shape (n, k)."""
        ends = np.broadcast_arrays(a[:, None, :], b[None, :, :])
        lines = shapely.linestrings(np.stack(ends, axis=2))
        clear: BoolArray = ~shapely.intersects(self._closed, lines)
        return clear


def _widened(union: shapely.Geometry, distance_m: float) -> shapely.Geometry:
    return shapely.buffer(union, distance_m, join_style='mitre')


def _distances(a: FloatArray, b: FloatArray) -> FloatArray:
    difference = a[:, None, :] - b[None, :, :]
    distances: FloatArray = np.hypot(difference[..., 0], difference[..., 1])
    return distances
