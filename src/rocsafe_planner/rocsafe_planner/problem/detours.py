# SPDX-License-Identifier: Apache-2.0
"""Shortest paths around zones: a visibility graph in the plane.

A shortest path among polygons bends at their corners only (Lozano-Perez and Wesley, 1979).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray
from rocsafe_planner.errors import NoWayError

Flight = Callable[[FloatArray, FloatArray], FloatArray]
"""Time of flights from places to places (east, north, up), in seconds."""


# Distance of the corners of paths from the zones beyond the clearance.
MARGIN_M = 1e-3
_BLOCK = 256


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Air:
    """Times of a vehicle's flights, and its places at sites and corners, (k, 3) each."""

    flight: Flight
    sites: FloatArray
    corners: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Door:
    """A site from and to which legs may cross a zone, of which no other part is closed."""

    site: int
    zone: shapely.Geometry

    def passes(self, edges: FloatArray) -> BoolArray:
        """Return which edges (e, 2, 2) are of its zone."""
        middles = shapely.points(edges.mean(axis=1))
        passed: BoolArray = shapely.dwithin(middles, shapely.boundary(self.zone), MARGIN_M)
        return passed


class Detours:
    """Shortest paths among sites.

    Attributes
    ----------
    length_m
        From each site to each, shape (s, s).
    corners
        At which paths bend, shape (c, 2).
    """

    def __init__(
        self,
        sites: FloatArray,
        corners: FloatArray,
        edges: FloatArray,
        doors: Sequence[Door] = (),
    ) -> None:
        self._sites, self.corners = sites, corners
        ways, self._next = _corner_paths(corners, edges)
        reach = _distances(sites, corners)
        passed = np.zeros((len(sites), len(edges)), dtype=bool)
        for door in doors:
            passed[door.site] |= door.passes(edges)
        reach[_blocked(sites, corners, edges, passed)] = np.inf
        self.length_m: FloatArray = _distances(sites, sites)
        self.first: NDArray[np.int32] = np.full(self.length_m.shape, -1, dtype=np.int32)
        self.last: NDArray[np.int32] = self.first.copy()
        self._fill(_blocked(sites, sites, edges, passed, passed), reach, ways)
        self._durations: dict[Air, FloatArray] = {}

    def _fill(self, blocked: BoolArray, reach: FloatArray, ways: FloatArray) -> None:
        """Set lengths, and first and last corners, of the blocked pairs, row by row."""
        np.fill_diagonal(blocked, val=False)
        for i in np.flatnonzero(blocked.any(axis=1)):
            others = np.flatnonzero(blocked[i])
            through = reach[i][:, None] + ways
            out = through.argmin(axis=0)
            lengths = through[out, np.arange(len(out))] + reach[others]
            last = lengths.argmin(axis=1)
            best = lengths[np.arange(len(others)), last]
            if np.isinf(best).any():
                lost = others[int(np.isinf(best).argmax())]
                raise NoWayError(_no_way(self._sites[i], self._sites[lost]))
            self.length_m[i, others] = best
            self.first[i, others], self.last[i, others] = out[last], last

    def corners_between(self, origin: int, target: int) -> IndexArray:
        """Return the indices of the corners at which a path bends, in flying order."""
        corner, last = int(self.first[origin, target]), int(self.last[origin, target])
        if corner < 0:
            return np.zeros(0, dtype=np.intp)
        path = [corner]
        while corner != last:
            corner = int(self._next[corner, last])
            path.append(corner)
        return np.array(path, dtype=np.intp)

    def duration_s(self, origins: IndexArray, targets: IndexArray, air: Air) -> FloatArray:
        """Return the times of paths, broadcast; a vehicle stops where its path bends."""
        origins, targets = np.broadcast_arrays(origins, targets)
        first, last = self.first[origins, targets], self.last[origins, targets]
        bent = first >= 0
        durations = np.empty(origins.shape)
        straight = ~bent
        durations[straight] = air.flight(
            air.sites[origins[straight]], air.sites[targets[straight]]
        )
        if bent.any():
            begin, end = air.corners[first[bent]], air.corners[last[bent]]
            durations[bent] = (
                air.flight(air.sites[origins[bent]], begin)
                + self._between_corners_s(air)[first[bent], last[bent]]
                + air.flight(end, air.sites[targets[bent]])
            )
        return durations

    def _between_corners_s(self, air: Air) -> FloatArray:
        """Return the times of the paths among corners, shape (c, c); computed once a flight."""
        if air not in self._durations:
            self._durations[air] = self._walked_s(air)
        return self._durations[air]

    def _walked_s(self, air: Air) -> FloatArray:
        at, target = np.indices(self._next.shape)
        legs = air.flight(air.corners[at], air.corners[target])
        total = np.zeros(legs.shape)
        while (at != target).any():
            step = np.where(at == target, at, self._next[at, target])
            total += np.where(at == target, 0.0, legs[at, step])
            at = step
        return total

    @cached_property
    def is_straight(self) -> bool:
        """Whether all paths are straight."""
        return bool((self.first < 0).all())


