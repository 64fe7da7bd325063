# SPDX-License-Identifier: Apache-2.0
"""The places of a flight in order, for whoever draws, exports or checks it."""

from dataclasses import dataclass

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan import Route, Viewpoint


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop:
    """A place where a vehicle stands still; `viewpoint` is None at homes, bends and ends."""

    position: GeoPosition
    viewpoint: Viewpoint | None = None


def landing_place(route: Route, number: int) -> GeoPosition | None:
    """Return where flight `number` of a route lands; None: at its last viewpoint."""
    vehicle = route.vehicle
    if number < len(route.sorties) - 1:
        return vehicle.home
    if vehicle.is_open:
        return None
    return vehicle.end or vehicle.home


def flight_path(route: Route, number: int) -> tuple[Stop, ...]:
    """Return the stops of flight `number` of a route, from home to where it lands."""
    sortie = route.sorties[number]
    stops = [Stop(position=route.vehicle.home)]
    # Legs to viewpoints; a last leg, if there is one, has no viewpoint at its end.
    for bends, viewpoint in zip(sortie.bends, sortie.viewpoints, strict=False):
        stops.extend(Stop(position=bend) for bend in bends)
        stops.append(Stop(position=viewpoint.position, viewpoint=viewpoint))
    landing = landing_place(route, number)
    if landing is not None:
        stops.extend(Stop(position=bend) for bend in sortie.bends[-1])
        stops.append(Stop(position=landing))
    return tuple(stops)
