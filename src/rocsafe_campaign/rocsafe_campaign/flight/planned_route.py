# SPDX-License-Identifier: Apache-2.0
"""Routes of a plan as simulated vehicles fly them, without a message between."""

from itertools import accumulate

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan.flight_path import ground_places
from rocsafe_planner.plan.plan import Bends, Route, Sortie, SurveyPlan, Viewpoint
from rocsafe_sim.flight.route import BatterySwap, FlightRoute, RouteWaypoint


def planned_route(plan: SurveyPlan, route: Route, frame: LocalFrame) -> FlightRoute:
    """Return a route of a plan in a local frame, as the messages of the plan would give it.

    Over level ground home is at height 0 of the frame; otherwise heights are differences of
    altitude.
    """
    places = _Places(frame, is_level=plan.request.terrain is None)
    home, end = ground_places(route)
    counts = accumulate(len(sortie.viewpoints) for sortie in route.sorties[:-1])
    return FlightRoute(
        plan_id=plan.plan_id,
        home_enu=places.ground(home),
        waypoints=tuple(
            _waypoint(viewpoint, approach, places)
            for sortie in route.sorties
            for viewpoint, approach in zip(
                sortie.viewpoints, sortie.bends[: len(sortie.viewpoints)], strict=True
            )
        ),
        homeward_enu=_homeward(route.sorties[-1], places) if route.sorties else (),
        exclusions=tuple(places.outline(zone.boundary) for zone in plan.request.exclusions),
        clearance_m=plan.request.airspace.clearance_m,
        delay_s=route.delay_s,
        swaps=tuple(
            BatterySwap(after=after, homeward_enu=_homeward(sortie, places))
            for sortie, after in zip(route.sorties[:-1], counts, strict=True)
        ),
        swap_s=route.vehicle.battery_swap_s or 0.0,
        landing_enu=None if end is None else places.ground(end),
        is_open=route.vehicle.is_open,
        height_m=0.0 if places.is_level else route.flight_height_m,
    )


def _waypoint(viewpoint: Viewpoint, approach: Bends, places: '_Places') -> RouteWaypoint:
    return RouteWaypoint(
        viewpoint_id=viewpoint.id,
        position_enu=places.place(viewpoint.position),
        yaw_rad=viewpoint.yaw_rad,
        approach_enu=tuple(map(places.place, approach)),
    )


def _homeward(sortie: Sortie, places: '_Places') -> tuple[Enu, ...]:
    legs = sortie.bends[len(sortie.viewpoints) :]
    return tuple(places.place(bend) for bends in legs for bend in bends)


class _Places:
    """Places of a plan in a local frame."""

    def __init__(self, frame: LocalFrame, *, is_level: bool) -> None:
        self._frame = frame
        self.is_level = is_level

    def place(self, position: GeoPosition) -> Enu:
        """Return a place in the air."""
        east, north, up = self._frame.enu_of(position).tolist()
        if not self.is_level:
            up = position.altitude_m - self._frame.origin.altitude_m
        return east, north, up

    def ground(self, position: GeoPosition) -> Enu:
        """Return a place on the ground."""
        east, north, up = self.place(position)
        return east, north, 0.0 if self.is_level else up

    def outline(self, ring: tuple[GeoPosition, ...]) -> tuple[tuple[float, float], ...]:
        """Return the corners of a zone, east and north."""
        return tuple((east, north) for east, north, _ in map(self.place, ring))
