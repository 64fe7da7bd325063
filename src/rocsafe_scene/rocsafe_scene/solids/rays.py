# SPDX-License-Identifier: Apache-2.0
"""Straight lines through a scene: what they hit, what they pass, how high they run.

For the radiation core (materials between source and detector), for vehicles (height above ground,
collision) and for the ground truth of cameras. Everything is in metres about the mission origin.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.environment import GROUND_NUMBER, Environment, SceneObject
from rocsafe_scene.solids.ray_boxes import GRAZING, boxes_reached

# Pairs of ray and triangle worked on at once.
_BLOCK = 400_000
_CLUSTER_SIZE = 64
# The ground is sought in steps that grow with the distance, then halved to a hair.
_FIRST_STEP_M, _STEP_GROWTH, _HALVINGS = 0.35, 1.015, 34


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """Of rays (n,): where each first meets something.

    Attributes
    ----------
    distances_m : along the ray; infinite if nothing is met.
    numbers : of the instance met; 0 if nothing is met.
    """

    distances_m: Floats
    numbers: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Triangles close together, and the box around them."""

    low: Floats
    high: Floats
    corners: Floats

    @property
    def edges(self) -> tuple[Floats, Floats, Floats]:
        """First corner and the two edges from it, each (m, 3)."""
        first = self.corners[:, 0].astype(float)
        return first, self.corners[:, 1] - first, self.corners[:, 2] - first

    def reached(self, origins: Floats, directions: Floats, limits: Floats) -> Floats:
        """Return the indices of the rays that enter the box within their limits."""
        return np.flatnonzero(
            boxes_reached(self.low[None], self.high[None], origins, directions, limits)[0]
        )


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A thing as triangles in the world: all of them, and in clusters."""

    thing: SceneObject
    whole: Cluster
    clusters: list[Cluster]
    lows: Floats = field(init=False)
    highs: Floats = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, 'lows', np.array([one.low for one in self.clusters]))
        object.__setattr__(self, 'highs', np.array([one.high for one in self.clusters]))


@dataclass(slots=True)
class RayScene:
    """A scene as rays see it: what stands in it at the start of the mission."""

    environment: Environment
    _solids: list[Solid] = field(init=False)

    def __post_init__(self) -> None:
        self._solids = [solid_of(thing) for thing in self.environment.objects]

    def first_hits(self, origins: Floats, directions: Floats) -> Hits:
        """Return what rays from `origins` (n, 3) in unit `directions` (n, 3) meet first."""
        found = self._ground(origins, directions)
        numbers = np.where(np.isfinite(found), GROUND_NUMBER, 0)
        for solid, rays in self._near(origins, directions, found):
            distance = _nearest(solid, origins[rays], directions[rays])
            is_nearer = distance < found[rays]
            found[rays[is_nearer]] = distance[is_nearer]
            numbers[rays[is_nearer]] = solid.thing.number
        return Hits(found, numbers)

    def is_clear(self, start: Floats, end: Floats) -> bool:
        """Return whether nothing stands between two places, (3,) each."""
        way = np.asarray(end, float) - start
        length = float(np.linalg.norm(way))
        if length < GRAZING:
            return True
        hits = self.first_hits(np.asarray(start, float)[None], way[None] / length)
        return bool(hits.distances_m[0] >= length - 1e-6)

    def lengths_m(self, start: Floats, ends: Floats) -> Mapping[str, Floats]:
        """Return by material the length of the lines from `start` (3,) to `ends` (n, 3) in it.

        A thing counts by the share of its volume that its material fills.
        """
        ways = np.asarray(ends, float) - np.asarray(start, float)
        lengths = np.linalg.norm(ways, axis=1)
        directions = ways / np.maximum(lengths, GRAZING)[:, None]
        origins = np.broadcast_to(np.asarray(start, float), ways.shape)
        totals: dict[str, Floats] = {}
        for solid, rays in self._near(origins, directions, lengths.copy()):
            inside = inside_m(solid, origins[rays], directions[rays], lengths[rays])
            if inside.any():
                total = totals.setdefault(solid.thing.material, np.zeros(len(ways)))
                total[rays] += solid.thing.fill * inside
        return totals

    def height_above_ground(self, places: Floats) -> Floats:
        """Return how high `places` (n, 3) lie above the ground below them."""
        return np.asarray(places[:, 2] - self.environment.terrain.height_at(places[:, :2]))

    def collision(self, place: Floats, radius_m: float) -> str:
        """Return the name of what a ball about `place` (3,) touches: '' nothing, or 'ground'."""
        if float(self.height_above_ground(np.asarray(place)[None])[0]) < radius_m:
            return 'ground'
        for solid in self._solids:
            if touches(solid, np.asarray(place, float), radius_m):
                return solid.thing.name
        return ''

    def _near(
        self, origins: Floats, directions: Floats, limits: Floats
    ) -> Iterator[tuple[Solid, Floats]]:
        """Yield each solid with the indices of the rays that may meet it within `limits`."""
        for solid in self._solids:
            rays = solid.whole.reached(origins, directions, limits)
            if len(rays):
                yield solid, rays

    def _ground(self, origins: Floats, directions: Floats) -> Floats:
        terrain = self.environment.terrain

        def above(rays: Floats, distance: Floats) -> Floats:
            places = origins[rays] + directions[rays] * distance[:, None]
            return np.asarray(places[:, 2] - terrain.height_at(places[:, :2]))

        low = np.zeros(len(origins))
        high = np.full(len(origins), np.inf)
        searching: Floats = np.arange(len(origins))
        reach, step = 0.0, _FIRST_STEP_M
        while len(searching) and reach < 6000.0:
            reach, step = reach + step, step * _STEP_GROWTH
            is_below = above(searching, np.full(len(searching), reach)) <= 0.0
            high[searching[is_below]] = reach
            low[searching] = np.where(is_below, reach - step / _STEP_GROWTH, reach)
            searching = searching[~is_below]
        rays = np.flatnonzero(np.isfinite(high))
        for _ in range(_HALVINGS):
            middle = 0.5 * (low[rays] + high[rays])
            is_below = above(rays, middle) <= 0.0
            high[rays[is_below]], low[rays[~is_below]] = middle[is_below], middle[~is_below]
        return high


def solid_of(thing: SceneObject) -> Solid:
    """Return a thing as rays see it, where it is at the start of the mission."""
    corners = np.concatenate(
        [piece.points()[piece.mesh.triangles] for piece in thing.pieces]
    ).astype(np.float32)
    if thing.path is not None:
        corners = corners + thing.path.places[0].astype(np.float32)
    return Solid(thing, _cluster(corners), list(_clusters(corners)))


def _cluster(corners: Floats) -> Cluster:
    flat = corners.reshape(-1, 3)
    return Cluster(flat.min(axis=0), flat.max(axis=0), corners)


def _clusters(corners: Floats) -> Iterator[Cluster]:
    """Yield the triangles in halves of halves, each cut across its longest side."""
    if len(corners) <= _CLUSTER_SIZE:
        yield _cluster(corners)
        return
    middles = corners.mean(axis=1)
    axis = int(np.ptp(middles, axis=0).argmax())
    order = np.argpartition(middles[:, axis], len(corners) // 2)
    yield from _clusters(corners[order[: len(corners) // 2]])
    yield from _clusters(corners[order[len(corners) // 2 :]])


def _crossings(cluster: Cluster, origins: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """Return the distances (n, m) of rays to triangles, and the cosines of the crossings.

    By Möller and Trumbore (1997); distances are infinite where a ray misses, cosines are above 0
    where it leaves the solid.
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


