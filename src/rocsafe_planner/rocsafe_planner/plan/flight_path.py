# SPDX-License-Identifier: Apache-2.0
"""The places of a flight in flying order."""

import math
from dataclasses import dataclass

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan.plan import Route, Viewpoint


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop:
    """A place where a vehicle stands still; `viewpoint` is None at homes, bends and ends.

    `height_m` counts from the ground where the vehicle took off.
    """

    position: GeoPosition
    height_m: float
    viewpoint: Viewpoint | None = None


def landing_place(route: Route, number: int) -> GeoPosition | None:
    """Return where flight `number` of a route lands; None: at its last viewpoint."""
    vehicle = route.vehicle
    if number < len(route.sorties) - 1:
        return vehicle.home
    if vehicle.is_open:
        return None
    return vehicle.end or vehicle.home


def begins_aloft(route: Route, number: int) -> bool:
    """Return whether flight `number` of a route begins in the air."""
    return number == 0 and route.vehicle.aloft is not None


def ground_places(route: Route) -> tuple[GeoPosition, GeoPosition | None]:
    """Return a vehicle's home and its end, if it has one, at the altitude of the ground there.

    Over level ground their altitudes are not changed.
    """
    home, end = route.vehicle.home, route.vehicle.end
    ground_m = route.ground_altitude_m
    if math.isnan(ground_m):
        return home, end
    deeper_m = 0.0
    if not math.isnan(route.landing_height_m):
        deeper_m = route.landing_height_m - route.flight_height_m
    return at_altitude(home, ground_m), end and at_altitude(end, ground_m + deeper_m)


def at_altitude(place: GeoPosition, altitude_m: float) -> GeoPosition:
    """Return a place at another altitude."""
    return GeoPosition(place.latitude_deg, place.longitude_deg, altitude_m)


def flight_path(route: Route, number: int) -> tuple[Stop, ...]:
    """Return the stops of flight `number` of a route, from where it begins to where it lands."""
    sortie = route.sorties[number]
    if begins_aloft(route, number):
        stops = [_stop(route, route.vehicle.start)]
    else:
        stops = [Stop(position=route.vehicle.home, height_m=route.flight_height_m)]
    # Legs to viewpoints; a last leg, if there is one, has no viewpoint at its end.
    for bends, viewpoint in zip(sortie.bends, sortie.viewpoints, strict=False):
        stops.extend(_stop(route, bend) for bend in bends)
        stops.append(_stop(route, viewpoint.position, viewpoint))
    landing = landing_place(route, number)
    if landing is not None:
        stops.extend(_stop(route, bend) for bend in sortie.bends[-1])
        is_elsewhere = landing == route.vehicle.end
        height = route.landing_height_m if is_elsewhere else math.nan
        height = route.flight_height_m if math.isnan(height) else height
        stops.append(Stop(position=landing, height_m=height))
    return tuple(stops)


def altitude_m(route: Route, stop: Stop) -> float:
    """Return the altitude of a stop above the ellipsoid, NaN if it is not known.

    For a home or an end it is the altitude of the ground below the vehicle.
    """
    ground_m = route.ground_altitude_m
    if stop.viewpoint is None and math.isnan(ground_m):
        known = [view.position.altitude_m - view.height_agl_m for view in route.viewpoints[:1]]
        ground_m = known[0] if known else route.vehicle.home.altitude_m
    return stop.position.altitude_m if stop.viewpoint else ground_m + stop.height_m


def _stop(route: Route, position: GeoPosition, viewpoint: Viewpoint | None = None) -> Stop:
    height = position.altitude_m - route.ground_altitude_m
    if math.isnan(height):
        height = route.flight_height_m
    return Stop(position=position, height_m=height, viewpoint=viewpoint)
