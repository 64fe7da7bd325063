# SPDX-License-Identifier: Apache-2.0
"""Planning of a request: cover the regions, share out the viewpoints, bound the makespan."""

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import shapely

from rocsafe_planner.coverage.sight import Sight, sight
from rocsafe_planner.errors import BeyondEnduranceError, PlanningCancelledError
from rocsafe_planner.flights.keeping_apart import KeptApart, kept_apart
from rocsafe_planner.flights.routes import SECONDS_PER_HOUR
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.problem.fleet_problem import Order
from rocsafe_planner.routing.costs import Optimised, objective_value
from rocsafe_planner.routing.methods import METHODS
from rocsafe_planner.routing.tours.boustrophedon import boustrophedon_minmax
from rocsafe_planner.routing.tours.insertion import minmax_insertion
from rocsafe_planner.site.given_viewpoints import footprints_of
from rocsafe_planner.site.survey_site import SurveySite, survey_site

if TYPE_CHECKING:
    from rocsafe_planner.routing.bound import LowerBound
    from rocsafe_planner.solver.bounds.walk_prices import PriceOptions

PRICE_WORK_PER_S, PRICE_WORK_PER_PROPOSAL = 1e8, 100.0
"""Work for the prices of a bound in relation to the budget of a search: a third of its time."""
MANY_POINTS = 2000
"""Above this the bound of a search is taken without another one beside it."""

Figures = tuple[float, float]
"""Best makespan and lower bound so far, seconds, NaN while unknown."""
UNKNOWN: Figures = (math.nan, math.nan)

Progress = Callable[[float, float], bool]
"""Told the best makespan and lower bound so far, in seconds, NaN while unknown; False stops.

Once a makespan is known, the plan that has it is kept.
"""


