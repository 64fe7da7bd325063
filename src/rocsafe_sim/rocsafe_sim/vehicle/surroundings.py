# SPDX-License-Identifier: Apache-2.0
"""Surroundings of a vehicle: the ground, and objects on it.

Without surroundings the ground is as the route has it, and there are no obstacles.
"""

from dataclasses import replace
from typing import Protocol

from rocsafe_geo.motion.state import Enu
from rocsafe_sim.flight.route import FlightRoute

GROUND = 'the ground'


class Surroundings(Protocol):
    """Ground and obstacles; metres about the mission origin."""

    def ground_up_m(self, east_m: float, north_m: float) -> float:
        """Return the height of the ground at a place."""
        ...

    def touched(self, place_enu: Enu, radius_m: float) -> str:
        """Return the name of an object that a ball touches, without the ground; empty: none."""
        ...

    def first_hit_m(self, place_enu: Enu, direction_enu: Enu, limit_m: float) -> float:
        """Return the distance along a unit direction to ground or object; infinite beyond."""
        ...


def on_ground(surroundings: Surroundings, place_enu: Enu) -> Enu:
    """Return the ground below or above a place."""
    east, north, _ = place_enu
    return east, north, surroundings.ground_up_m(east, north)


def grounded(route: FlightRoute, surroundings: Surroundings) -> FlightRoute:
    """Return `route` with its home and landing place on the ground."""
    landing = route.landing_enu
    if route.is_open and route.waypoints:
        landing = route.waypoints[-1].position_enu
    return replace(
        route,
        home_enu=on_ground(surroundings, route.home_enu),
        landing_enu=None if landing is None else on_ground(surroundings, landing),
        is_open=False,
    )
