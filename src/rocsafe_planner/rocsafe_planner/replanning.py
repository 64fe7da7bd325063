# SPDX-License-Identifier: Apache-2.0
"""Going on with a survey after something changed: a vehicle is lost, there is more to photograph.

What is left of a plan is a request like any other, whose vehicles begin where they are: the same
solver plans it, and the same checker looks at the result. The search counts proposals instead of
seconds, so that all who know the same situation find the same plan, each for itself.
"""

import dataclasses
from collections.abc import Mapping

from rocsafe_geo.position import distance_m
from rocsafe_planner.checked_planning import checked_plan
from rocsafe_planner.errors import NothingLeftError, PlannerError
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.survey_options import Continuation
from rocsafe_planner.plan.vehicle import Aloft, Vehicle
from rocsafe_planner.plan.viewpoint import Viewpoint, viewpoints_over
from rocsafe_planner.planning import Progress
from rocsafe_planner.problem.airspace import Airspace
from rocsafe_planner.site.survey_site import frame_of

_PROPOSALS_A_POINT = 5000
_LEAST_PROPOSALS = 100_000
_MOST_PROPOSALS = 2_000_000


def replan(
    plan: SurveyPlan,
    situation: Situation,
    on_progress: Progress = lambda _makespan, _bound: True,
    method: str = 'solver',
) -> SurveyPlan:
    """Return the plan for the rest of a survey; times count from now.

    Where the batteries do not do for all, it visits as many viewpoints as a search finds, and
    `left_out` of the plan names the others.

    Raises
    ------
    ValueError
        If the situation names vehicles or viewpoints that the plan has not.
    PlannerError
        If there is no plan for the rest; NothingLeftError if all is photographed.
    """
    return checked_plan(remaining_request(plan, situation, method), on_progress)


def remaining_request(
    plan: SurveyPlan, situation: Situation, method: str = 'solver'
) -> SurveyRequest:
    """Return what is left of a plan as a request for a method, without a time limit."""
    request = plan.request
    known = _all_viewpoints(plan)
    _check(situation, known, request)
    left = [view for view in known.values() if view.id not in situation.visited]
    left += viewpoints_over(
        situation.new_places,
        request.camera,
        request.coverage.height_agl_m,
        first_id=max(known, default=-1) + 1,
    )
    if not left:
        raise NothingLeftError('no viewpoint is left: all are photographed')
    done = [view for view in known.values() if view.id in situation.visited]
    # No wait keeps away from a vehicle of which nobody knows when it is where.
    by = request.separation.by
    if situation.unheard and by != 'reserved':
        by = 'layers'
    return dataclasses.replace(
        request,
        vehicles=tuple(
            _now(vehicle, situation.alive[vehicle.name])
            for vehicle in request.vehicles
            if vehicle.name in situation.alive
        ),
        coverage=dataclasses.replace(
            request.coverage, max_viewpoints=max(request.coverage.max_viewpoints, len(left))
        ),
        effort=dataclasses.replace(
            request.effort, method=method, budget_s=0.0, proposals=_proposals(len(left))
        ),
        separation=dataclasses.replace(request.separation, by=by),
        exclusions=(*request.exclusions, *situation.new_exclusions),
        continuation=Continuation(
            viewpoints=tuple(sorted(left, key=lambda view: view.id)),
            visited=(*request.continuation.visited, *done),
            ground_reference=request.continuation.ground_reference
            or tuple(v.home for v in request.vehicles),
            unheard=situation.unheard,
            last=tuple(sorted({view.id for view in left} & situation.last)),
        ),
    )


def _proposals(points: int) -> int:
    """Return how hard to search: 400 points take a good half of a second."""
    return min(max(_PROPOSALS_A_POINT * points, _LEAST_PROPOSALS), _MOST_PROPOSALS)


def unreachable(plan: SurveyPlan) -> tuple[int, ...]:
    """Return the ids of viewpoints that exclusions shut off: a plan for the rest leaves them."""
    flown = {view.id for route in plan.routes for view in route.viewpoints} | set(plan.left_out)
    return tuple(view.id for view in plan.request.continuation.viewpoints if view.id not in flown)


def leaving_exclusions_m(plan: SurveyPlan) -> dict[str, float]:
    """Return how far vehicles fly that begin in an exclusion until they are out of it, by name."""
    request = plan.request
    aloft = [route for route in plan.routes if route.vehicle.aloft is not None]
    if not request.exclusions or not aloft:
        return {}
    frame = frame_of(request)
    zones = [zone.polygon(frame) for zone in request.exclusions]
    starts = frame.plane_of([route.vehicle.start for route in aloft])
    free = Airspace(zones, request.airspace.clearance_m, starts).holds(starts).tolist()
    return {
        route.vehicle.name: distance_m(route.vehicle.start, route.sorties[0].bends[0][0])
        for route, is_free in zip(aloft, free, strict=True)
        if not is_free
    }


def _all_viewpoints(plan: SurveyPlan) -> dict[int, Viewpoint]:
    """Return the viewpoints of the routes, and those that a new plan may reach again."""
    flown = {view.id: view for route in plan.routes for view in route.viewpoints}
    return {**{view.id: view for view in plan.request.continuation.viewpoints}, **flown}


def _check(situation: Situation, known: Mapping[int, Viewpoint], request: SurveyRequest) -> None:
    names = {vehicle.name for vehicle in request.vehicles}
    strangers = sorted(set(situation.alive) - names)
    if strangers:
        raise ValueError(f'alive has {strangers[0]!r}: must be of {", ".join(sorted(names))}')
    before = {view.id for view in request.continuation.visited}
    unknown = sorted(set(situation.visited) - set(known) - before)
    if unknown:
        raise ValueError(f'visited has viewpoint {unknown[0]}: the plan has no such one')
    if not situation.alive:
        raise PlannerError('no vehicle is left to go on with the survey')


def _now(vehicle: Vehicle, now: Aloft | float | None) -> Vehicle:
    if isinstance(now, Aloft):
        return dataclasses.replace(vehicle, aloft=now, used_s=0.0)
    return dataclasses.replace(vehicle, aloft=None, used_s=now or 0.0)
