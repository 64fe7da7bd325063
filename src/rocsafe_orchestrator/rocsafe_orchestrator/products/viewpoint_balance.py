# SPDX-License-Identifier: Apache-2.0
"""Viewpoints of all plans of a run, and whether they were photographed.

Both numbers count places. A photograph counts for the place that it was taken at, so that neither
a second photograph of a place nor a further plan makes more places photographed than planned.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from rocsafe_geo.position import distance_m
from rocsafe_orchestrator.products.run_record import Photograph
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.viewpoint import Viewpoint

# A hundredth of a metre: the same viewpoint in a plan and in the plan of its rest.
_PLACE_DIGITS = 7

Place = tuple[int, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewpointBalance:
    """Number of viewpoints of all plans, and how many of them were photographed."""

    planned: int
    photographed: int

    def __post_init__(self) -> None:
        if not 0 <= self.photographed <= self.planned:
            raise ValueError(
                f'photographed is {self.photographed}: must be 0 to planned, {self.planned}'
            )

    @property
    def missing(self) -> int:
        """Number of viewpoints without a photograph."""
        return self.planned - self.photographed


def viewpoint_balance(
    plans: Iterable[SurveyPlan], photographs: Iterable[Photograph]
) -> ViewpointBalance:
    """Return how many viewpoints of `plans` were photographed."""
    places: dict[int, dict[Place, Viewpoint]] = defaultdict(dict)
    for plan in plans:
        for route in plan.routes:
            for viewpoint in route.viewpoints:
                places[viewpoint.id][_place(viewpoint)] = viewpoint
    seen = {
        min(found, key=lambda place: distance_m(found[place].position, shot.position))
        for shot in photographs
        if (found := places.get(shot.viewpoint_id))
    }
    return ViewpointBalance(planned=sum(map(len, places.values())), photographed=len(seen))


def places_of(*plans: SurveyPlan) -> frozenset[Place]:
    """Return the viewpoints of plans, each once."""
    return frozenset(
        _place(viewpoint)
        for plan in plans
        for route in plan.routes
        for viewpoint in route.viewpoints
    )


def _place(viewpoint: Viewpoint) -> Place:
    position = viewpoint.position
    return (
        viewpoint.id,
        round(position.latitude_deg, _PLACE_DIGITS),
        round(position.longitude_deg, _PLACE_DIGITS),
    )
