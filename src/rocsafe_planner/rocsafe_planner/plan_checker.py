# SPDX-License-Identifier: Apache-2.0
"""An independent look at a plan: it is what was asked for, and says the truth of itself.

Nothing here comes from the modules that make plans. Distances are geodesics, times follow from
the kinematics of each leg, exclusions are tested on the drawn legs, and vehicles are watched
flying at the same time.
"""

import math
from collections import Counter
from collections.abc import Iterator
from itertools import combinations, pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion import MotionLimits, leg_duration_s, leg_progress_m
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_planner.plan import Route, Sortie, SurveyPlan, Viewpoint
from rocsafe_planner.vehicle import Vehicle

FloatArray = NDArray[np.float64]
Fault = str

# The planner measures in a tangent plane, this module on the ellipsoid: 1e-4 apart at 150 km.
_RELATIVE = 2e-4
_ABSOLUTE_M = 0.05
_ABSOLUTE_S = 0.05
_SAMPLE_S = 0.2


def check_plan(plan: SurveyPlan) -> list[Fault]:
    """Return all that is wrong with a plan, one line each; empty if nothing is."""
    faults = [*_visits(plan), *_figures(plan), *_coverage(plan), *_exclusions(plan)]
    for route in plan.routes:
        faults.extend(f'{route.vehicle.name}: {fault}' for fault in _route(plan, route))
    return faults or list(_separation(plan))


