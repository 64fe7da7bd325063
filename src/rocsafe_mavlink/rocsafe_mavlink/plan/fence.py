# SPDX-License-Identifier: Apache-2.0
"""Fences and rally points as items: they are transferred like a mission, with own types."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from shapely.geometry import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from rocsafe_geo.limits import require_positive
from rocsafe_geo.position import GeoPosition, level_offset_m
from rocsafe_mavlink.protocols.mission_item import GLOBAL, GLOBAL_RELATIVE, MissionItem
from rocsafe_mavlink.wire.units import deg_of_e7, e7_of_deg

RETURN_POINT, INCLUSION_VERTEX, EXCLUSION_VERTEX = 5000, 5001, 5002
INCLUSION_CIRCLE, EXCLUSION_CIRCLE, RALLY_POINT = 5003, 5004, 5100
LARGEST_CORNER_COUNT = 80
Ring = tuple[GeoPosition, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Circle:
    """A circle of a fence; its radius is in metres."""

    center: GeoPosition
    radius_m: float

    def __post_init__(self) -> None:
        require_positive('radius_m', self.radius_m, 'm')

    def covers(self, *way: GeoPosition) -> bool:
        """Whether all of a straight way is within the circle."""
        return all(
            math.hypot(*level_offset_m(self.center, place)) <= self.radius_m for place in way
        )

    def touches(self, *way: GeoPosition) -> bool:
        """Whether a part of a straight way is within the circle."""
        local = [level_offset_m(self.center, place) for place in way]
        shape = Point(local[0]) if len(local) == 1 else LineString(local)
        return bool(shape.distance(Point(0.0, 0.0)) <= self.radius_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fence:
    """Polygons and circles of a geofence.

    Attributes
    ----------
    inclusions
        The vehicle stays within each of these polygons.
    exclusions
        The vehicle stays out of each of these polygons.
    inner_circles
        The vehicle stays within each of these circles.
    outer_circles
        The vehicle stays out of each of these circles.
    """

    inclusions: tuple[Ring, ...] = ()
    exclusions: tuple[Ring, ...] = ()
    inner_circles: tuple[Circle, ...] = ()
    outer_circles: tuple[Circle, ...] = ()

    def __post_init__(self) -> None:
        for ring in (*self.inclusions, *self.exclusions):
            if len(ring) < 3 or not _polygon(ring).is_valid:
                raise ValueError(
                    f'a polygon of a fence with {len(ring)} corners: must have 3 or more, and '
                    'not cross itself'
                )

    def holds(self, place: GeoPosition) -> bool:
        """Whether a vehicle may be at `place`."""
        return self._holds(Point(*_lon_lat(place)), place)

    def holds_leg(self, start: GeoPosition, end: GeoPosition) -> bool:
        """Whether a vehicle may fly straight from `start` to `end`."""
        return self._holds(LineString([_lon_lat(start), _lon_lat(end)]), start, end)

    def _holds(self, shape: BaseGeometry, *way: GeoPosition) -> bool:
        return (
            all(_polygon(ring).covers(shape) for ring in self.inclusions)
            and all(circle.covers(*way) for circle in self.inner_circles)
            and not any(_polygon(ring).intersects(shape) for ring in self.exclusions)
            and not any(circle.touches(*way) for circle in self.outer_circles)
        )


def fence_items(fence: Fence) -> tuple[MissionItem, ...]:
    """Return the items of `fence`: each corner holds the corner count of its polygon.

    Raises
    ------
    ValueError
        If it has more corners than autopilots hold.
    """
    if sum(map(len, (*fence.inclusions, *fence.exclusions))) > LARGEST_CORNER_COUNT:
        raise ValueError(f'a fence has at most {LARGEST_CORNER_COUNT} corners in all')
    polygons = [
        _item(command, corner, float(len(ring)))
        for command, rings in (
            (INCLUSION_VERTEX, fence.inclusions),
            (EXCLUSION_VERTEX, fence.exclusions),
        )
        for ring in rings
        for corner in ring
    ]
    circles = [
        _item(command, circle.center, circle.radius_m)
        for command, found in (
            (INCLUSION_CIRCLE, fence.inner_circles),
            (EXCLUSION_CIRCLE, fence.outer_circles),
        )
        for circle in found
    ]
    return (*polygons, *circles)


def fence_of(items: Sequence[MissionItem]) -> Fence:
    """Return the fence in the items of an autopilot; a return point forbids nothing.

    Raises
    ------
    ValueError
        Saying what cannot be read, so that nobody takes the fence for another.
    """
    rings: dict[int, list[Ring]] = {INCLUSION_VERTEX: [], EXCLUSION_VERTEX: []}
    circles: dict[int, list[Circle]] = {INCLUSION_CIRCLE: [], EXCLUSION_CIRCLE: []}
    left = [item for item in items if item.command != RETURN_POINT]
    while left:
        first = left[0]
        if first.command in circles:
            circles[first.command].append(
                Circle(center=_place(first), radius_m=first.parameters[0])
            )
            left = left[1:]
            continue
        if first.command not in rings:
            raise ValueError(f'item {first.command} of a fence is not known')
        count = max(1, round(first.parameters[0]))
        ring, left = left[:count], left[count:]
        if len(ring) < count or any(_kind(corner) != _kind(first) for corner in ring):
            raise ValueError(f'a polygon of a fence has not the {count} corners that it names')
        rings[first.command].append(tuple(map(_place, ring)))
    return Fence(
        inclusions=tuple(rings[INCLUSION_VERTEX]),
        exclusions=tuple(rings[EXCLUSION_VERTEX]),
        inner_circles=tuple(circles[INCLUSION_CIRCLE]),
        outer_circles=tuple(circles[EXCLUSION_CIRCLE]),
    )


def rally_items(points: Sequence[GeoPosition], height_m: float) -> tuple[MissionItem, ...]:
    """Return the items of rally points, all `height_m` above home."""
    require_positive('height_m', height_m, 'm')
    return tuple(
        MissionItem(
            command=RALLY_POINT,
            frame=GLOBAL_RELATIVE,
            x_e7=e7_of_deg(point.latitude_deg),
            y_e7=e7_of_deg(point.longitude_deg),
            z_m=height_m,
        )
        for point in points
    )


def rally_of(items: Sequence[MissionItem]) -> tuple[GeoPosition, ...]:
    """Return the places of rally points; items that are none are left out."""
    return tuple(_place(item) for item in items if item.command == RALLY_POINT)


def _kind(item: MissionItem) -> tuple[int, float]:
    return item.command, item.parameters[0]


def _item(command: int, place: GeoPosition, parameter: float) -> MissionItem:
    return MissionItem(
        command=command,
        frame=GLOBAL,
        x_e7=e7_of_deg(place.latitude_deg),
        y_e7=e7_of_deg(place.longitude_deg),
        parameters=(parameter, 0.0, 0.0, 0.0),
    )


def _place(item: MissionItem) -> GeoPosition:
    return GeoPosition(deg_of_e7(item.x_e7), deg_of_e7(item.y_e7))


def _polygon(ring: Ring) -> Polygon:
    return Polygon([_lon_lat(corner) for corner in ring])


def _lon_lat(place: GeoPosition) -> tuple[float, float]:
    return place.longitude_deg, place.latitude_deg
