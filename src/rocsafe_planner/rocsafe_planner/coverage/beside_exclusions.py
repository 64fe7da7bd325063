# SPDX-License-Identifier: Apache-2.0
"""Viewpoints beside exclusions, for ground that only viewpoints inside them would show.

Ground outside an exclusion, or within the clearance of one, is seen from a place outside if the
footprint about that place reaches it. Of places along the edges of the exclusions, the one that
shows most unseen ground is added each time. What such places miss is photographed from as near as
may be, until nothing is left that can be seen from outside.
"""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_planner.coverage.sight import accessible, unseen
from rocsafe_planner.errors import NoWayError
from rocsafe_planner.problem.airspace import Airspace

_LEAST_PART_M2 = 0.01
"""Smaller unseen parts get no viewpoint."""
_STEP = 0.25
"""Distance of the places that are tried, in shorter sides of a footprint."""
_HAIR = 1.0 - 1e-6
"""Share of a footprint that is used, so that rounding leaves no ground at its edge."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Views:
    """Viewpoints in the plane, as those of `Coverage`."""

    centres: FloatArray
    yaw_rad: FloatArray
    footprints: FloatArray
    polygon: IndexArray

    def chosen(self, which: IndexArray) -> 'Views':
        """Return some of the viewpoints."""
        return Views(
            centres=self.centres[which],
            yaw_rad=self.yaw_rad[which],
            footprints=self.footprints[which],
            polygon=self.polygon[which],
        )


def with_views_beside(
    grid: Views, polygons: Sequence[shapely.Polygon], airspace: Airspace
) -> Views:
    """Return the viewpoints outside exclusions, and those added beside the exclusions.

    Raises
    ------
    NoWayError
        If no viewpoint of the grid lies outside.
    """
    is_free = airspace.holds(grid.centres)
    if not is_free.any():
        raise NoWayError('exclusions leave no viewpoint: all of them lie inside')
    kept, dropped = (grid.chosen(np.flatnonzero(which)) for which in (is_free, ~is_free))
    if not len(dropped.centres):
        return kept
    ground = accessible(shapely.union_all(polygons), airspace.zones)
    missing = unseen(ground, kept.footprints)
    beside = _views_beside(missing, dropped, airspace.shut)
    views = [kept, *_needed(beside, missing)]
    return Views(
        centres=np.vstack([view.centres for view in views]),
        yaw_rad=np.concatenate([view.yaw_rad for view in views]),
        footprints=np.vstack([view.footprints for view in views]),
        polygon=np.concatenate([view.polygon for view in views]),
    )


def _views_beside(
    missing: shapely.Geometry, dropped: Views, shut: shapely.Geometry
) -> list[Views]:
    """Return viewpoints outside that show missing ground, one each.

    Each takes the direction of the dropped viewpoint that is nearest to it.
    """
    side = np.linalg.norm(np.diff(dropped.footprints[0, :3], axis=0), axis=1).min()
    edge = shapely.segmentize(shapely.boundary(shut), _STEP * float(side))
    tried = _moved(dropped, shapely.get_coordinates(edge))
    views, missing = _showing_most(missing, tried)
    parts = list(shapely.get_parts(missing))
    while parts and len(views) < len(tried.centres):
        part = max(parts, key=shapely.area)
        parts.remove(part)
        if part.area < _LEAST_PART_M2:
            break
        view = _view_of(part, dropped, shut)
        if view is None:
            continue  # nothing of it is seen from any place outside
        views.append(view)
        parts = [
            piece
            for one in (*parts, part)
            for piece in shapely.get_parts(
                shapely.difference(one, shapely.Polygon(view.footprints[0]))
            )
        ]
    return views


def _showing_most(missing: shapely.Geometry, tried: Views) -> tuple[list[Views], shapely.Geometry]:
    """Return the viewpoints that show most of the missing ground, and what they leave.

    The ground that a viewpoint adds never grows, so that few viewpoints are evaluated again in
    each round (Minoux, 1978).
    """
    boxes = shapely.polygons(tried.footprints)
    near, part = shapely.STRtree(shapely.get_parts(missing)).query(boxes, 'intersects')
    shown = shapely.area(shapely.intersection(boxes[near], shapely.get_parts(missing)[part]))
    gains = np.bincount(near, shown, len(boxes))
    queue = [(-gain, k) for k, gain in enumerate(gains.tolist()) if gain >= _LEAST_PART_M2]
    heapq.heapify(queue)
    views: list[Views] = []
    while queue:
        _, k = queue[0]
        gain = float(shapely.area(shapely.intersection(boxes[k], missing)))
        heapq.heapreplace(queue, (-gain, k))
        if queue[0][1] != k:
            continue
        heapq.heappop(queue)
        if gain < _LEAST_PART_M2:
            break
        views.append(tried.chosen(np.array([k])))
        missing = shapely.difference(missing, boxes[k])
    return views, missing


def _needed(views: list[Views], missing: shapely.Geometry) -> list[Views]:
    """Return the viewpoints without those that show no more than the others together."""
    boxes = [shapely.Polygon(view.footprints[0]) for view in views]
    kept = dict(enumerate(boxes))
    for k, box in enumerate(boxes):
        others = [other for i, other in kept.items() if i != k and other.intersects(box)]
        alone = shapely.difference(shapely.intersection(missing, box), shapely.union_all(others))
        if alone.area < _LEAST_PART_M2:
            del kept[k]
    return [views[k] for k in kept]


def _moved(views: Views, places: FloatArray) -> Views:
    """Return viewpoints at places, each like the one that is nearest."""
    nearest = shapely.STRtree(shapely.points(views.centres)).nearest(shapely.points(places))
    like = views.chosen(nearest)
    return Views(
        centres=places,
        yaw_rad=like.yaw_rad,
        footprints=like.footprints + (places - like.centres)[:, None],
        polygon=like.polygon,
    )


def _view_of(part: shapely.Polygon, dropped: Views, shut: shapely.Geometry) -> Views | None:
    """Return the nearest viewpoint outside from which some of a part is seen."""
    near = shapely.get_coordinates(part.representative_point())[0]
    source = int(np.argmin(((dropped.centres - near) ** 2).sum(axis=1)))
    frame = dropped.footprints[source] - dropped.centres[source]
    seen_from = shapely.intersection(part, _visible(shut, frame))
    spots = [p for p in shapely.get_parts(seen_from) if p.area >= _LEAST_PART_M2]
    if not spots:
        return None
    spot = max(spots, key=shapely.area).representative_point()
    like = dropped.chosen(np.array([source]))
    place = _nearest_place(spot, frame, shut)
    return Views(
        centres=place[None],
        yaw_rad=like.yaw_rad,
        footprints=(place + frame)[None],
        polygon=like.polygon,
    )


def _visible(shut: shapely.Geometry, frame: FloatArray) -> shapely.Geometry:
    """Return the ground that is seen from outside: all but what is too deep inside.

    A footprint, (4, 2) about its centre, moves along the edges of what is shut; it is symmetric,
    so what it sweeps is what is seen from somewhere on the edge.
    """
    swept = []
    for ring in shapely.get_rings(shapely.get_parts(shut)):
        corners = shapely.get_coordinates(ring)
        boxes = corners[:, None] + _HAIR * frame
        pairs = np.concatenate([boxes[:-1], boxes[1:]], axis=1)
        swept.extend(shapely.convex_hull(shapely.multipoints(list(pairs))))
    around = shapely.box(*shapely.buffer(shut, 2.0 * float(np.abs(frame).max())).bounds)
    return shapely.union_all([*swept, shapely.difference(around, shut)])


def _nearest_place(spot: shapely.Point, frame: FloatArray, shut: shapely.Geometry) -> FloatArray:
    """Return the nearest place outside from which a spot is seen."""
    around = shapely.Polygon(np.asarray(spot.coords)[0] + frame)
    free = shapely.difference(around, shut)
    nearest: FloatArray = shapely.get_coordinates(shapely.shortest_line(spot, free))[-1]
    return nearest