def _nearest(solid: Solid, origins: Floats, directions: Floats) -> Floats:
    """Return the distance to the first triangle in front whose outside a ray meets."""
    found = np.full(len(origins), np.inf)
    for cluster in solid.clusters:
        rays = cluster.reached(origins, directions, found)
        for block in _blocks(rays):
            distance, cosine = _crossings(cluster, origins[block], directions[block])
            is_seen = (distance > 0.0) & (solid.thing.is_foliage | (cosine < 0.0))
            nearest = np.where(is_seen, distance, np.inf).min(axis=1)
            found[block] = np.minimum(found[block], nearest)
    return found


def _blocks(rays: Floats) -> Iterator[Floats]:
    for start in range(0, len(rays), _BLOCK // _CLUSTER_SIZE):
        yield rays[start : start + _BLOCK // _CLUSTER_SIZE]


def inside_m(solid: Solid, origins: Floats, directions: Floats, lengths: Floats) -> Floats:
    """Return the length of each ray inside the union of the solid's closed parts."""
    who: list[Floats] = [np.zeros(0, int)]
    where: list[Floats] = [np.zeros(0)]
    which: list[Floats] = [np.zeros(0)]
    reached = boxes_reached(solid.lows, solid.highs, origins, directions, lengths)
    for index in np.flatnonzero(reached.any(axis=1)):
        for block in _blocks(np.flatnonzero(reached[index])):
            distance, cosine = _crossings(solid.clusters[index], origins[block], directions[block])
            row, column = np.nonzero(np.isfinite(distance))
            who.append(block[row])
            where.append(distance[row, column])
            which.append(cosine[row, column])
    ray, distance, cosine = (np.concatenate(parts) for parts in (who, where, which))
    inside = np.zeros(len(origins))
    for number in np.unique(ray).tolist():
        is_own = ray == number
        inside[number] = _union_m(distance[is_own], cosine[is_own], float(lengths[number]))
    return inside


def _union_m(distances: Floats, cosines: Floats, length: float) -> float:
    """Return how much of 0 to `length` is within at least one part, from its crossings."""
    order = np.argsort(distances)
    at = np.clip(distances[order], 0.0, length)
    depth = np.cumsum(np.where(cosines[order] < 0.0, 1, -1))
    # A start within a part shows as one exit too many.
    depth -= min(0, int(depth.min(initial=0)))
    return float(np.sum(np.diff(np.append(at, length)) * (depth > 0)))


def touches(solid: Solid, place: Floats, radius_m: float) -> bool:
    """Return whether a ball about `place` (3,) touches the surface of a solid."""
    for cluster in (solid.whole, *solid.clusters):
        gap = np.maximum(np.maximum(cluster.low - place, place - cluster.high), 0.0)
        is_near = bool(np.linalg.norm(gap) < radius_m)
        if cluster is solid.whole and not is_near:
            return False
        if cluster is not solid.whole and is_near and _gap_m(cluster, place) < radius_m:
            return True
    return False


def _gap_m(cluster: Cluster, place: Floats) -> float:
    """Return the distance from `place` (3,) to the nearest triangle (Ericson 2005, 5.1.5)."""
    first, one, two = cluster.edges
    offset = np.asarray(place, float) - first
    aa, ab, bb = (np.einsum('tk,tk->t', x, y) for x, y in ((one, one), (one, two), (two, two)))
    pa, pb = np.einsum('tk,tk->t', offset, one), np.einsum('tk,tk->t', offset, two)
    area = np.maximum(aa * bb - ab * ab, GRAZING)
    u, v = (bb * pa - ab * pb) / area, (aa * pb - ab * pa) / area
    is_over = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    plane = np.linalg.norm(offset - u[:, None] * one - v[:, None] * two, axis=1)
    sides = [_segment_gaps(first, one, place), _segment_gaps(first, two, place),
             _segment_gaps(first + one, two - one, place)]  # fmt: skip
    return float(np.where(is_over, plane, np.min(sides, axis=0)).min())


def _segment_gaps(start: Floats, way: Floats, place: Floats) -> Floats:
    offset = place - start
    length = np.maximum(np.einsum('tk,tk->t', way, way), GRAZING)
    share = np.clip(np.einsum('tk,tk->t', offset, way) / length, 0.0, 1.0)
    return np.asarray(np.linalg.norm(offset - share[:, None] * way, axis=1))
