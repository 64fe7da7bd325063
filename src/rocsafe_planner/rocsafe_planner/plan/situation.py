# SPDX-License-Identifier: Apache-2.0
"""Situation of a fleet after the start of a plan."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.survey_options import UnheardVehicle
from rocsafe_planner.plan.vehicle import Aloft


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """What became of a plan.

    Attributes
    ----------
    alive
        Names of the vehicles that can go on: in the air with their places and the time used on
        their batteries; a number of seconds for those that stand at home with batteries used so
        long; None for those with full ones.
    visited
        Ids of the viewpoints that are photographed.
    new_places
        More places to photograph from, given on the ground below; their ids follow on those of
        the plan.
    new_exclusions
        More zones that no leg crosses. Viewpoints inside cannot be visited any more.
    unheard
        Vehicles in the air of which nobody hears, see `Continuation`.
    last
        Ids of viewpoints that each vehicle visits after all its others, if batteries do for that:
        somebody who is not heard may be about to visit them.
    """

    alive: Mapping[str, Aloft | float | None]
    visited: frozenset[int] = frozenset()
    new_places: tuple[GeoPosition, ...] = ()
    new_exclusions: tuple[SurveyArea, ...] = field(default=())
    unheard: tuple[UnheardVehicle, ...] = ()
    last: frozenset[int] = frozenset()
