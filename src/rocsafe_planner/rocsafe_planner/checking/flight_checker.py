# SPDX-License-Identifier: Apache-2.0
"""Checks of each flight: visits, duration, height."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import distance_m
from rocsafe_planner.checking.checked_track import (
    frame_of,
    motion_of,
    terrain_shift_m,
    ups_m,
    way,
)
from rocsafe_planner.plan.plan import Route, SurveyPlan

Fault = str

# The planner measures in a tangent plane, this module on the ellipsoid: 1e-4 apart at 150 km.
RELATIVE = 2e-4
ABSOLUTE_M = 0.05
ABSOLUTE_S = 0.05
# Mean radius of the earth (IUGG): a geodesic is longer by altitude / radius above the ellipsoid.
_EARTH_RADIUS_M = 6_371_009.0


def route_faults(plan: SurveyPlan, route: Route) -> Iterator[Fault]:
    """Yield the faults of a route."""
    vehicle = route.vehicle
    for view in route.viewpoints:
        if not set(view.sensors) <= set(vehicle.sensors):
            yield f'lacks {view.sensors} for viewpoint {view.id}'
    if len(route.sorties) > 1 and vehicle.battery_swap_s is None:
        yield f'{len(route.sorties)} flights without a battery swap'
    for number, sortie in enumerate(route.sorties):
        yield from (f'flight {number + 1} {fault}' for fault in _sortie(plan, route, number))
        used = _used_before_s(route) if number == 0 else 0.0
        if used + sortie.duration_s > vehicle.endurance_s * (1.0 + 1e-9):
            yield f'flight {number + 1} takes {sortie.duration_s} s: too long for its battery'


def _used_before_s(route: Route) -> float:
    """Return what a battery was used for before the first flight, a wait in the air included."""
    vehicle = route.vehicle
    return vehicle.used_s if vehicle.aloft is None else vehicle.aloft.used_s + route.delay_s


def _sortie(plan: SurveyPlan, route: Route, number: int) -> Iterator[Fault]:
    sortie, vehicle = route.sorties[number], route.vehicle
    from_air = number == 0 and vehicle.aloft is not None
    if not sortie.viewpoints and not from_air:
        yield 'has no viewpoint'
    is_open = vehicle.is_open and number == len(route.sorties) - 1
    legs = len(sortie.viewpoints) + (0 if is_open else 1)
    if len(sortie.bends) != legs:
        yield f'has bends for {len(sortie.bends)} legs: it has {legs}'
    track = way(route, number)
    ups = ups_m(plan, route, number)
    frame = frame_of(plan)
    scale = 1.0 + frame.origin.altitude_m / _EARTH_RADIUS_M
    length = scale * sum(distance_m(a, b) for a, b in pairwise(track))
    if abs(length - sortie.length_m) > RELATIVE * length + ABSOLUTE_M:
        yield f'states {sortie.length_m} m: it is {length} m long'
    duration = motion_of(plan, route, number, frame).duration_s
    # A very short leg takes as long as the fourth root of its length: micrometres count there.
    slack = RELATIVE * duration + ABSOLUTE_S * len(track)
    if abs(duration - sortie.duration_s) > slack:
        yield f'states {sortie.duration_s} s: it takes {duration} s'
    yield from _heights(plan, route, number, ups)


def _heights(plan: SurveyPlan, route: Route, number: int, ups: FloatArray) -> Iterator[Fault]:
    """Yield viewpoints at the wrong height, and legs too near to the terrain."""
    height_m = plan.request.coverage.height_agl_m
    layer = route.flight_height_m - height_m
    if layer < -1e-9 or (layer > 1e-9 and plan.request.separation.by == 'delay'):
        yield f'flies {route.flight_height_m} m high: height_agl_m is {height_m}'
    highest_m = plan.request.airspace.max_height_agl_m
    if route.flight_height_m > highest_m + 1e-9:
        yield f'flies {route.flight_height_m} m high: max_height_agl_m is {highest_m}'
    for view in route.sorties[number].viewpoints:
        if abs(view.height_agl_m - route.flight_height_m) > 1e-6:
            yield f'photographs viewpoint {view.id} from {view.height_agl_m} m'
    if plan.request.terrain is None:
        return
    terrain, frame = plan.request.terrain, frame_of(plan)
    track = frame.plane_of(way(route, number))
    share = np.linspace(0.0, 1.0, 41)[:, None]
    limit = plan.request.airspace.terrain_clearance_m
    for leg, ((a, b), (low, high)) in enumerate(zip(pairwise(track), pairwise(ups), strict=True)):
        geodetic = frame.to_geodetic(np.column_stack([a + share * (b - a), np.zeros(len(share))]))
        ground = terrain.altitudes_m(geodetic[:, 0], geodetic[:, 1]) + terrain_shift_m(plan)
        free = low + share[:, 0] * (high - low) - ground
        is_begun = leg == 0 and number == 0 and route.vehicle.aloft is not None
        least = min(limit, float(free[0])) if is_begun else limit
        if free.min() < least - ABSOLUTE_M:
            yield f'comes within {free.min()} m of the terrain'
            return