def _distances(a: FloatArray, b: FloatArray) -> FloatArray:
    distances: FloatArray = np.hypot(a[:, None, 0] - b[None, :, 0], a[:, None, 1] - b[None, :, 1])
    return distances


def _blocked(
    a: FloatArray,
    b: FloatArray,
    edges: FloatArray,
    passed_a: BoolArray | None = None,
    passed_b: BoolArray | None = None,
) -> BoolArray:
    """Return which segments from `a` (n, 2) to `b` (k, 2) meet an edge, shape (n, k).

    Those of a place that passes an edge do not meet it: `passed_a` (n, e), `passed_b` (k, e).
    """
    blocked = np.zeros((len(a), len(b)), dtype=bool)
    for start in range(0, len(a), _BLOCK):
        block = slice(start, start + _BLOCK)
        for number, (begin, end) in enumerate(edges):
            meets = _meets(a[block], b, begin, end)
            if passed_a is not None:
                meets[passed_a[block, number]] = False
            if passed_b is not None:
                meets[:, passed_b[:, number]] = False
            blocked[block] |= meets
    return blocked


def _meets(a: FloatArray, b: FloatArray, begin: FloatArray, end: FloatArray) -> BoolArray:
    """Return which segments meet one edge: both lie across, or on, each other's line."""
    side_a, side_b = _cross(end - begin, a - begin), _cross(end - begin, b - begin)
    apart = side_a[:, None] * side_b[None, :] > 0.0
    # cross(b - a, c - a) = cross(a, b) - cross(a, c) + cross(b, c), with c an end of the edge
    pair = a[:, None, 0] * b[None, :, 1] - a[:, None, 1] * b[None, :, 0]
    to_begin = pair - _cross(a, begin)[:, None] + _cross(b, begin)[None, :]
    to_end = pair - _cross(a, end)[:, None] + _cross(b, end)[None, :]
    meets: BoolArray = ~apart & (to_begin * to_end <= 0.0)
    return meets


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _corner_paths(corners: FloatArray, edges: FloatArray) -> tuple[FloatArray, IndexArray]:
    """Return lengths, and the corner after the first, of all paths (Floyd, 1962)."""
    count = len(corners)
    ways = _distances(corners, corners)
    blocked = _blocked(corners, corners, edges)
    np.fill_diagonal(blocked, val=False)
    ways[blocked] = np.inf
    following = np.broadcast_to(np.arange(count), (count, count)).copy()
    for middle in range(count):
        through = ways[:, middle, None] + ways[None, middle, :]
        shorter = through < ways
        ways = np.where(shorter, through, ways)
        following = np.where(shorter, following[:, middle, None], following)
    return ways, following


def _no_way(a: FloatArray, b: FloatArray) -> str:
    return (
        f'exclusions shut off the place {a[0]:.0f} m east, {a[1]:.0f} m north of the centre from '
        f'the one at {b[0]:.0f} m, {b[1]:.0f} m: no leg can join them'
    )
