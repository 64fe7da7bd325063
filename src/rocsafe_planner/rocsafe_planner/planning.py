# SPDX-License-Identifier: Apache-2.0
"""From a request to a plan: cover the regions, share out the viewpoints, bound the makespan."""

import dataclasses
import math
from collections.abc import Callable

from rocsafe_planner.bound import LowerBound, lower_bound
from rocsafe_planner.errors import PlanningCancelledError
from rocsafe_planner.fleet_problem import Order
from rocsafe_planner.flight_track import FlightTrack
from rocsafe_planner.plan import Route, SurveyPlan
from rocsafe_planner.request import DEFAULT_OBJECTIVE, SurveyRequest
from rocsafe_planner.route_making import routes_of
from rocsafe_planner.routing import METHODS
from rocsafe_planner.separation import delays_apart, minimum_separation_m
from rocsafe_planner.survey_site import SurveySite, survey_site

Progress = Callable[[float, float], bool]
"""Told the best makespan and lower bound so far, in seconds, NaN while unknown; False stops.

Once a makespan is known, the plan that has it is kept.
"""


def plan_survey(
    request: SurveyRequest, on_progress: Progress = lambda _makespan, _bound: True
) -> SurveyPlan:
    """Return the plan of a request: the same request gives the same plan.

    Raises
    ------
    ValueError
        If a home or end is too far from the region, or in an exclusion.
    PlannerError
        If there is no plan within the limits; PlanningCancelledError if `on_progress` returned
        False before there was one.
    """
    _go_on(on_progress)
    site = survey_site(request)
    _go_on(on_progress)
    orders, proven = _orders(site, request, on_progress)
    routes, separation = _kept_apart(site, routes_of(site, orders), request.separation_m)
    makespan = max(route.finish_s for route in routes)
    bound = lower_bound(site.problem, makespan, lambda seconds: on_progress(makespan, seconds))
    if proven.makespan_s > bound.makespan_s:
        bound = proven
    return SurveyPlan(
        plan_id=request.identity(),
        request=request,
        routes=routes,
        spacing_m=site.spec.spacing_m[0],
        spacing_along_m=site.spec.spacing_m[1],
        # A bound that equals the makespan may exceed it by rounding.
        lower_bound_s=min(bound.makespan_s, makespan),
        lower_bound_method=bound.method,
        region_area_m2=site.coverage.region_area_m2,
        covered_area_m2=site.coverage.covered_area_m2,
        largest_hole_m2=site.coverage.largest_hole_m2,
        minimum_separation_m=separation,
    )


def _orders(
    site: SurveySite, request: SurveyRequest, on_progress: Progress
) -> tuple[list[Order], LowerBound]:
    """Return the routes of the request's method, and the bound that came with them, if any."""
    unproven = LowerBound(makespan_s=0.0, method='')
    if request.method != 'solver':
        return METHODS[request.method](site.problem), unproven
    from rocsafe_planner.optimising import Effort, optimised

    is_time = request.objective == DEFAULT_OBJECTIVE
    found = optimised(
        site.problem,
        Effort(objective=request.objective, budget_s=request.budget_s, seed=request.seed),
        # What is not a time is not told.
        on_progress if is_time else lambda _value, _bound: on_progress(math.nan, math.nan),
    )
    if not is_time:
        return found.orders, unproven
    return found.orders, LowerBound(makespan_s=found.bound, method=found.bound_name)


def _go_on(on_progress: Progress) -> None:
    """Report that there is no plan yet; raise PlanningCancelledError if there is to be none."""
    if not on_progress(math.nan, math.nan):
        raise PlanningCancelledError('planning was cancelled')


def _kept_apart(
    site: SurveySite, routes: tuple[Route, ...], separation_m: float
) -> tuple[tuple[Route, ...], float]:
    """Return the routes, delayed if need be, and the least distance of two vehicles."""
    flying = [k for k, route in enumerate(routes) if route.sorties]
    tracks = [
        FlightTrack(
            site.problem, k, [[v.id for v in sortie.viewpoints] for sortie in routes[k].sorties]
        )
        for k in flying
    ]
    delays = delays_apart(tracks, separation_m) if separation_m > 0.0 else [0.0] * len(tracks)
    late = dict(zip(flying, delays, strict=True))
    delayed = tuple(
        dataclasses.replace(route, delay_s=late.get(k, 0.0)) for k, route in enumerate(routes)
    )
    return delayed, minimum_separation_m(tracks, delays)