def _visits(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield viewpoints left out or visited twice, and routes of the wrong vehicles."""
    if tuple(route.vehicle for route in plan.routes) != plan.request.vehicles:
        yield 'routes are not one a vehicle in the order of the request'
    counts = Counter(view.id for route in plan.routes for view in route.viewpoints)
    twice = [number for number, count in counts.items() if count > 1]
    missing = sorted(set(range(max(counts, default=0) + 1)) - set(counts))
    if not counts:
        yield 'no viewpoint is visited'
    if twice or missing:
        yield f'viewpoints {missing[:5]} are not visited, {twice[:5]} more than once'
    if len(counts) > plan.request.max_viewpoints:
        yield f'{len(counts)} viewpoints: max_viewpoints is {plan.request.max_viewpoints}'


def _figures(plan: SurveyPlan) -> Iterator[Fault]:
    finishes = [
        route.delay_s
        + sum(sortie.duration_s for sortie in route.sorties)
        + (len(route.sorties) - 1) * (route.vehicle.battery_swap_s or 0.0)
        for route in plan.routes
        if route.sorties
    ]
    if not _is_near(plan.makespan_s, max(finishes, default=0.0), 1e-6):
        yield f'makespan_s is {plan.makespan_s}: the last vehicle lands at {max(finishes)}'
    if not 0.0 < plan.lower_bound_s <= plan.makespan_s * (1.0 + 1e-9):
        yield f'lower_bound_s is {plan.lower_bound_s}: must be up to {plan.makespan_s}'
    lengths = [sum(sortie.length_m for sortie in route.sorties) for route in plan.routes]
    if not _is_near(plan.total_length_m, sum(lengths), 1e-6):
        yield f'total_length_m is {plan.total_length_m}: the flights add up to {sum(lengths)}'
    if not _is_near(plan.longest_route_m, max(lengths), 1e-6):
        yield f'longest_route_m is {plan.longest_route_m}: the longest has {max(lengths)}'


def _coverage(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield wrong areas: the footprints are united once more, in a plane of this module."""
    frame = _frame(plan)
    region = shapely.union_all([r.area.polygon(frame) for r in plan.request.regions])
    views = [view for route in plan.routes for view in route.viewpoints]
    seen = shapely.union_all(
        shapely.polygons([_plane(frame, view.footprint) for view in views]), grid_size=1e-4
    )
    covered = region.intersection(seen).area
    # A strip of 2 mm along every footprint is what planes and rounding may differ by.
    slack = 1e-4 * region.area + 0.002 * sum(_perimeter_m(view) for view in views)
    if abs(plan.region_area_m2 - region.area) > 1e-4 * region.area:
        yield f'region_area_m2 is {plan.region_area_m2}: the regions have {region.area}'
    if abs(plan.covered_area_m2 - covered) > slack:
        yield f'covered_area_m2 is {plan.covered_area_m2}: photographs show {covered}'
    if plan.largest_hole_m2 > plan.region_area_m2 - plan.covered_area_m2 + slack:
        yield f'largest_hole_m2 is {plan.largest_hole_m2}: larger than all that is not covered'


def _exclusions(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield legs and viewpoints nearer to exclusions than the clearance."""
    frame = _frame(plan)
    zones = shapely.union_all([zone.polygon(frame) for zone in plan.request.exclusions])
    for route, number in _flights(plan):
        for a, b in pairwise(_way(route, number)):
            line = shapely.LineString(_plane(frame, (a, b)))
            if shapely.distance(line, zones) < plan.request.clearance_m - _ABSOLUTE_M:
                yield f'{route.vehicle.name} flies nearer to an exclusion than the clearance'
                return
            inside = shapely.length(shapely.intersection(line, zones))
            if inside > _ABSOLUTE_M:
                yield f'{route.vehicle.name} flies {inside:.1f} m over an exclusion'
                return


def _route(plan: SurveyPlan, route: Route) -> Iterator[Fault]:
    vehicle = route.vehicle
    for view in route.viewpoints:
        if not set(view.sensors) <= set(vehicle.sensors):
            yield f'lacks {view.sensors} for viewpoint {view.id}'
    if len(route.sorties) > 1 and vehicle.battery_swap_s is None:
        yield f'{len(route.sorties)} flights without a battery swap'
    for number, sortie in enumerate(route.sorties):
        yield from (f'flight {number + 1} {fault}' for fault in _sortie(plan, route, number))
        if sortie.duration_s > vehicle.endurance_s * (1.0 + 1e-9):
            yield f'flight {number + 1} takes {sortie.duration_s} s: too long for its battery'


def _sortie(plan: SurveyPlan, route: Route, number: int) -> Iterator[Fault]:
    sortie, vehicle = route.sorties[number], route.vehicle
    if not sortie.viewpoints:
        yield 'has no viewpoint'
    is_open = vehicle.is_open and number == len(route.sorties) - 1
    legs = len(sortie.viewpoints) + (0 if is_open else 1)
    if len(sortie.bends) != legs:
        yield f'has bends for {len(sortie.bends)} legs: it has {legs}'
    way = _way(route, number)
    length = sum(distance_m(a, b) for a, b in pairwise(way))
    if abs(length - sortie.length_m) > _RELATIVE * length + _ABSOLUTE_M:
        yield f'states {sortie.length_m} m: it is {length} m long'
    flying = sum(_leg_s(vehicle, plan.request.wind_mps, a, b) for a, b in pairwise(way))
    height = plan.request.height_agl_m
    duration = (
        height / vehicle.climb_rate_mps
        + flying
        + len(sortie.viewpoints) * vehicle.hover_s
        + height / vehicle.descent_rate_mps
    )
    # A stop-to-stop time grows with the root of a very short leg: millimetres there take longer.
    slack = _RELATIVE * duration + _ABSOLUTE_S * len(way)
    if abs(duration - sortie.duration_s) > slack:
        yield f'states {sortie.duration_s} s: it takes {duration} s'


def _separation(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield vehicles too near to each other, watched at every fifth of a second."""
    frame = _frame(plan)
    tracks = [_Watched(plan, route, frame) for route in plan.routes if route.sorties]
    times = _SAMPLE_S * np.arange(int(plan.makespan_s / _SAMPLE_S) + 1, dtype=np.float64)
    places = [track.places(times) for track in tracks]
    seen = math.inf
    for a, b in combinations(places, 2):
        apart = np.sqrt(((a - b) ** 2).sum(axis=1))
        seen = min(seen, float(apart[np.isfinite(apart)].min(initial=math.inf)))
    stated = plan.minimum_separation_m
    if stated < plan.request.separation_m - _ABSOLUTE_M:
        yield f'minimum_separation_m is {stated}: separation_m is {plan.request.separation_m}'
    if seen < stated - _ABSOLUTE_M - _RELATIVE * plan.longest_route_m:
        yield f'minimum_separation_m is {stated}: vehicles come within {seen} m'


class _Watched:
    """A route by the clock of the mission."""

    def __init__(self, plan: SurveyPlan, route: Route, frame: LocalFrame) -> None:
        self._wind, self._spec = plan.request.wind_mps, route.vehicle
        self._height = plan.request.height_agl_m
        self._plan, self._route, self._frame = plan, route, frame

    def places(self, times: FloatArray) -> FloatArray:
        """Return (east, north, up), NaN on the ground."""
        places = np.full((len(times), 3), np.nan)
        now = self._route.delay_s
        for number in range(len(self._route.sorties)):
            now = self._fly(places, times, now, number) + (self._spec.battery_swap_s or 0.0)
        return places

    def _fly(self, places: FloatArray, times: FloatArray, now: float, number: int) -> float:
        spec, height = self._spec, self._height
        way = _plane(self._frame, _way(self._route, number))
        shots = _shot_places(self._frame, self._route.sorties[number])
        climb_s, descent_s = height / spec.climb_rate_mps, height / spec.descent_rate_mps
        _stand(places, times, now, (way[0], climb_s, 0.0, height))
        now += climb_s
        for a, b in pairwise(way):
            limits = _limits(spec, self._wind, b - a)
            length = float(np.hypot(*(b - a)))
            duration = float(leg_duration_s(length, limits))
            now_in = (times >= now) & (times <= now + duration)
            share = np.asarray(leg_progress_m(times[now_in] - now, length, limits)) / (length or 1)
            places[now_in, :2] = a + share[:, None] * (b - a)
            places[now_in, 2] = height
            now += duration
            if tuple(np.round(b, 3)) in shots:
                _stand(places, times, now, (b, spec.hover_s, height, height))
                now += spec.hover_s
        _stand(places, times, now, (way[-1], descent_s, height, 0.0))
        return now + descent_s


def _stand(
    places: FloatArray, times: FloatArray, now: float, stay: tuple[FloatArray, float, float, float]
) -> None:
    """Set places of a stay: where, how long, from and to which height."""
    where, duration, low, high = stay
    inside = (times >= now) & (times <= now + duration)
    places[inside, :2] = where
    places[inside, 2] = low + (high - low) * (times[inside] - now) / (duration or 1.0)


def _shot_places(frame: LocalFrame, sortie: Sortie) -> set[tuple[float, ...]]:
    positions = tuple(view.position for view in sortie.viewpoints)
    return {tuple(place) for place in np.round(_plane(frame, positions), 3)}


def _flights(plan: SurveyPlan) -> Iterator[tuple[Route, int]]:
    for route in plan.routes:
        yield from ((route, number) for number in range(len(route.sorties)))


def _way(route: Route, number: int) -> tuple[GeoPosition, ...]:
    """Return the corners of a flight's track."""
    sortie, vehicle = route.sorties[number], route.vehicle
    is_last = number == len(route.sorties) - 1
    way = [vehicle.home]
    for view, bends in zip(sortie.viewpoints, sortie.bends, strict=False):
        way += [*bends, view.position]
    if not (is_last and vehicle.is_open):
        way += [*sortie.bends[-1], (vehicle.end or vehicle.home) if is_last else vehicle.home]
    return tuple(way)


def _leg_s(
    vehicle: Vehicle, wind_mps: tuple[float, float], a: GeoPosition, b: GeoPosition
) -> float:
    frame = LocalFrame(GeoPosition(a.latitude_deg, a.longitude_deg, 0.0))
    track = _plane(frame, (a, b))
    return leg_duration_s(distance_m(a, b), _limits(vehicle, wind_mps, track[1] - track[0]))


def _limits(vehicle: Vehicle, wind_mps: tuple[float, float], track: FloatArray) -> MotionLimits:
    """Return the motion over ground along a track: by the triangle of velocities."""
    length = math.hypot(*track)
    if length == 0.0 or wind_mps == (0.0, 0.0):
        return vehicle.motion
    heading = math.atan2(track[1], track[0])
    angle = math.atan2(wind_mps[1], wind_mps[0]) - heading
    wind = math.hypot(*wind_mps)
    crab = math.asin(wind * math.sin(angle) / vehicle.cruise_speed_mps)
    speed = vehicle.cruise_speed_mps * math.cos(crab) + wind * math.cos(angle)
    return MotionLimits(speed, vehicle.acceleration_mps2)


def _frame(plan: SurveyPlan) -> LocalFrame:
    first = plan.request.regions[0].area.boundary[0]
    return LocalFrame(GeoPosition(first.latitude_deg, first.longitude_deg, 0.0))


def _plane(frame: LocalFrame, positions: tuple[GeoPosition, ...]) -> FloatArray:
    return frame.to_enu(
        [position.latitude_deg for position in positions],
        [position.longitude_deg for position in positions],
        math.nan,
    )[:, :2]


def _perimeter_m(view: Viewpoint) -> float:
    ring = view.footprint
    return sum(distance_m(a, b) for a, b in pairwise((*ring, ring[0])))


def _is_near(a: float, b: float, relative: float) -> bool:
    return abs(a - b) <= relative * max(abs(a), abs(b))
