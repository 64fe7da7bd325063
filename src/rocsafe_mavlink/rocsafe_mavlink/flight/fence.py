# SPDX-License-Identifier: Apache-2.0
"""Fences and rally points as items: they are transferred like a mission, with own types."""

from collections.abc import Sequence
from dataclasses import dataclass

from shapely.geometry import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from rocsafe_geo.limits import require_positive
from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.protocols.mission_item import GLOBAL, GLOBAL_RELATIVE, MissionItem
from rocsafe_mavlink.wire.units import deg_of_e7, e7_of_deg

INCLUSION_VERTEX, EXCLUSION_VERTEX, RALLY_POINT = 5001, 5002, 5100
LARGEST_CORNER_COUNT = 80
Ring = tuple[GeoPosition, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fence:
    """Polygons of a geofence.

    Attributes
    ----------
    inclusions
        The vehicle stays within each of these.
    exclusions
        The vehicle stays out of each of these.
    """

    inclusions: tuple[Ring, ...] = ()
    exclusions: tuple[Ring, ...] = ()

    def __post_init__(self) -> None:
        rings = (*self.inclusions, *self.exclusions)
        for ring in rings:
            if len(ring) < 3 or not _polygon(ring).is_valid:
                raise ValueError(
                    f'a polygon of a fence with {len(ring)} corners: must have 3 or more, and '
                    'not cross itself'
                )
        if sum(map(len, rings)) > LARGEST_CORNER_COUNT:
            raise ValueError(f'a fence has at most {LARGEST_CORNER_COUNT} corners in all')

    def holds(self, place: GeoPosition) -> bool:
        """Whether a vehicle may be at `place`."""
        return self._holds(Point(*_lon_lat(place)))

    def holds_leg(self, start: GeoPosition, end: GeoPosition) -> bool:
        """Whether a vehicle may fly straight from `start` to `end`."""
        return self._holds(LineString([_lon_lat(start), _lon_lat(end)]))

    def _holds(self, shape: BaseGeometry) -> bool:
        within = all(_polygon(ring).covers(shape) for ring in self.inclusions)
        return within and not any(_polygon(ring).intersects(shape) for ring in self.exclusions)


def fence_items(fence: Fence) -> tuple[MissionItem, ...]:
    """Return the items of `fence`: each corner holds the corner count of its polygon."""
    return tuple(
        MissionItem(
            command=command,
            frame=GLOBAL,
            x_e7=e7_of_deg(corner.latitude_deg),
            y_e7=e7_of_deg(corner.longitude_deg),
            parameters=(float(len(ring)), 0.0, 0.0, 0.0),
        )
        for command, rings in (
            (INCLUSION_VERTEX, fence.inclusions),
            (EXCLUSION_VERTEX, fence.exclusions),
        )
        for ring in rings
        for corner in ring
    )


def fence_of(items: Sequence[MissionItem]) -> Fence:
    """Return the polygons among the items of a fence; circles are not read.

    Raises
    ------
    ValueError
        If the corners do not add up to polygons.
    """
    rings: dict[int, list[Ring]] = {INCLUSION_VERTEX: [], EXCLUSION_VERTEX: []}
    corners = [item for item in items if item.command in rings]
    while corners:
        count = max(1, int(corners[0].parameters[0]))
        ring, corners = corners[:count], corners[count:]
        rings[ring[0].command].append(tuple(map(_place, ring)))
    return Fence(
        inclusions=tuple(rings[INCLUSION_VERTEX]), exclusions=tuple(rings[EXCLUSION_VERTEX])
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


def _place(item: MissionItem) -> GeoPosition:
    return GeoPosition(deg_of_e7(item.x_e7), deg_of_e7(item.y_e7))


def _polygon(ring: Ring) -> Polygon:
    return Polygon([_lon_lat(corner) for corner in ring])


def _lon_lat(place: GeoPosition) -> tuple[float, float]:
    return place.longitude_deg, place.latitude_deg
