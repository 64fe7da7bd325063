# SPDX-License-Identifier: Apache-2.0
"""The routing problem in the plane, and its time model.

A vehicle climbs to the survey height at home, flies legs from standstill to standstill, hovers at
each viewpoint, returns at the survey height and descends. It stops wherever a leg bends around an
exclusion. A vehicle without viewpoints stays on the ground.

Sites are numbered: the n points, then the homes of the m vehicles, then their ends.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_planner.airspace import Detours
from rocsafe_planner.flight_time import FlightTime
from rocsafe_planner.vehicle import Vehicle

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]
Order = list[int]
"""Indices of points in flying order."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FleetProblem:
    """Points to visit by a fleet; places are (east, north) in metres.

    Attributes
    ----------
    homes, ends
        Where each vehicle starts and lands, shape (m, 2); without `ends` it lands at home. Where
        a vehicle `is_open`, its end means nothing: it lands at its last viewpoint.
    points
        Shape (n, 2).
    height_m
        To climb to and to descend from.
    wind_mps
        (east, north) that the air moves towards.
    detours
        Shortest paths among all sites; None: legs are straight.
    may_visit
        Which vehicle has the sensors for which point, shape (m, n); None: each for all.
    grid_rad
        Direction of the rows that the points lie in, if they do: 0 = east, anticlockwise.
    """

    vehicles: tuple[Vehicle, ...]
    homes: FloatArray
    points: FloatArray
    height_m: float
    ends: FloatArray | None = None
    wind_mps: tuple[float, float] = (0.0, 0.0)
    detours: Detours | None = None
    may_visit: BoolArray | None = None
    grid_rad: float = 0.0

    @property
    def sites(self) -> FloatArray:
        """Places of all sites, shape (n + 2 m, 2)."""
        return np.vstack([self.points, self.homes, self.homes if self.ends is None else self.ends])

    def flight(self, vehicle: int) -> FlightTime:
        """Return the times of a vehicle's straight flights."""
        return FlightTime(self.vehicles[vehicle].motion, self.wind_mps)

    def allowed(self, vehicle: int) -> BoolArray:
        """Return which points a vehicle has the sensors for, shape (n,)."""
        if self.may_visit is None:
            return np.ones(len(self.points), dtype=bool)
        return self.may_visit[vehicle]

    def home_site(self, vehicle: int) -> int:
        """Return the site where a vehicle starts."""
        return len(self.points) + vehicle

    def end_site(self, vehicle: int) -> int | None:
        """Return the site where a vehicle lands, None if that is its last viewpoint."""
        if self.vehicles[vehicle].is_open:
            return None
        return len(self.points) + len(self.vehicles) + vehicle

    def distances_m(self, site: int) -> FloatArray:
        """Return the lengths of the legs from one site to all, shape (n + 2 m,)."""
        if self.detours is not None:
            return self.detours.length_m[site]
        sites = self.sites
        return distances_m(sites, sites[site])

    def legs_m(self, origins: IndexArray, targets: IndexArray) -> FloatArray:
        """Return the lengths of legs between sites."""
        if self.detours is not None:
            lengths: FloatArray = self.detours.length_m[origins, targets]
            return lengths
        sites = self.sites
        return distances_m(sites[targets], sites[origins])

    def legs_s(self, vehicle: int, origins: IndexArray, targets: IndexArray) -> FloatArray:
        """Return the times that a vehicle needs for legs between sites, without hovering."""
        if self.detours is not None:
            return self.detours.duration_s(origins, targets, self.flight(vehicle))
        sites = self.sites
        return self.flight(vehicle)(sites[targets] - sites[origins])

    def fixed_s(self, vehicle: int) -> float:
        """Return the time of climb and descent of a vehicle that flies."""
        return self.vehicles[vehicle].vertical_s(self.height_m)

    def stops(self, vehicle: int, order: Sequence[int]) -> IndexArray:
        """Return the sites of a flight that visits points in order, from home to its end."""
        end = self.end_site(vehicle)
        last = [] if end is None else [end]
        return np.array([self.home_site(vehicle), *order, *last], dtype=np.intp)

    def length_m(self, vehicle: int, order: Sequence[int]) -> float:
        """Return the horizontal length of a flight from home to its end; 0 for an empty one."""
        if not len(order):
            return 0.0
        stops = self.stops(vehicle, order)
        return float(self.legs_m(stops[:-1], stops[1:]).sum())

    def duration_s(self, vehicle: int, order: Sequence[int]) -> float:
        """Return the time from take-off to touch-down; 0 for an empty flight."""
        if not len(order):
            return 0.0
        stops = self.stops(vehicle, order)
        flying = float(self.legs_s(vehicle, stops[:-1], stops[1:]).sum())
        return self.fixed_s(vehicle) + flying + len(order) * self.vehicles[vehicle].hover_s

    def bends(self, origin: int, target: int) -> FloatArray:
        """Return where the leg between two sites bends, shape (k, 2)."""
        return np.zeros((0, 2)) if self.detours is None else self.detours.bends(origin, target)


def distances_m(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the plane distances of points (..., 2) that broadcast."""
    difference = a - b
    distance: FloatArray = np.hypot(difference[..., 0], difference[..., 1])
    return distance
