# SPDX-License-Identifier: Apache-2.0
"""The plan: routes, times, coverage and bounds."""

import math
from dataclasses import dataclass, field

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.plan.viewpoint import Viewpoint

__all__ = ['Bends', 'Route', 'Sortie', 'SurveyPlan', 'Viewpoint']

Bends = tuple[GeoPosition, ...]
"""Places at which a leg changes its direction, in flying order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sortie:
    """One flight: home, climb, viewpoints in order, home or the vehicle's end, land.

    `bends` has one entry a leg: that to each viewpoint, then that to where it lands. An open
    flight lands at its last viewpoint and has no last leg.
    """

    viewpoints: tuple[Viewpoint, ...]
    bends: tuple[Bends, ...]
    length_m: float
    duration_s: float
    energy_wh: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """The flights of one vehicle, with battery swaps at home between; may be empty.

    Attributes
    ----------
    delay_s
        Waiting time on the ground before the first take-off.
    flight_height_m
        Above the ground, of all that it flies.
    ground_altitude_m
        Of the ground at home where the ground is not level, against which the altitudes of
        viewpoints and bends count; NaN: level.
    landing_height_m
        Above home, of the flight over where it lands; NaN: `flight_height_m`.
    """

    vehicle: Vehicle
    sorties: tuple[Sortie, ...]
    delay_s: float = 0.0
    flight_height_m: float = math.nan
    ground_altitude_m: float = math.nan
    landing_height_m: float = math.nan

    @property
    def viewpoints(self) -> tuple[Viewpoint, ...]:
        """Viewpoints of all flights in flying order."""
        return tuple(viewpoint for sortie in self.sorties for viewpoint in sortie.viewpoints)

    @property
    def length_m(self) -> float:
        """Horizontal length of all flights."""
        return sum((sortie.length_m for sortie in self.sorties), 0.0)

    @property
    def duration_s(self) -> float:
        """Time from the first take-off to the last touch-down, battery swaps included."""
        swaps = max(0, len(self.sorties) - 1) * (self.vehicle.battery_swap_s or 0.0)
        return sum((sortie.duration_s for sortie in self.sorties), 0.0) + swaps

    @property
    def finish_s(self) -> float:
        """Time from the start of the mission to the last touch-down; 0 if it does not fly."""
        return self.delay_s + self.duration_s if self.sorties else 0.0

    @property
    def energy_wh(self) -> float:
        """Electric energy of all flights."""
        return sum((sortie.energy_wh for sortie in self.sorties), 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyPlan:
    """Routes of all vehicles, in the order of the request, with figures of quality.

    Attributes
    ----------
    plan_id
        Identifier of the request: equal requests have equal ids and equal plans.
    spacing_m, spacing_along_m
        Between neighbouring viewpoints in the direction of the image's width and height.
    lower_bound_s, lower_bound_method
        Lower bound of the makespan for these viewpoints and vehicles, and its method.
    objective_bound
        Lower bound of the request's objective, in its unit; NaN: not known.
    region_area_m2, forbidden_area_m2
        Area of the regions, and of their part in exclusions.
    covered_area_m2, largest_hole_m2
        Area of the rest of the regions that photographs show, and of the largest connected part of
        it that none shows.
    minimum_separation_m
        Least distance of any two vehicles in the air; infinite if no two ever are.
    near_unheard
        Names of the vehicles that climb, descend or fly within the separation of where a vehicle
        may be of which nobody hears, because no layer avoids it.
    left_out
        Ids of viewpoints of the rest of a survey that the batteries do not do for.
    """

    plan_id: str
    request: SurveyRequest
    routes: tuple[Route, ...]
    spacing_m: float
    spacing_along_m: float
    lower_bound_s: float
    lower_bound_method: str
    region_area_m2: float
    covered_area_m2: float
    objective_bound: float = math.nan
    largest_hole_m2: float = 0.0
    minimum_separation_m: float = field(default=float('inf'))
    near_unheard: tuple[str, ...] = ()
    left_out: tuple[int, ...] = ()
    forbidden_area_m2: float = 0.0

    @property
    def makespan_s(self) -> float:
        """Time from the start of the mission until the last vehicle has landed."""
        return max(route.finish_s for route in self.routes)

    @property
    def longest_route_m(self) -> float:
        """Length of the longest route."""
        return max(route.length_m for route in self.routes)

    @property
    def total_length_m(self) -> float:
        """Length of all routes together."""
        return sum(route.length_m for route in self.routes)

    @property
    def total_duration_s(self) -> float:
        """Duration of all routes together."""
        return sum(route.duration_s for route in self.routes)

    @property
    def total_energy_wh(self) -> float:
        """Electric energy of all routes together."""
        return sum(route.energy_wh for route in self.routes)

    @property
    def gap_fraction(self) -> float:
        """Greatest relative excess of the makespan over the best possible one."""
        return self.makespan_s / self.lower_bound_s - 1.0 if self.lower_bound_s > 0.0 else 0.0

    @property
    def covered_fraction(self) -> float:
        """Part of the ground outside exclusions that photographs show; 1 if all is forbidden."""
        open_m2 = self.region_area_m2 - self.forbidden_area_m2
        return self.covered_area_m2 / open_m2 if open_m2 > 0.0 else 1.0

    @property
    def viewpoint_count(self) -> int:
        """Number of viewpoints on all routes."""
        return sum(len(route.viewpoints) for route in self.routes)
