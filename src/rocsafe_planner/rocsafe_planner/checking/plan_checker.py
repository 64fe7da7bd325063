# SPDX-License-Identifier: Apache-2.0
"""An independent check of a plan: it fits the request, and its figures are right.

The checks use none of the modules that make plans. Distances are geodesics, times follow from
the kinematics of each leg, exclusions are tested on the legs, and the distances of vehicles that
fly at the same time are sampled.
"""

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

import shapely

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_planner.checking.checked_track import frame_of, way
from rocsafe_planner.checking.flight_checker import ABSOLUTE_M, Fault, route_faults
from rocsafe_planner.checking.traffic_checker import separation_faults
from rocsafe_planner.checking.unheard_checker import unheard_faults
from rocsafe_planner.plan.plan import Route, SurveyPlan, Viewpoint


def check_plan(plan: SurveyPlan) -> list[Fault]:
    """Return the faults of a plan, one line each."""
    faults = [*_visits(plan), *_figures(plan), *_coverage(plan), *_exclusions(plan)]
    faults += _occupied_heights(plan)
    faults += unheard_faults(plan)
    for route in plan.routes:
        faults.extend(f'{route.vehicle.name}: {fault}' for fault in route_faults(plan, route))
    return faults or list(separation_faults(plan))


def _visits(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield viewpoints left out or visited twice, and routes of the wrong vehicles."""
    if tuple(route.vehicle for route in plan.routes) != plan.request.vehicles:
        yield 'routes are not one a vehicle in the order of the request'
    counts = Counter(view.id for route in plan.routes for view in route.viewpoints)
    twice = [number for number, count in counts.items() if count > 1]
    wanted = set(range(max(counts, default=0) + 1))
    if plan.request.continuation.viewpoints:
        wanted = {view.id for view in plan.request.continuation.viewpoints} - _shut_off(plan)
    if plan.request.continuation.is_rest:
        wanted -= set(plan.left_out)
    missing = sorted(wanted.symmetric_difference(counts))
    if not counts:
        yield 'no viewpoint is visited'
    if twice or missing:
        yield f'viewpoints {missing[:5]} are not visited, {twice[:5]} more than once'
    if len(counts) > plan.request.coverage.max_viewpoints:
        yield f'{len(counts)} viewpoints: max_viewpoints is {plan.request.coverage.max_viewpoints}'


def _occupied_heights(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield routes that are flown near the height of an unheard vehicle."""
    least_m = plan.request.separation.distance_m - ABSOLUTE_M
    for route in plan.routes:
        for one in plan.request.continuation.unheard:
            height_m = one.flight_height_m
            if route.sorties and abs(route.flight_height_m - height_m) < least_m:
                yield (
                    f'{route.vehicle.name}: flies at {route.flight_height_m:g} m, {height_m:g} m '
                    'is occupied'
                )


def _shut_off(plan: SurveyPlan) -> set[int]:
    """Return given viewpoints in exclusions, or within the clearance of one."""
    frame = frame_of(plan)
    closed = _closed(plan, shapely.union_all([z.polygon(frame) for z in plan.request.exclusions]))
    views = plan.request.continuation.viewpoints
    places = shapely.points(frame.plane_of(tuple(view.position for view in views)))
    near = shapely.distance(places, closed) < ABSOLUTE_M
    missing = {view.id for view in views} - {v.id for r in plan.routes for v in r.viewpoints}
    return {view.id for view, is_near in zip(views, near, strict=True) if is_near} & missing


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
    frame = frame_of(plan)
    region = shapely.union_all([r.area.polygon(frame) for r in plan.request.regions])
    flown = [view for route in plan.routes for view in route.viewpoints]
    views = [*flown, *plan.request.continuation.visited]
    seen = shapely.union_all(
        shapely.polygons([frame.plane_of(view.footprint) for view in views]), grid_size=1e-4
    )
    zones = shapely.union_all([zone.polygon(frame) for zone in plan.request.exclusions])
    ground = region.difference(zones)
    forbidden, covered = region.area - ground.area, ground.intersection(seen).area
    # Planes and rounding may differ by a strip of 2 mm along every footprint.
    slack = 1e-4 * region.area + 0.002 * sum(_perimeter_m(view) for view in views)
    if abs(plan.region_area_m2 - region.area) > 1e-4 * region.area:
        yield f'region_area_m2 is {plan.region_area_m2}: the regions have {region.area}'
    if abs(plan.covered_area_m2 - covered) > slack:
        yield f'covered_area_m2 is {plan.covered_area_m2}: photographs show {covered}'
    if abs(plan.forbidden_area_m2 - forbidden) > 1e-4 * region.area:
        yield f'forbidden_area_m2 is {plan.forbidden_area_m2}: exclusions hold {forbidden}'
    hole_m2 = plan.region_area_m2 - plan.forbidden_area_m2 - plan.covered_area_m2
    if plan.largest_hole_m2 > hole_m2 + slack:
        yield f'largest_hole_m2 is {plan.largest_hole_m2}: larger than all that is not covered'


def _exclusions(plan: SurveyPlan) -> Iterator[Fault]:
    """Yield legs and viewpoints nearer to exclusions than the clearance."""
    frame = frame_of(plan)
    zones = shapely.union_all([zone.polygon(frame) for zone in plan.request.exclusions])
    # Long edges lie otherwise in another plane: by millimetres.
    core = shapely.buffer(zones, -ABSOLUTE_M)
    for route, number in _flights(plan):
        track = way(route, number)
        legs = list(pairwise(track))
        if number == 0 and route.vehicle.aloft is not None and legs:
            del legs[: _leaves(plan, zones, *legs[0])]
        elif not legs:  # it lands where it is
            legs = [(track[0], track[0])]
        for a, b in legs:
            line = shapely.LineString(frame.plane_of((a, b)))
            if shapely.distance(line, zones) < plan.request.airspace.clearance_m - ABSOLUTE_M:
                yield f'{route.vehicle.name} flies nearer to an exclusion than the clearance'
                return
            inside = shapely.length(shapely.intersection(line, core))
            if inside > ABSOLUTE_M:
                yield f'{route.vehicle.name} flies {inside:.1f} m over an exclusion'
                return


def _leaves(
    plan: SurveyPlan, zones: shapely.Geometry, start: GeoPosition, first: GeoPosition
) -> bool:
    """Return whether a flight begins too near to exclusions and leaves them the shortest way."""
    here, there = shapely.points(frame_of(plan).plane_of((start, first)))
    closed = _closed(plan, zones)
    if not shapely.intersects(here, closed):
        return False
    shortest_m = shapely.distance(here, shapely.boundary(closed))
    return bool(shapely.distance(here, there) <= shortest_m + ABSOLUTE_M)


def _closed(plan: SurveyPlan, zones: shapely.Geometry) -> shapely.Geometry:
    """Return the exclusions widened by the clearance, with mitred corners up to a limit."""
    return shapely.buffer(zones, plan.request.airspace.clearance_m, join_style='mitre')


def _flights(plan: SurveyPlan) -> Iterator[tuple[Route, int]]:
    for route in plan.routes:
        yield from ((route, number) for number in range(len(route.sorties)))


def _perimeter_m(view: Viewpoint) -> float:
    ring = view.footprint
    return sum(distance_m(a, b) for a, b in pairwise((*ring, ring[0])))


def _is_near(a: float, b: float, relative: float) -> bool:
    return abs(a - b) <= relative * max(abs(a), abs(b))
