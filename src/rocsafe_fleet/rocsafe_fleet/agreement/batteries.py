# SPDX-License-Identifier: Apache-2.0
"""Batteries of the vehicles, where the plan of the survey keeps a part of them for the search."""

from dataclasses import dataclass, replace

from rocsafe_geo.limits import require_between, require_positive
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.vehicle import Vehicle


@dataclass(frozen=True, slots=True, kw_only=True)
class Battery:
    """The battery of a vehicle.

    Attributes
    ----------
    name
        Of the vehicle.
    endurance_s
        Flight time of the full battery, seconds.
    usable_s
        What plans after the first may use of it.
    """

    name: str
    endurance_s: float
    usable_s: float

    def __post_init__(self) -> None:
        require_positive('endurance_s', self.endurance_s, 's')
        require_between('usable_s', self.usable_s, 0.0, self.endurance_s, 's')


@dataclass(frozen=True, slots=True, kw_only=True)
class Batteries:
    """The batteries of a fleet."""

    vehicles: tuple[Battery, ...] = ()

    def endurance_s(self, vehicle: Vehicle) -> float:
        """Return the flight time of the full battery of a vehicle."""
        found = [one.endurance_s for one in self.vehicles if one.name == vehicle.name]
        return found[0] if found else vehicle.endurance_s

    def freed(self, survey: SurveyPlan) -> SurveyPlan:
        """Return the plan of a survey whose continuations may use all that is usable."""
        usable_s = {one.name: one.usable_s for one in self.vehicles}

        def own(vehicle: Vehicle) -> Vehicle:
            return replace(vehicle, endurance_s=usable_s.get(vehicle.name, vehicle.endurance_s))

        request = survey.request
        return replace(
            survey,
            request=replace(request, vehicles=tuple(map(own, request.vehicles))),
            routes=tuple(replace(route, vehicle=own(route.vehicle)) for route in survey.routes),
        )
