# SPDX-License-Identifier: Apache-2.0
"""A solid thing as triangles: how much of a ray lies inside it, and what touches it.

All coordinates are metres in one east, north, up frame. Triangles are kept in clusters of
neighbours, each with the box around it, so that most of them need not be looked at.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.solids.ray_boxes import GRAZING, boxes_reached

# Pairs of ray and triangle worked on at once, so that memory stays small.
_BLOCK = 400_000
_CLUSTER_SIZE = 64


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Neighbouring triangles and the box around them.

    Attributes
    ----------
    low, high : (3,)
        Opposite corners of the box.
    corners : (m, 3, 3)
        Corners of the triangles, anticlockwise seen from outside.
    """

    low: NDArray[np.floating]
    high: NDArray[np.floating]
    corners: NDArray[np.floating]

    @property
    def edges(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """First corner of each triangle and the two edges from it, each (m, 3)."""
        first = self.corners[:, 0].astype(float)
        return first, self.corners[:, 1] - first, self.corners[:, 2] - first

    def reached(
        self, origins: FloatArray, directions: FloatArray, limits: FloatArray
    ) -> IndexArray:
        """Return the indices of the rays that enter the box within their lengths."""
        return np.flatnonzero(
            boxes_reached(self.low[None], self.high[None], origins, directions, limits)[0]
        )


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A thing of closed parts, which may overlap.

    Attributes
    ----------
    corners : (m, 3, 3)
        Corners of its triangles, anticlockwise seen from outside.
    whole
        All triangles.
    clusters
        The same triangles in clusters.
    lows, highs : (k, 3)
        Opposite corners of the boxes around the clusters.
    """

    corners: NDArray[np.floating]
    whole: Cluster = field(init=False)
    clusters: list[Cluster] = field(init=False)
    lows: NDArray[np.floating] = field(init=False)
    highs: NDArray[np.floating] = field(init=False)

    def __post_init__(self) -> None:
        clusters = list(_clusters(self.corners))
        object.__setattr__(self, 'whole', _cluster(self.corners))
        object.__setattr__(self, 'clusters', clusters)
        object.__setattr__(self, 'lows', np.array([one.low for one in clusters]))
        object.__setattr__(self, 'highs', np.array([one.high for one in clusters]))

    def inside_m(
        self, origins: FloatArray, directions: FloatArray, lengths: FloatArray
    ) -> FloatArray:
        """Return the length of each ray inside the union of the closed parts, (n,), metres.

        Parameters
        ----------
        origins, directions : (n, 3)
            Start of each ray and its unit direction.
        lengths : (n,)
            Length of each ray.
        """
        rays: list[IndexArray] = [np.zeros(0, int)]
        distances: list[FloatArray] = [np.zeros(0)]
        cosines: list[FloatArray] = [np.zeros(0)]
        reached = boxes_reached(self.lows, self.highs, origins, directions, lengths)
        for index in np.flatnonzero(reached.any(axis=1)):
            for block in blocks(np.flatnonzero(reached[index])):
                cluster = self.clusters[index]
                at, across = crossings(cluster, origins[block], directions[block])
                row, column = np.nonzero(np.isfinite(at))
                rays.append(block[row])
                distances.append(at[row, column])
                cosines.append(across[row, column])
        ray = np.concatenate(rays)
        distance, cosine = np.concatenate(distances), np.concatenate(cosines)
        inside = np.zeros(len(origins))
        for number in np.unique(ray).tolist():
            is_own = ray == number
            inside[number] = _union_m(distance[is_own], cosine[is_own], float(lengths[number]))
        return inside

    def first_hit_m(self, origin: FloatArray, direction: FloatArray, length: FloatArray) -> float:
        """Return the distance along one ray to the surface, metres; infinite if it misses it.

        Parameters
        ----------
        origin, direction : (1, 3)
            Start of the ray and its unit direction.
        length : (1,)
            Length of the ray.
        """
        found = np.inf
        reached = boxes_reached(self.lows, self.highs, origin, direction, length)
        for index in np.flatnonzero(reached.any(axis=1)).tolist():
            at, _ = crossings(self.clusters[index], origin, direction)
            is_ahead = (at >= 0.0) & (at <= length[:, None])
            found = min(found, float(at[is_ahead].min(initial=np.inf)))
        return float(found)

    def touches(self, place: FloatArray, radius_m: float) -> bool:
        """Return whether a ball about `place` (3,) touches the surface."""
        gaps = np.maximum(np.maximum(self.lows - place, place - self.highs), 0.0)
        near = np.flatnonzero((gaps**2).sum(axis=1) < radius_m**2)
        return any(_gap_m(self.clusters[index], place) < radius_m for index in near)


def blocks(rays: IndexArray) -> Iterator[IndexArray]:
    """Yield the rays in blocks for which the pairs with a cluster's triangles fit in memory."""
    for start in range(0, len(rays), _BLOCK // _CLUSTER_SIZE):
        yield rays[start : start + _BLOCK // _CLUSTER_SIZE]


def crossings(
    cluster: Cluster, origins: FloatArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where n rays cross the m triangles of a cluster (Möller and Trumbore 1997).

    Returns
    -------
    (n, m)
        Distance along the ray, infinite where it misses the triangle; may be negative.
    (n, m)
        A number above 0 where the ray leaves the solid there, below 0 where it enters.
    """
    first, one, two = cluster.edges
    way = directions[:, None]
    across = np.cross(way, two[None])
    scale = np.einsum('rtk,tk->rt', across, one)
    safe = np.where(np.abs(scale) < GRAZING, np.inf, scale)
    offset = origins[:, None] - first
    u = np.einsum('rtk,rtk->rt', offset, across) / safe
    other = np.cross(offset, one)
    v = np.einsum('rk,rtk->rt', directions, other) / safe
    distance = np.einsum('rtk,tk->rt', other, two) / safe
    is_hit = (np.abs(scale) >= GRAZING) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    return np.where(is_hit, distance, np.inf), directions @ np.cross(one, two).T


def _cluster(corners: NDArray[np.floating]) -> Cluster:
    flat = corners.reshape(-1, 3)
    return Cluster(flat.min(axis=0), flat.max(axis=0), corners)


def _clusters(corners: NDArray[np.floating]) -> Iterator[Cluster]:
    """Yield the triangles in halves of halves, each cut across its longest side."""
    if len(corners) <= _CLUSTER_SIZE:
        yield _cluster(corners)
        return
    middles = corners.mean(axis=1)
    axis = int(np.ptp(middles, axis=0).argmax())
    order = np.argpartition(middles[:, axis], len(corners) // 2)
    yield from _clusters(corners[order[: len(corners) // 2]])
    yield from _clusters(corners[order[len(corners) // 2 :]])


def _union_m(distances: FloatArray, cosines: FloatArray, length: float) -> float:
    """Return how much of 0 to `length` is within at least one part, from its crossings."""
    order = np.argsort(distances)
    at = np.clip(distances[order], 0.0, length)
    depth = np.cumsum(np.where(cosines[order] < 0.0, 1, -1))
    # A start within a part shows as one exit too many.
    depth -= min(0, int(depth.min(initial=0)))
    return float(np.sum(np.diff(np.append(at, length)) * (depth > 0)))


def _gap_m(cluster: Cluster, place: FloatArray) -> float:
    """Return the distance from `place` (3,) to the nearest triangle (Ericson 2005, 5.1.5)."""
    first, one, two = cluster.edges
    offset = np.asarray(place, float) - first
    aa, ab, bb = (np.einsum('tk,tk->t', x, y) for x, y in ((one, one), (one, two), (two, two)))
    pa, pb = np.einsum('tk,tk->t', offset, one), np.einsum('tk,tk->t', offset, two)
    area = np.maximum(aa * bb - ab * ab, GRAZING)
    u, v = (bb * pa - ab * pb) / area, (aa * pb - ab * pa) / area
    is_over = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    plane = np.linalg.norm(offset - u[:, None] * one - v[:, None] * two, axis=1)
    sides = [
        _segment_gaps(first, one, place),
        _segment_gaps(first, two, place),
        _segment_gaps(first + one, two - one, place),
    ]
    return float(np.where(is_over, plane, np.min(sides, axis=0)).min())


def _segment_gaps(start: FloatArray, way: FloatArray, place: FloatArray) -> FloatArray:
    """Return the distance from `place` (3,) to each of m segments, (m,)."""
    offset = place - start
    length = np.maximum(np.einsum('tk,tk->t', way, way), GRAZING)
    share = np.clip(np.einsum('tk,tk->t', offset, way) / length, 0.0, 1.0)
    return np.asarray(np.linalg.norm(offset - share[:, None] * way, axis=1))
