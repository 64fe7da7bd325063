# SPDX-License-Identifier: Apache-2.0
"""How long a survey still takes, from what is left to fly: a hold makes it no shorter."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

from rocsafe_console.picture.vehicle import CRASHED, LOST, Vehicle
from rocsafe_geo.position import GeoPosition, level_offset_m

_LANDED = 8
_ON_THE_WAY_DOWN = frozenset({6, 7})
Place = Sequence[float]


@dataclass(frozen=True, slots=True)
class RouteLeft:
    """What a route still takes, after each number of viewpoints.

    Parameters
    ----------
    plan_id
        Of the plan that it belongs to.
    duration_s
        Planned, from take-off to touch-down.
    places
        Latitude and longitude of each viewpoint, degrees, and of where it lands.
    rest_m
        Way from each of them to the last.
    length_m
        Of the whole way.
    """

    plan_id: str
    duration_s: float
    places: Sequence[Place]
    rest_m: Sequence[float]
    length_m: float

    def left_s(self, vehicle: Vehicle) -> float:
        """Return the part of the duration that the way left has in the whole way, seconds.

        0 for a vehicle that is lost or has landed; NaN for one that flies another plan.
        """
        report = vehicle.report
        if report.state in (LOST, CRASHED, _LANDED):
            return 0.0
        if report.state in _ON_THE_WAY_DOWN:
            return vehicle.way_home_s
        if not report.plan_id:
            return self.duration_s
        if report.plan_id != self.plan_id:
            return math.nan
        following = min(report.viewpoints_visited, len(self.places) - 1)
        here = (vehicle.latitude_deg, vehicle.longitude_deg)
        left_m = _metres(here, self.places[following]) + self.rest_m[following]
        return self.duration_s * min(left_m / max(self.length_m, 1.0), 1.0)


def routes_left(plan: Mapping[str, Any]) -> dict[str, RouteLeft]:
    """Return the route of each vehicle of a plan as the page has it."""
    return {
        name: _route_left(plan['plan_id'], route)
        for name, route in plan['routes'].items()
        if route['viewpoints']
    }


def survey_left_s(routes: Mapping[str, RouteLeft], vehicles: Iterable[Vehicle]) -> float:
    """Return how long the last vehicle still flies, seconds; NaN if that is known of none."""
    left = [routes[one.name].left_s(one) for one in vehicles if one.name in routes]
    return max((one for one in left if math.isfinite(one)), default=math.nan)


def _route_left(plan_id: str, route: Mapping[str, Any]) -> RouteLeft:
    line = [tuple(place) for place in route['line']]
    viewpoints = [tuple(one[:2]) for one in route['viewpoints']]
    legs_m = [_metres(a, b) for a, b in pairwise(line)]
    rest_m = [*accumulate(reversed(legs_m), initial=0.0)][::-1]
    at, rests = 0, []
    for place in viewpoints:
        at = line.index(place, at)
        rests.append(rest_m[at])
    return RouteLeft(
        plan_id, route['duration_s'], [*viewpoints, line[-1]], [*rests, 0.0], rest_m[0]
    )


def _metres(a: Place, b: Place) -> float:
    return math.hypot(*level_offset_m(GeoPosition(a[0], a[1]), GeoPosition(b[0], b[1])))
