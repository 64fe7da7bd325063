# SPDX-License-Identifier: Apache-2.0
"""A fleet's problem and its objective in the terms of the solver.

Sites are numbered alike: points, homes, ends. Time, metres or energy of a leg is what it costs;
half of what a stay at each of its ends costs goes with it. Endurance limits the time of each
route, unless batteries are swapped: then routes are cut afterwards.
"""

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion import MotionLimits, leg_duration_s
from rocsafe_planner.plan.survey_options import PEAK_OBJECTIVES
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_planner.routing.queues import interval_s, waits_s, worthwhile
from rocsafe_planner.solver import MatrixLegs, PointLegs, RoutingProblem
from rocsafe_planner.solver import Vehicle as RoutedVehicle

Legs = PointLegs | MatrixLegs

MOST_EXACT_SITES = 4000
"""Most sites with a table of times of all pairs: 4000 sites take 128 MB."""
MOST_TERRAIN_SITES = 1000
"""The same over a terrain, where a million legs take some seconds."""
MOST_CLOSED_SITES = 800
"""Most sites whose legs are checked for shorter detours; above, fewer bounds hold."""
LEAST_RAMP_S = 1e-6
"""Shorter ramps are ignored."""


def routing_problem(
    problem: FleetProblem, objective: str, *, is_bounded: bool = False
) -> RoutingProblem:
    """Return the problem that the solver is given for an objective of `OBJECTIVES`.

    With `is_bounded`, no flights cost less than its routes, for bounds of the time alone: legs
    become shorter if they are estimates, or too many for a table with the triangle inequality.
    """
    table = LegTable(problem, is_bounded)
    vehicles = tuple(_vehicle(problem, k, table, objective) for k in range(len(problem.vehicles)))
    apart_s, allowed = 0.0, problem.may_visit
    if objective == 'longest_time':
        apart_s, flying = interval_s(problem), worthwhile(problem)
        # Who stays on the ground would wait longer than all others.
        waits = dict.fromkeys(range(len(vehicles)), apart_s * len(vehicles))
        in_turn = waits_s(problem, flying)
        waits |= {k: in_turn[k] for k in flying}
        vehicles = tuple(
            dataclasses.replace(vehicle, wait_cost=waits[k]) for k, vehicle in enumerate(vehicles)
        )
        if not is_bounded and len(flying) < len(vehicles):
            allowed = np.zeros((len(vehicles), len(problem.points)), dtype=bool)
            allowed[flying] = True
    return RoutingProblem(
        customers=len(problem.points),
        vehicles=vehicles,
        legs=tuple(table.legs),
        points=problem.sites,
        allowed=allowed,
        objective='max' if objective in PEAK_OBJECTIVES else 'sum',
        apart=apart_s,
    )


