# SPDX-License-Identifier: Apache-2.0
"""The plan of an epoch: the same for all who know the same proposal."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from rocsafe_fleet.ledger.ledger import Writer
from rocsafe_fleet.ledger.records import FIRST_EPOCH, HASH_BYTES, Epoch, Proposal
from rocsafe_fleet.search.search_round import ExtraPlaces
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.errors import NothingLeftError, PlannerError
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.survey_options import UnheardVehicle
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.plan.viewpoint import viewpoints_over
from rocsafe_planner.replanning import replan

MOST_KEPT = 16
"""Plans that a process keeps for its agents."""
Ring = tuple[GeoPosition, ...]
Numbers = tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetPlan:
    """Viewpoints of each vehicle in an epoch.

    Attributes
    ----------
    routes
        Ids of viewpoints in flying order, by number of the vehicle.
    source
        The planner's plan; None: there was nothing left, or no plan.
    left_out
        Ids of viewpoints that nobody can visit.
    error
        Why there is no plan; empty if there is one.
    """

    epoch: Epoch = FIRST_EPOCH
    routes: Mapping[int, Numbers]
    source: SurveyPlan | None = None
    left_out: frozenset[int] = field(default_factory=frozenset)
    error: str = ''

    @property
    def digest(self) -> bytes:
        """Hash of the order of all viewpoints: equal for equal plans on all machines."""
        text = repr(sorted(self.routes.items())).encode()
        return hashlib.blake2b(text, digest_size=HASH_BYTES).digest()


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """A proposal that is to be planned, and what it refers to.

    Attributes
    ----------
    coordinator
        Who proposes it.
    rings
        Zones of the ledger that hold.
    extra
        Places of the rounds of the search of which some are left.
    """

    proposal: Proposal
    coordinator: Writer
    rings: tuple[Ring, ...] = ()
    extra: ExtraPlaces = ()

    @property
    def epoch(self) -> Epoch:
        """Its name."""
        return self.proposal.number, *self.coordinator


def first_plan(plan: SurveyPlan) -> FleetPlan:
    """Return the plan with which a survey begins, as that of the first epoch."""
    routes = {k: _numbers(route.viewpoints) for k, route in enumerate(plan.routes)}
    return FleetPlan(routes=routes, source=plan, left_out=frozenset(plan.left_out))


def _numbers(views: object) -> Numbers:
    return tuple(view.id for view in views)  # type: ignore[attr-defined]


def plan_of(survey: SurveyPlan, wanted: Wanted) -> FleetPlan:
    """Return the plan for what a proposal leaves, by the planner's search.

    The search counts proposals, not seconds. If it cannot run here, the points are inserted
    where they lengthen the longest route least; the hash of such a plan differs from the others'.

    Parameters
    ----------
    survey
        The plan with which the survey began, which all agents have.
    """
    epoch, proposal = wanted.epoch, wanted.proposal
    survey = with_extra(survey, wanted.extra)
    names = [vehicle.name for vehicle in survey.request.vehicles]
    try:
        plan = _searched(survey, situation_of(survey, wanted))
    except NothingLeftError:
        return FleetPlan(epoch=epoch, routes=dict.fromkeys(sorted(proposal.names), ()))
    except PlannerError as error:
        unplanned = dict.fromkeys(sorted(proposal.names), ())
        return FleetPlan(epoch=epoch, routes=unplanned, error=str(error))
    number = {name: k for k, name in enumerate(names)}
    flown = {view.id for route in plan.routes for view in route.viewpoints}
    left = {view.id for view in plan.request.continuation.viewpoints}
    return FleetPlan(
        epoch=epoch,
        routes={number[r.vehicle.name]: _numbers(r.viewpoints) for r in plan.routes},
        source=plan,
        left_out=frozenset(left - flown),
    )


def _searched(survey: SurveyPlan, situation: Situation) -> SurveyPlan:
    try:
        return replan(survey, situation)
    except (MemoryError, ImportError):
        return replan(survey, situation, method='insertion')


def with_extra(survey: SurveyPlan, extra: ExtraPlaces) -> SurveyPlan:
    """Return a survey's plan to which viewpoints over further places belong, on no route."""
    if not extra:
        return survey
    request = survey.request
    height_m = request.coverage.height_agl_m
    views = [view for i, p in extra for view in viewpoints_over((p,), request.camera, height_m, i)]
    continuation = replace(request.continuation, viewpoints=tuple(views))
    return replace(survey, request=replace(request, continuation=continuation))


def situation_of(survey: SurveyPlan, wanted: Wanted) -> Situation:
    """Return a proposal as the planner takes it.

    Who is no member may be in the air, in the layer that is reserved for it, or come down at
    home or where its route ends.
    """
    proposal = wanted.proposal
    names = [vehicle.name for vehicle in survey.request.vehicles]
    routed = {view.id for route in survey.routes for view in route.viewpoints}
    known = routed | {i for i, _ in wanted.extra}
    return Situation(
        alive={
            names[k]: Aloft(position=place.position, used_s=place.used_s)
            if place.is_aloft
            else place.used_s
            for k, place in proposal.members
        },
        visited=proposal.visited & known,
        new_exclusions=tuple(SurveyArea(ring) for ring in wanted.rings),
        unheard=tuple(
            one
            for k in range(len(names))
            if k not in proposal.names
            for one in _left_out(survey, k)
        ),
        last=proposal.last,
    )


def _left_out(survey: SurveyPlan, number: int) -> list[UnheardVehicle]:
    request = survey.request
    vehicle, layers = request.vehicles[number], request.layers_m
    height_m = request.coverage.height_agl_m + (layers[number] if layers else 0.0)
    return [
        UnheardVehicle(name=vehicle.name, flight_height_m=height_m, home=place, places=())
        for place in vehicle.landings
    ]


class SharedPlans:
    """Plans of one survey, computed once for all agents of a process.

    Parameters
    ----------
    compute
        Returns the plan of a proposal.
    """

    def __init__(self, compute: Callable[[Wanted], FleetPlan]) -> None:
        self._compute = compute
        self._plans: dict[Wanted, FleetPlan] = {}

    def get(self, wanted: Wanted) -> FleetPlan:
        """Return the plan of a proposal; equal proposals have the same."""
        if wanted not in self._plans:
            self._plans[wanted] = self._compute(wanted)
            while len(self._plans) > MOST_KEPT:
                del self._plans[next(iter(self._plans))]
        return self._plans[wanted]
