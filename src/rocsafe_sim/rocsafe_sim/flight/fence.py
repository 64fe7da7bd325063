# SPDX-License-Identifier: Apache-2.0
"""The geofence of a simulated vehicle; routes that leave it are refused."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from shapely.geometry import LineString, Polygon

from rocsafe_geo.detour import Ring
from rocsafe_geo.motion.state import Enu
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.route import FlightRoute


@dataclass(frozen=True, slots=True, kw_only=True)
class Fence:
    """Polygons of a fence, (east, north), metres.

    Attributes
    ----------
    inclusions
        The vehicle stays within each of these polygons.
    exclusions
        The vehicle stays out of each of these polygons.
    """

    inclusions: tuple[Ring, ...] = ()
    exclusions: tuple[Ring, ...] = ()

    def __post_init__(self) -> None:
        for ring in (*self.inclusions, *self.exclusions):
            if len(ring) < 3 or not Polygon(ring).is_valid:
                raise ValueError(
                    f'a polygon of a fence with {len(ring)} corners: must have 3 or more, and '
                    'not cross itself'
                )

    def holds(self, way: Sequence[Enu]) -> bool:
        """Return whether a vehicle may fly over these places, straight from each to the next."""
        line = LineString([place[:2] for place in (*way, way[-1])])
        return all(Polygon(ring).covers(line) for ring in self.inclusions) and not any(
            Polygon(ring).intersects(line) for ring in self.exclusions
        )

    def require(self, route: FlightRoute, visited: int = 0) -> None:
        """Refuse a route of which a flight leaves the fence after `visited` viewpoints.

        Raises
        ------
        CommandRefusedError
            Naming the viewpoint on the way to which it leaves.
        """
        if not (self.inclusions or self.exclusions):
            return
        for name, way in _ways(route, visited):
            if not self.holds(way):
                raise CommandRefusedError(
                    f'plan {route.plan_id!r} leaves the fence on the way to {name}'
                )


def _ways(route: FlightRoute, visited: int) -> Iterator[tuple[str, list[Enu]]]:
    """Yield the name of each stop of a route, and the way to it."""
    for number in range(len(route.swaps) + 1):
        begins = route.begins_enu if number == 0 else None
        at = route.home_enu if begins is None else begins
        for index in range(route.begin_of(number), route.end_of(number)):
            waypoint = route.waypoints[index]
            if index >= visited:
                way = [at, *waypoint.approach_enu, waypoint.position_enu]
                yield f'viewpoint {waypoint.viewpoint_id}', way
            at = waypoint.position_enu
        bends = route.homeward_enu if route.is_last(number) else route.swaps[number].homeward_enu
        if route.end_of(number) >= visited:
            yield 'its landing place', [at, *bends, route.landing_of(number) or at]