class LegTable:
    """Kinds of legs of a problem, each computed once.

    Parameters
    ----------
    problem
        Whose sites the legs join.
    is_bounded
        Whether no flight may undercut their costs, see `routing_problem`.

    Attributes
    ----------
    problem
        As given.
    legs
        All kinds that were asked for, by their numbers.
    place_of
        For each site the first of those at its place, see `same_places`.
    """

    def __init__(self, problem: FleetProblem, is_bounded: bool = False) -> None:
        self.problem = problem
        self._is_bounded = is_bounded
        self.place_of = same_places(problem)
        self._numbers: dict[tuple[object, ...], int] = {}
        self.legs: list[Legs] = []
        self._is_plain = problem.legs_are_plain

    def time(self, vehicle: int) -> int:
        """Return the index of the legs whose cost is a vehicle's time."""
        spec = self.problem.vehicles[vehicle]
        flight = self.problem.flight(vehicle)
        return self._of((flight, spec.hover_s), lambda: self._time(vehicle))

    def length(self) -> int:
        """Return the index of the legs whose cost is their length."""
        return self._of(('length',), self._length)

    def energy(self, vehicle: int) -> int:
        """Return the index of the legs whose cost is a vehicle's energy, watt seconds."""
        spec = self.problem.vehicles[vehicle]
        powers = (spec.cruise_power_w, spec.hover_power_w)
        flight = self.problem.flight(vehicle)
        return self._of((flight, spec.hover_s, *powers), lambda: self._energy(vehicle))

    def _of(self, key: tuple[object, ...], make: Callable[[], Legs]) -> int:
        if key not in self._numbers:
            self._numbers[key] = len(self.legs)
            self.legs.append(make())
        return self._numbers[key]

    @property
    def _is_estimated(self) -> bool:
        """Whether legs are too many for a table: they count as if they were level and calm."""
        problem = self.problem
        most = MOST_EXACT_SITES if problem.relief is None else MOST_TERRAIN_SITES
        return problem.detours is None and len(problem.sites) > most

    def _time(self, vehicle: int) -> Legs:
        problem, spec = self.problem, self.problem.vehicles[vehicle]
        most = MOST_CLOSED_SITES if self._is_plain else MOST_EXACT_SITES
        if self._is_bounded and len(problem.sites) > most:
            return self._trapezoids(problem.flight(vehicle).fastest(), spec.hover_s)
        if self._is_estimated:
            performance = problem.flight(vehicle).performance
            return self._trapezoids(performance.fastest(), spec.hover_s)
        if self._is_bounded and problem.flight(vehicle).passes:
            return MatrixLegs(matrix=passed_legs_s(problem, vehicle))
        return MatrixLegs(matrix=self._durations(vehicle) + self._stays(spec.hover_s))

    def _trapezoids(self, fastest: MotionLimits, stay: float, power_w: float = 1.0) -> PointLegs:
        """Return legs without jerk that cost the same where they reach their speed, else less.

        With T(v) for the ramp to speed v, these take d/v + T(v), or 2 sqrt(d T(v)/v): less than
        legs with jerk because T(v)/v falls with v. What is proven of them holds of those, and of
        legs that climb, or that the wind holds up. With a power they cost energy.
        """
        far_m = 1e6
        speed = fastest.cruise_speed_mps
        ramp_s = max(leg_duration_s(far_m, fastest) - far_m / speed, 0.0)
        acceleration = speed / ramp_s if ramp_s > LEAST_RAMP_S else math.inf
        return PointLegs(
            speed_mps=speed / power_w, acceleration_mps2=acceleration / power_w**2, stay=stay
        )

    def share(self, vehicle: int) -> float:
        """Return about which part of a flight's time legs that are estimates cost."""
        legs, problem = self.legs[self.time(vehicle)], self.problem
        if isinstance(legs, MatrixLegs) or self._is_bounded or self._is_plain:
            return 1.0
        along = np.arange(len(problem.points))
        flown = float(problem.legs_s(vehicle, along[:-1], along[1:]).sum())
        slowness, ramp, short, factor = legs.pace()
        lengths = problem.legs_m(along[:-1], along[1:])
        reckoned = np.where(lengths >= short, lengths * slowness + ramp, factor * lengths**0.5)
        return min(1.0, float(reckoned.sum()) / flown) if flown > 0.0 else 1.0

    def _length(self) -> Legs:
        detours = self.problem.detours
        return PointLegs() if detours is None else MatrixLegs(matrix=detours.length_m)

    def _energy(self, vehicle: int) -> Legs:
        spec = self.problem.vehicles[vehicle]
        if self._is_estimated:
            fastest = self.problem.flight(vehicle).performance.fastest()
            stay = spec.hover_power_w * spec.hover_s
            return self._trapezoids(fastest, stay, spec.cruise_power_w)
        moving = spec.cruise_power_w * self._durations(vehicle)
        return MatrixLegs(matrix=moving + self._stays(spec.hover_power_w * spec.hover_s))

    def _durations(self, vehicle: int) -> FloatArray:
        every = np.arange(len(self.problem.sites))
        return self.problem.legs_s(vehicle, every[:, None], every[None, :])

    def _stays(self, cost: float) -> FloatArray:
        half = np.zeros(len(self.problem.sites))
        half[: len(self.problem.points)] = 0.5 * cost
        stays: FloatArray = half[:, None] + half[None, :]
        return stays