def plan_survey(
    request: SurveyRequest, on_progress: Progress = lambda _makespan, _bound: True
) -> SurveyPlan:
    """Return the plan of a request: the same request gives the same plan.

    A vehicle with an open route that begins in an exclusion and has nothing to photograph would
    land where it must not: the plan is that of the request in which it flies home.

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
    site, found = _served(site, on_progress)
    stranded = _stranded(site, found)
    if stranded:
        homeward = tuple(
            dataclasses.replace(v, is_open=v.is_open and k not in stranded)
            for k, v in enumerate(request.vehicles)
        )
        return plan_survey(dataclasses.replace(request, vehicles=homeward), on_progress)
    apart = kept_apart(site, found.orders)
    makespan = max(route.finish_s for route in apart.routes)
    is_time = request.effort.minimises_makespan
    bound = _bound(site, found, makespan, on_progress)
    sight = _sight(site, apart)
    return SurveyPlan(
        plan_id=request.identity(),
        request=request,
        routes=apart.routes,
        spacing_m=site.spec.spacing_m[0],
        spacing_along_m=site.spec.spacing_m[1],
        # A bound that equals the makespan may exceed it by rounding.
        lower_bound_s=min(bound.makespan_s, makespan),
        lower_bound_method=bound.method,
        objective_bound=min(bound.makespan_s, makespan) if is_time else found.bound,
        region_area_m2=sight.region_area_m2,
        forbidden_area_m2=sight.forbidden_area_m2,
        covered_area_m2=sight.covered_area_m2,
        largest_hole_m2=sight.largest_hole_m2,
        minimum_separation_m=apart.separation_m,
        near_unheard=apart.near_unheard,
        left_out=site.left_out,
    )


def _served(site: SurveySite, on_progress: Progress) -> tuple[SurveySite, Optimised]:
    """Return routes within the batteries, and the site of the viewpoints that they visit.

    The rest of a survey goes without the viewpoints that its batteries do not do for.

    Raises
    ------
    BeyondEnduranceError
        If batteries do not do for all viewpoints of a new survey, or for any one of a rest.
    """
    # Loaded when it is asked for: see `_found`.
    from rocsafe_planner.routing import battery_reach as reach

    request, simple = site.request, boustrophedon_minmax(site.problem)
    if (ordered := _with_last_points(site)) is not None:
        return site, ordered
    if math.isfinite(objective_value(site.problem, simple, 'longest_time')):
        return site, _found(site, on_progress, [simple])
    beyond = reach.beyond_reach(site.problem)
    if beyond and (not request.continuation.is_rest or len(beyond) == len(site.problem.points)):
        raise next(iter(beyond.values()))
    if beyond:
        site = site.without(beyond)
    shortage_s = reach.proven_shortage_s(site.problem)
    if not request.continuation.is_rest:
        if shortage_s:
            raise BeyondEnduranceError(_shortage(site, shortage_s))
        return site, _found(site, on_progress)
    if not shortage_s:
        found = _found(site, on_progress)
        if math.isfinite(objective_value(site.problem, found.orders, 'longest_time')):
            return site, found
    return _partly_served(site, reach.most_served(site.problem, request.effort), on_progress)


def _with_last_points(site: SurveySite) -> Optimised | None:
    """Return routes on which the last viewpoints come last; None: there are none, or no routes."""
    request = site.request
    last = {k for k, v in enumerate(site.viewpoints) if v.id in request.continuation.last}
    if not last:
        return None
    if request.effort.method == 'solver':
        # Loaded when it is asked for: see `_found`.
        from rocsafe_planner.routing.last_points import orders_with_last

        orders = orders_with_last(site.problem, request.effort, last)
    else:
        orders = minmax_insertion(site.problem, last)
    value = objective_value(site.problem, orders, 'longest_time')
    return Optimised(orders=orders) if math.isfinite(value) else None


def _partly_served(
    site: SurveySite, orders: list[Order], on_progress: Progress
) -> tuple[SurveySite, Optimised]:
    """Return good routes over the points of some, and the site of those points alone."""
    served = sorted({point for order in orders for point in order})
    if not served:
        raise BeyondEnduranceError('the batteries do for no viewpoint')
    part = site.without(set(range(len(site.problem.points))) - set(served))
    number = {point: new for new, point in enumerate(served)}
    known = [[number[point] for point in order] for order in orders]
    found = _found(part, on_progress, [known])
    if math.isinf(objective_value(part.problem, found.orders, 'longest_time')):
        found = Optimised(orders=known)  # a method without a search may exceed the batteries
    return part, found


def _shortage(site: SurveySite, needed_s: float) -> str:
    """Return that no plan keeps to the batteries, as one line."""
    longest_s = max(vehicle.first_endurance_s for vehicle in site.problem.vehicles)
    return (
        f'no plan for {len(site.problem.points)} viewpoints keeps to the batteries: the last '
        f'vehicle needs at least {needed_s:.0f} s, and endurance_s is at most {longest_s:.0f} s'
    )


def _stranded(site: SurveySite, found: Optimised) -> set[int]:
    """Return the vehicles without viewpoints that would land in the exclusion they begin in."""
    problem = site.problem
    return {
        k
        for k, order in enumerate(found.orders)
        if not order and problem.vehicles[k].is_open and problem.is_shut_in(k)
    }


def _bound(
    site: SurveySite, found: Optimised, makespan_s: float, on_progress: Progress
) -> 'LowerBound':
    """Return the best bound of the makespan: that of the search, or a later one."""
    # Loaded when it is asked for: see `_found`.
    from rocsafe_planner.routing.bound import LowerBound, lower_bound

    has_proof = site.request.effort.minimises_makespan and found.bound > 0.0
    proven = LowerBound(makespan_s=found.bound, method=found.bound_name)
    if has_proof and len(site.problem.points) > MANY_POINTS:
        # The bound by a forest takes too long here: that of the search is enough.
        return proven
    later = lower_bound(
        site.problem,
        makespan_s,
        lambda seconds: on_progress(makespan_s, seconds),
        prices=_prices(site.request),
    )
    return proven if has_proof and found.bound > later.makespan_s else later


def _prices(request: SurveyRequest) -> 'PriceOptions | None':
    """Return how the prices of a bound are sought: in proportion to the search for the routes.

    None for a method without a search, and while vehicles wait in the air.
    """
    from rocsafe_planner.solver.bounds.walk_prices import PriceOptions

    effort = request.effort
    if effort.method != 'solver' or any(vehicle.aloft for vehicle in request.vehicles):
        return None
    work = PRICE_WORK_PER_S * effort.budget_s or PRICE_WORK_PER_PROPOSAL * effort.proposals
    return PriceOptions(work=work) if work else PriceOptions()


def _sight(site: SurveySite, apart: KeptApart) -> Sight:
    """Return what the photographs show: from higher layers they show more."""
    if not any(apart.layers_m):
        return site.coverage.sight
    views = [view for route in apart.routes for view in route.viewpoints]
    seen = footprints_of(site.frame, (*views, *site.request.continuation.visited))
    zones = [zone.polygon(site.frame) for zone in site.request.exclusions]
    return sight(site.polygons, seen, shapely.union_all(zones) if zones else None)


def _found(
    site: SurveySite, on_progress: Progress, known: Sequence[list[Order]] = ()
) -> Optimised:
    """Return the routes of the request's method, and what it proved of its objective, if any."""
    request = site.request
    if request.effort.method != 'solver':
        orders = METHODS[request.effort.method](site.problem)
        return Optimised(orders=orders)
    # Loaded when it is asked for: compiled code takes a moment that no other method needs.
    from rocsafe_planner.routing.battery_swaps import optimised_with_swaps

    is_time = request.effort.minimises_makespan
    found = optimised_with_swaps(
        site.problem,
        request.effort,
        # A value that is no time is not reported.
        on_progress if is_time else lambda _value, _bound: on_progress(math.nan, math.nan),
        known,
    )
    if request.effort.objective == 'energy':
        return dataclasses.replace(found, bound=found.bound / SECONDS_PER_HOUR)
    return found


def _go_on(on_progress: Progress) -> None:
    """Report that there is no plan yet; raise PlanningCancelledError if there is to be none."""
    if not on_progress(math.nan, math.nan):
        raise PlanningCancelledError('planning was cancelled')
