# SPDX-License-Identifier: Apache-2.0
"""Viewpoints beside exclusions, for ground that only viewpoints inside them would show.

Ground outside an exclusion, or within the clearance of one, is seen from a place outside if the
footprint about that place reaches it. Places are added where the largest unseen part is, each as
near to that part as it may be, until nothing is left that can be seen from outside.
"""

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
_MOST_A_DROPPED = 6
"""Most viewpoints that are added for each one in an exclusion."""
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
    sources, places = _places_beside(missing, dropped, airspace.shut())
    moved = dropped.chosen(np.array(sources, dtype=np.intp))
    shift = np.reshape(places, (-1, 2)) - moved.centres
    return Views(
        centres=np.vstack([kept.centres, moved.centres + shift]),
        yaw_rad=np.concatenate([kept.yaw_rad, moved.yaw_rad]),
        footprints=np.vstack([kept.footprints, moved.footprints + shift[:, None]]),
        polygon=np.concatenate([kept.polygon, moved.polygon]),
    )


def _places_beside(
    missing: shapely.Geometry, dropped: Views, shut: shapely.Geometry
) -> tuple[list[int], list[FloatArray]]:
    """Return places from which missing ground is seen, and the dropped viewpoint of each.

    A place takes the direction of the dropped viewpoint that is nearest to the missing ground.
    """
    sources: list[int] = []
    places: list[FloatArray] = []
    parts = list(shapely.get_parts(missing))
    while parts and len(places) < _MOST_A_DROPPED * len(dropped.centres):
        part = max(parts, key=shapely.area)
        parts.remove(part)
        if part.area < _LEAST_PART_M2:
            break
        near = np.asarray(part.representative_point().coords)[0]
        source = int(np.argmin(((dropped.centres - near) ** 2).sum(axis=1)))
        frame = dropped.footprints[source] - dropped.centres[source]
        seen_from = shapely.intersection(part, _visible(shut, frame))
        spots = [p for p in shapely.get_parts(seen_from) if p.area >= _LEAST_PART_M2]
        if not spots:
            continue  # nothing of it is seen from any place outside
        spot = max(spots, key=shapely.area).representative_point()
        place = _nearest_place(spot, frame, shut)
        footprint = shapely.Polygon(place + frame)
        sources.append(source)
        places.append(place)
        parts = [
            piece
            for one in (*parts, part)
            for piece in shapely.get_parts(shapely.difference(one, footprint))
        ]
    return sources, places


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
    """Return the place outside from which a spot is seen that is nearest to it."""
    around = shapely.Polygon(np.asarray(spot.coords)[0] + frame)
    free = shapely.difference(around, shut)
    nearest: FloatArray = shapely.get_coordinates(shapely.shortest_line(spot, free))[-1]
    return nearest
