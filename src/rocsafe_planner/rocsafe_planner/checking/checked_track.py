# SPDX-License-Identifier: Apache-2.0
"""The track of a flight for the checker, from the places of the plan only."""

import math
from itertools import pairwise

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.route_motion import RouteMotion
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan.plan import Route, SurveyPlan


def way(route: Route, number: int) -> tuple[GeoPosition, ...]:
    """Return the corners of a flight's track."""
    sortie, vehicle = route.sorties[number], route.vehicle
    is_last = number == len(route.sorties) - 1
    begins_aloft = number == 0 and vehicle.aloft is not None
    way = [vehicle.start if begins_aloft else vehicle.home]
    for view, bends in zip(sortie.viewpoints, sortie.bends, strict=False):
        way += [*bends, view.position]
    if not (is_last and vehicle.is_open):
        way += [*sortie.bends[-1], (vehicle.end or vehicle.home) if is_last else vehicle.home]
    return tuple(way)


def ups_m(plan: SurveyPlan, route: Route, number: int) -> FloatArray:
    """Return the altitude over each corner of a flight's track; over level ground 0.

    There only a vehicle that begins in the air may begin at another height.
    """
    track, request = way(route, number), plan.request
    is_level = request.terrain is None
    ups = np.array([0.0 if is_level else place.altitude_m for place in track])
    from_air = number == 0 and route.vehicle.aloft is not None
    if is_level:
        start, known = track[0].altitude_m, _levels_m(plan, route)
        if from_air and known and not math.isnan(start - known[0]):
            ups[0] = start - known[0]
        return ups
    is_last = number == len(route.sorties) - 1
    ends = [] if from_air and not math.isnan(ups[0]) else [0]
    ends += [] if is_last and route.vehicle.is_open else [len(track) - 1]
    for end in ends:
        place = track[end]
        ups[end] = _ground_m(plan, place) + route.flight_height_m
    return ups


def _levels_m(plan: SurveyPlan, route: Route) -> list[float]:
    """Return the altitude of a route's flights from the photographs of the plan."""
    return [
        view.position.altitude_m - view.height_agl_m + route.flight_height_m
        for other in plan.routes
        for view in other.viewpoints[:1]
    ]


def _ground_m(plan: SurveyPlan, place: GeoPosition) -> float:
    terrain = plan.request.terrain
    if terrain is None:
        return 0.0
    height = terrain.altitudes_m([place.latitude_deg], [place.longitude_deg])[0]
    return float(height) + terrain_shift_m(plan)


def terrain_shift_m(plan: SurveyPlan) -> float:
    """Return the mean height of the homes above the terrain."""
    request, terrain = plan.request, plan.request.terrain
    homes = request.continuation.ground_reference or tuple(v.home for v in request.vehicles)
    known = [home for home in homes if not math.isnan(home.altitude_m)]
    if terrain is None or not known:
        return 0.0
    said = terrain.altitudes_m([h.latitude_deg for h in known], [h.longitude_deg for h in known])
    return float(np.mean([h.altitude_m for h in known] - said))


def motion_of(plan: SurveyPlan, route: Route, number: int, frame: LocalFrame) -> RouteMotion:
    """Return the motion of a flight, from the kinematics of its track only."""
    vehicle = route.vehicle
    performance = vehicle.performance(plan.request.airspace.wind_mps)
    track = corners_of(plan, route, number, frame)
    shots = _shots(route, number)
    height = route.flight_height_m
    from_air = number == 0 and vehicle.aloft is not None
    here = track[0]
    start = here if from_air else (here[0], here[1], here[2] - height)
    ways = [] if from_air else performance.ascent(start, here[2])
    for number, (here, place) in enumerate(pairwise(track), start=1):
        stand_s = vehicle.hover_s if shots[number] else 0.0
        is_passed = shots[number] and stand_s == 0.0 and any(shots[number + 1 :])
        ways.append(performance.way(here, place, stand_s, is_passed=is_passed))
    ways.append(performance.way(track[-1], track[-1], vehicle.autopilot.home_wait_s))
    ways.extend(performance.descent(track[-1], track[-1][2] - height))
    return RouteMotion(start, ways, performance.corner_radius_m)


def _shots(route: Route, number: int) -> list[bool]:
    """Return at which corners of a flight's track a viewpoint is photographed.

    By their order: a leg may bend at the place of a viewpoint on the edge of an exclusion.
    """
    sortie = route.sorties[number]
    shots = [False]
    for _, bends in zip(sortie.viewpoints, sortie.bends, strict=False):
        shots += [*(False for _ in bends), True]
    return shots + [False] * (len(way(route, number)) - len(shots))


def corners_of(plan: SurveyPlan, route: Route, number: int, frame: LocalFrame) -> list[Enu]:
    """Return the corners of a flight, (east, north, up)."""
    level = 0.0 if plan.request.terrain is not None else route.flight_height_m
    ups = (ups_m(plan, route, number) + level).tolist()
    plane = frame.plane_of(way(route, number)).tolist()
    return [(east, north, up) for (east, north), up in zip(plane, ups, strict=True)]


def frame_of(plan: SurveyPlan) -> LocalFrame:
    """Return a frame about a corner of the first region, as high as the first home that is known.

    The altitude matters: a plane 600 m higher shows areas larger by two in ten thousand.
    """
    first = plan.request.regions[0].area.boundary[0]
    homes = (vehicle.home.altitude_m for vehicle in plan.request.vehicles)
    altitude_m = next((home for home in homes if math.isfinite(home)), 0.0)
    return LocalFrame(GeoPosition(first.latitude_deg, first.longitude_deg, altitude_m))
