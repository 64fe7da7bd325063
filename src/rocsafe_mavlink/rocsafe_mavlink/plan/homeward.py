# SPDX-License-Identifier: Apache-2.0
"""The return path of a vehicle that gives up its route; it must not cross an exclusion.

A vehicle that returns by itself flies straight home, or to a rally point, from wherever it is.
From one leg of its route it may therefore fly over any place of the triangle of that leg and the
place of its return.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from shapely.geometry import MultiPoint, Point, Polygon

from rocsafe_geo.detour import LEG_SLACK_M, WaysAround, zone_on_way
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.plan.fence import Fence, Ring
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint

# A leg is looked at in pieces where the place of the return depends on where the vehicle is.
PIECE_M = 10.0
Place = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class ReturnPlaces:
    """Place to which a vehicle returns by itself.

    Attributes
    ----------
    home
        Where it took off.
    rally
        Rally points: it flies to the nearest, or home.
    limit_m
        Rally points further away are not used; 0: all are.
    includes_home
        Whether it flies home where that is nearer than any rally point.
    """

    home: GeoPosition
    rally: tuple[GeoPosition, ...] = ()
    limit_m: float = 0.0
    includes_home: bool = True


@lru_cache(maxsize=64)
def return_fault(plan: FlightPlan, places: ReturnPlaces) -> str:
    """Return which exclusion lies on a straight way home, and from which leg; empty if none."""
    plane = _Plane(places.home)
    zones = [Polygon([plane.of(corner) for corner in ring]) for ring in plan.exclusions]
    way = [places.home, *(waypoint.position for waypoint in plan.waypoints), places.home]
    for leg, (start, end) in enumerate(pairwise(map(plane.of, way)), start=1):
        for piece, goal in _returns(start, end, places, plane):
            area = MultiPoint([*piece, goal]).convex_hull
            for number, zone in enumerate(zones, start=1):
                if zone.distance(area) < max(plan.clearance_m - LEG_SLACK_M, 1e-6):
                    return f'exclusion {number} lies between leg {leg} and the place of its return'
    return ''


def homeward_plan(plan: FlightPlan, here: FlightWaypoint, home: GeoPosition) -> FlightPlan | None:
    """Return the way from `here` around the exclusions; None if the straight one is free.

    It is flown at the height of `here` and ends above home, where the return begins.
    """
    if not plan.exclusions:
        return None
    plane = _Plane(home)
    zones = [tuple(plane.of(corner) for corner in ring) for ring in plan.exclusions]
    bends = WaysAround(zones, plan.clearance_m, (0.0, 0.0)).bends(plane.of(here.position))
    if not bends:
        return None
    stops = [plane.back(bend) for bend in bends] + [home]
    return FlightPlan(
        waypoints=tuple(
            FlightWaypoint(
                position=GeoPosition(place.latitude_deg, place.longitude_deg, 0.0),
                height_m=here.height_m,
                heading_deg=here.heading_deg,
            )
            for place in stops
        ),
        speed_mps=plan.speed_mps,
        exclusions=plan.exclusions,
        clearance_m=plan.clearance_m,
    )


def zone_at(plan: FlightPlan, place: GeoPosition) -> int:
    """Return the number of the exclusion in which a place lies; 0: in none."""
    plane = _Plane(place)
    zones = enumerate(plan.exclusions, start=1)
    found = (
        number
        for number, ring in zones
        if Polygon([plane.of(corner) for corner in ring]).intersects(Point(0.0, 0.0))
    )
    return next(found, 0)


def way_fault(plan: FlightPlan, way: Sequence[GeoPosition]) -> str:
    """Return which exclusion of `plan` a way comes too near to, and on which leg; empty if none.

    The rule is `zone_on_way`.
    """
    plane = _Plane(way[-1])
    zones = [tuple(plane.of(corner) for corner in ring) for ring in plan.exclusions]
    fault = zone_on_way(zones, plan.clearance_m, [plane.of(place) for place in way])
    if fault is None:
        return ''
    leg, zone = fault
    return f'exclusion {zone} lies on ' + ('the way' if len(way) == 2 else f'leg {leg} of the way')


def holds_exclusions(fence: Fence, exclusions: Sequence[Ring]) -> bool:
    """Whether the polygons that a fence excludes cover all of `exclusions`."""
    fenced = [
        Polygon([(c.longitude_deg, c.latitude_deg) for c in ring]) for ring in fence.exclusions
    ]
    # A corner is stored in 1e-7 degrees.
    wide = [zone.buffer(2e-7) for zone in fenced]
    shapes = [Polygon([(c.longitude_deg, c.latitude_deg) for c in ring]) for ring in exclusions]
    return all(any(zone.covers(shape) for zone in wide) for shape in shapes)


class _Plane:
    """Metres east and north of a place."""

    def __init__(self, origin: GeoPosition) -> None:
        self._frame = LocalFrame(GeoPosition(origin.latitude_deg, origin.longitude_deg, 0.0))

    def of(self, place: GeoPosition) -> Place:
        """Return a place in the plane."""
        level = GeoPosition(place.latitude_deg, place.longitude_deg, 0.0)
        east, north, _ = self._frame.enu_of(level).tolist()
        return east, north

    def back(self, place: Place) -> GeoPosition:
        """Return a place of the plane on the Earth."""
        return self._frame.position_of((*place, 0.0))


def _returns(
    start: Place, end: Place, places: ReturnPlaces, plane: _Plane
) -> Iterator[tuple[tuple[Place, Place], Place]]:
    """Yield the pieces of a leg, each with each place to which the vehicle may return from it."""
    home, rally = plane.of(places.home), [plane.of(point) for point in places.rally]
    if not rally:
        yield (start, end), home
        return
    count = max(1, math.ceil(math.dist(start, end) / PIECE_M))
    shares = [number / count for number in range(count + 1)]
    dots = [
        (start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1]))
        for share in shares
    ]
    for piece in pairwise(dots):
        for goal in _goals(piece[0], home, rally, places):
            yield piece, goal


def _goals(place: Place, home: Place, rally: Sequence[Place], places: ReturnPlaces) -> list[Place]:
    """Return the places to which it may return from within `PIECE_M` of a place."""
    nearest_m = min(math.dist(place, point) for point in rally)
    is_far = places.limit_m > 0.0 and nearest_m > places.limit_m - PIECE_M
    near = [point for point in rally if math.dist(place, point) < nearest_m + 2.0 * PIECE_M]
    is_home_near = math.dist(place, home) < nearest_m + 2.0 * PIECE_M
    return [*near, home] if is_far or (places.includes_home and is_home_near) else near
