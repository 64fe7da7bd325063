# SPDX-License-Identifier: Apache-2.0
"""Motion of a whole flight: take-off, legs, stops, corners, descent."""

from itertools import pairwise

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.motion.route_motion import RouteMotion, Way
from rocsafe_geo.motion.state import Enu

Corner = tuple[Enu, bool]
"""A place (east, north, up) of a flight, and whether it is a viewpoint."""


def flight_motion(
    performance: Performance,
    corners: list[Corner],
    hover_s: float,
    heights_m: tuple[float | None, float],
) -> RouteMotion:
    """Return the motion of a flight.

    Parameters
    ----------
    performance
        Of the vehicle, in the wind.
    corners
        Where it is flown along, from over its start to over where it lands.
    hover_s
        Standing time at viewpoints; 0: they are passed, but for the last.
    heights_m
        Of the first corner above where it takes off, None if it is in the air already; of the
        last corner above where it lands.
    """
    climb_m, descent_m = heights_m
    here = start = corners[0][0]
    ways: list[Way] = []
    if climb_m is not None:
        start = (here[0], here[1], here[2] - climb_m)
        ways = performance.ascent(start, here[2])
    last_view = max((k for k, (_, is_viewpoint) in enumerate(corners) if is_viewpoint), default=0)
    for number, ((here, _), (place, is_viewpoint)) in enumerate(pairwise(corners), start=1):
        stand_s = hover_s if is_viewpoint else 0.0
        # a vehicle stops before it turns home, as autopilots do
        is_passed = is_viewpoint and hover_s == 0.0 and number < last_view
        ways.append(performance.way(here, place, stand_s, is_passed=is_passed))
    last = corners[-1][0]
    # it hovers above its landing place before it descends
    ways.append(performance.way(last, last, performance.autopilot.home_wait_s))
    ways.extend(performance.descent(last, last[2] - descent_m))
    return RouteMotion(start, ways, performance.corner_radius_m)


def enu(place: FloatArray) -> Enu:
    """Return a place (3,) as a tuple of floats."""
    east, north, up = place.tolist()
    return east, north, up