def passed_legs_s(problem: FleetProblem, vehicle: int) -> FloatArray:
    """Return times of all legs whose sums no flight that passes its viewpoints undercuts.

    At a passed viewpoint its two legs overlap for at most the ramp of either, and half of either.
    A flight stands where it begins, stops at its last viewpoint, and stands where it ends.
    """
    points, times = len(problem.points), problem.stopping_legs_s(vehicle)
    ramp_s = problem.flight(vehicle).performance.longest_ramp_s
    overlaps = 0.5 * np.minimum(ramp_s, 0.5 * times)
    there = overlaps.copy()
    np.fill_diagonal(there, np.inf)
    legs = times - 2.0 * overlaps
    legs[points:, :points] += overlaps[points:, :points]
    legs[:points, points:] = times[:points, points:] + there[:, :points].min(axis=0)[:, None]
    return np.asarray(legs)


def _vehicle(
    problem: FleetProblem, vehicle: int, table: LegTable, objective: str
) -> RoutedVehicle:
    spec, climb_s = problem.vehicles[vehicle], problem.first_fixed_s(vehicle)
    time, end = table.time(vehicle), problem.end_site(vehicle)
    legs, fixed = priced(spec, vehicle, table, objective, climb_s)
    return RoutedVehicle(
        start=table.place_of[problem.start_site(vehicle)],
        end=None if end is None else table.place_of[end],
        legs=legs,
        fixed_cost=fixed,
        idle_cost=idle_cost(problem, vehicle, objective),
        limit=_limit_s(spec, climb_s + rest_s(spec, table.legs[time])) * table.share(vehicle),
        limit_legs=time,
    )


def same_places(problem: FleetProblem) -> list[int]:
    """Return for each site the first of those where routes begin or end at its place.

    Vehicles that stand together are alike to the search only if they begin at the same site.
    """
    places = np.column_stack([problem.sites, problem.ups_m]).tolist()
    first: dict[tuple[float, ...], int] = {}
    return [
        site if site < len(problem.points) else first.setdefault(tuple(place), site)
        for site, place in enumerate(places)
    ]


def priced(
    spec: Vehicle, vehicle: int, table: LegTable, objective: str, climb_s: float
) -> tuple[int, float]:
    """Return the legs that an objective counts, and what a flight of `climb_s` costs besides."""
    if objective.endswith('distance'):
        return table.length(), 0.0
    legs = table.energy(vehicle) if objective == 'energy' else table.time(vehicle)
    left_s = rest_s(spec, table.legs[legs])
    if objective == 'energy':
        return legs, climb_s * spec.cruise_power_w + left_s * spec.hover_power_w
    return legs, climb_s + left_s


def rest_s(spec: Vehicle, legs: Legs) -> float:
    """Return the part of the stays that the legs of a route do not contain.

    In a matrix, each leg contains half of the stay at either end. An open route has no leg after
    its last point, so that half of the last stay is missing.
    """
    return 0.5 * spec.hover_s if spec.is_open and isinstance(legs, MatrixLegs) else 0.0


def idle_cost(problem: FleetProblem, vehicle: int, objective: str) -> float:
    """Return the cost of a vehicle in the air that visits no point: its flight to the landing."""
    if objective.endswith('distance'):
        return problem.length_m(vehicle, [])
    power_w = problem.vehicles[vehicle].cruise_power_w if objective == 'energy' else 1.0
    return problem.duration_s(vehicle, []) * power_w


def _limit_s(spec: Vehicle, fixed_s: float) -> float:
    """Return the largest time of legs and stays; infinite if batteries are swapped."""
    if spec.battery_swap_s is not None:
        return math.inf
    return max(0.0, spec.first_endurance_s - fixed_s)
