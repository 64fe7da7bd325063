# SPDX-License-Identifier: Apache-2.0
"""The answer of the planner, as values."""

from dataclasses import dataclass

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.request import SurveyRequest
from rocsafe_planner.vehicle import Vehicle


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewpoint:
    """A place at which a photograph is taken.

    `position` is the camera's, its altitude NaN if no home's altitude is known; `yaw_rad` is 0
    for a nose that points east, anticlockwise positive; `footprint` are the corners of the ground
    that the photograph shows, anticlockwise.
    """

    id: int
    position: GeoPosition
    height_agl_m: float
    yaw_rad: float
    footprint: tuple[GeoPosition, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """What one vehicle flies: home, climb, viewpoints in order, home, land; empty: nothing."""

    vehicle: Vehicle
    viewpoints: tuple[Viewpoint, ...]
    length_m: float
    duration_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyPlan:
    """Routes of all vehicles, in the order of the request, and how good they are.

    Attributes
    ----------
    plan_id
        Names the request: the same request gives the same id, and the same plan.
    spacing_m, spacing_along_m
        Between neighbouring viewpoints in the direction of the image's width and height.
    lower_bound_s, lower_bound_method
        No plan for these viewpoints and vehicles has a shorter makespan, and what proved it.
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

    @property
    def makespan_s(self) -> float:
        """Duration of the route that takes longest."""
        return max(route.duration_s for route in self.routes)

    @property
    def longest_route_m(self) -> float:
        """Length of the longest route."""
        return max(route.length_m for route in self.routes)

    @property
    def total_length_m(self) -> float:
        """Length of all routes together."""
        return sum(route.length_m for route in self.routes)

    @property
    def gap_fraction(self) -> float:
        """By how much the makespan may exceed the best possible one."""
        return self.makespan_s / self.lower_bound_s - 1.0 if self.lower_bound_s > 0.0 else 0.0

    @property
    def covered_fraction(self) -> float:
        """Part of the region inside at least one footprint."""
        return self.covered_area_m2 / self.region_area_m2

    @property
    def viewpoint_count(self) -> int:
        """Number of viewpoints on all routes."""
        return sum(len(route.viewpoints) for route in self.routes)
