# SPDX-License-Identifier: Apache-2.0
"""Legs around the columns in which other vehicles climb and come down.

With a layer reserved for each vehicle, legs of different vehicles never meet, whatever plans they
follow. Climbs and descents pass the layers below, each in a column of air over a home, or over
the place where a route ends. Legs of other vehicles lead around it, as around an exclusion, so
that it does not matter when somebody lands. The same holds for vehicles in no plan, which land by
themselves. A column is open if another vehicle must fly to a place in it: there only times keep
vehicles apart, as where a vehicle lands at its last viewpoint.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_planner.errors import NoWayError
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.problem.airspace import MAX_SITES, Airspace
from rocsafe_planner.problem.detours import Detours, Door

MAX_CHECKS = 1e8
"""Pairs of sites times sides of columns that are looked at: about a second."""
_SIDES_A_QUARTER = 4
_MARGIN_M = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Column:
    """A column of air in which one vehicle climbs and descends.

    Attributes
    ----------
    place : (2,)
        Its middle, east and north, metres.
    own
        Numbers of the vehicle's own sites inside: legs from and to these may cross its edge.
    """

    place: FloatArray
    own: frozenset[int] = frozenset()


def detours_of(
    request: SurveyRequest,
    sites: FloatArray,
    airspace: Airspace | None,
    columns: Sequence[Column],
) -> Detours | None:
    """Return the ways among sites around exclusions and columns; None: all are straight."""
    kept = _kept(request, sites, airspace, columns)
    if kept:
        zones = {column: _zone(column, request.separation.distance_m) for column in kept}
        closed = [] if airspace is None else list(shapely.get_parts(airspace.closed))
        doors = [Door(site=k, zone=zones[column]) for column in kept for k in column.own]
        crossed = [
            one
            for k, one in zones.items()
            if any(k is not other and one.intersects(zone) for other, zone in zones.items())
        ]
        try:
            return Airspace([*closed, *zones.values()], 0.0, sites).detours(sites, doors, crossed)
        except NoWayError:
            pass  # the columns shut somebody in
    return None if airspace is None else airspace.detours(sites)


def columns_of(request: SurveyRequest, frame: LocalFrame, points: int) -> list[Column]:
    """Return the columns of a request whose sites are its points, and starts, ends and homes."""
    unheard = frame.plane_of([one.home for one in request.continuation.unheard])
    columns = [Column(place=place) for place in unheard]
    if request.separation.by != 'reserved':
        return columns
    count = len(request.vehicles)
    for k, vehicle in enumerate(request.vehicles):
        own = frozenset(points + group * count + k for group in range(3))
        landings = frame.plane_of(vehicle.landings)
        columns += [Column(place=place, own=own) for place in landings]
    return columns


def _kept(
    request: SurveyRequest,
    sites: FloatArray,
    airspace: Airspace | None,
    columns: Sequence[Column],
) -> list[Column]:
    """Return the columns into which nobody else must fly, and that no exclusion overlaps."""
    separation_m = request.separation.distance_m
    checks = len(sites) ** 2 * len(columns) * 4 * _SIDES_A_QUARTER
    if not separation_m or checks > MAX_CHECKS or len(sites) > MAX_SITES:
        return []
    closed = shapely.union_all([]) if airspace is None else airspace.closed
    kept = []
    for column in columns:
        near = np.hypot(*(sites - column.place).T) <= _radius_m(separation_m) + _MARGIN_M
        inside = set(np.flatnonzero(near).tolist())
        is_free = not shapely.intersects(_zone(column, separation_m), closed)
        if inside <= column.own and is_free:
            kept.append(Column(place=column.place, own=frozenset(inside)))
    return kept


def _radius_m(separation_m: float) -> float:
    """Return how far out the corners lie whose sides are the separation away."""
    return separation_m / math.cos(0.25 * math.pi / _SIDES_A_QUARTER)


def _zone(column: Column, separation_m: float) -> shapely.Polygon:
    middle = shapely.Point(column.place)
    zone: shapely.Polygon = middle.buffer(_radius_m(separation_m), quad_segs=_SIDES_A_QUARTER)
    return zone
