# SPDX-License-Identifier: Apache-2.0
"""The routing problem: customers, vehicles, and the cost of each leg for each vehicle."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray

Floats = NDArray[np.float64]
Routes = tuple[tuple[int, ...], ...]

OBJECTIVES = ('max', 'sum')


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PointLegs:
    """Legs flown in straight lines between points, with a stop at each point.

    A leg of d metres takes t(d) = d/v + v/a if d >= v**2/a, else 2*sqrt(d/a): from standstill to
    standstill with acceleration a and cruise speed v. t is concave, increasing and 0 at 0, hence a
    metric. Speed 1 and no limit of acceleration give plain metres.

    Raises
    ------
    ValueError
        If a speed or acceleration is not positive, or a stay is negative or not finite.
    """

    speed_mps: float = 1.0
    acceleration_mps2: float = np.inf
    stay: float = 0.0
    """Cost of serving one customer, in the unit of the legs."""

    def __post_init__(self) -> None:
        """Refuse impossible speeds, accelerations and stays."""
        for name in ('speed_mps', 'acceleration_mps2'):
            if not getattr(self, name) > 0:
                raise ValueError(f'{name} is {getattr(self, name)}: it must be positive')
        if not (np.isfinite(self.speed_mps) and np.isfinite(self.stay) and self.stay >= 0):
            raise ValueError(
                f'speed_mps {self.speed_mps} and stay {self.stay} must be finite, stay >= 0'
            )

    def pace(self) -> tuple[float, float, float, float]:
        """Return cost per metre, ramp cost, length of a leg that is all ramp, ramp factor."""
        ramp = self.speed_mps / self.acceleration_mps2
        factor = 2 / np.sqrt(self.acceleration_mps2)
        return 1 / self.speed_mps, ramp, self.speed_mps * ramp, float(factor)

    def costs(self, points: Floats, customers: int) -> Floats:
        """Return the cost of every leg, (sites, sites), with half of the stay at both ends."""
        apart = points[:, None, :] - points[None, :, :]
        distance = np.sqrt((apart * apart).sum(axis=2))
        slowness, ramp, short, factor = self.pace()
        cost = np.where(distance >= short, distance * slowness + ramp, factor * np.sqrt(distance))
        half = self.halves(len(points), customers)
        return cost + half[:, None] + half[None, :]

    def halves(self, sites: int, customers: int) -> Floats:
        """Return half of the cost of staying at each site."""
        half = np.zeros(sites)
        half[:customers] = self.stay / 2
        return half


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MatrixLegs:
    """Legs with given costs, in any unit; they may depend on direction (wind, detours).

    Raises
    ------
    ValueError
        If the matrix is not square, or holds a cost that is negative or not finite.
    """

    matrix: NDArray[np.floating]
    """(sites, sites): cost from the row's site to the column's."""

    def __post_init__(self) -> None:
        """Refuse a matrix that is not square, or holds a wrong cost."""
        shape = self.matrix.shape
        if len(shape) != 2 or shape[0] != shape[1]:
            raise ValueError(f'matrix has shape {shape}: it must be square')
        if not np.isfinite(self.matrix).all() or (self.matrix < 0).any():
            raise ValueError('matrix holds a cost that is negative or not finite')


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """Start, end, measure and limit of a vehicle's route.

    Raises
    ------
    ValueError
        If a cost or the limit is negative or not a number.
    """

    start: int
    """Site where the route starts."""
    end: int | None
    """Site where it ends; none: wherever the last customer is."""
    legs: int = 0
    """Which legs of the problem the objective counts."""
    fixed_cost: float = 0.0
    """Cost of a route that serves anybody, besides its legs (climb, descent)."""
    wait_cost: float = 0.0
    """Cost of a route that serves anybody, for waits for other routes; see `RoutingProblem`."""
    idle_cost: float = 0.0
    """Cost of a route that serves nobody (a vehicle that must fly home)."""
    limit: float = np.inf
    """Most that the legs may consume (endurance less what is fixed and reserved)."""
    limit_legs: int | None = None
    """Which legs count against the limit; none: those of the objective."""

    def __post_init__(self) -> None:
        """Refuse wrong costs and limits."""
        for name in ('fixed_cost', 'wait_cost', 'idle_cost', 'limit'):
            value = getattr(self, name)
            if not value >= 0 or (name != 'limit' and not np.isfinite(value)):
                raise ValueError(f'{name} is {value}: it must be finite and not negative')

    @property
    def limiting_legs(self) -> int:
        """Return which legs count against the limit."""
        return self.legs if self.limit_legs is None else self.limit_legs


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RoutingProblem:
    """Customers, each served exactly once by one of several vehicles.

    Sites are numbered from 0: first the customers, then whatever else the vehicles need (homes,
    present positions). The objective is 'max', the costliest route, or 'sum', all routes.

    Raises
    ------
    ValueError
        If the parts do not fit together, or no vehicle may serve some customer.
    """

    customers: int
    vehicles: tuple[Vehicle, ...]
    legs: tuple[PointLegs | MatrixLegs, ...] = (PointLegs(),)
    points: Floats | None = None
    """(sites, 2 or 3) coordinates in metres; needed by `PointLegs`."""
    allowed: BoolArray | None = None
    """(vehicles, customers) who may serve whom; none: anybody."""
    objective: str = 'max'
    apart: float = 0.0
    """What routes wait for each other: k routes at least k (k - 1) / 2 times this, all together.
    Bounds count it; the cost of a route has its `wait_cost` instead."""

    def __post_init__(self) -> None:
        """Refuse parts that do not fit together."""
        if self.objective not in OBJECTIVES:
            raise ValueError(f'objective is {self.objective!r}: it must be one of {OBJECTIVES}')
        if not self.vehicles or not self.legs:
            raise ValueError('vehicles and legs must not be empty')
        self._check_sites()
        self._check_allowed()

    def _check_sites(self) -> None:
        """Refuse numbers of sites and legs that do not exist."""
        if self.points is None and any(isinstance(legs, PointLegs) for legs in self.legs):
            raise ValueError('points is missing: PointLegs needs it')
        sites = self.sites
        if not 0 <= self.customers <= sites:
            raise ValueError(f'customers is {self.customers}: there are {sites} sites')
        if self.points is not None and not np.isfinite(self.points).all():
            raise ValueError('points holds a coordinate that is not finite')
        for legs in self.legs:
            if isinstance(legs, MatrixLegs) and len(legs.matrix) != sites:
                raise ValueError(f'a matrix has {len(legs.matrix)} sites, others {sites}')
        for vehicle in self.vehicles:
            ends = (vehicle.start, vehicle.start if vehicle.end is None else vehicle.end)
            if not (self.customers <= min(ends) and max(ends) < sites):
                raise ValueError(
                    f'a vehicle starts or ends at site {ends}: it must be one of '
                    f'{self.customers} to {sites - 1}, which are no customers'
                )
            if not 0 <= max(vehicle.legs, vehicle.limiting_legs) < len(self.legs):
                raise ValueError(f'a vehicle counts legs {vehicle.legs} of {len(self.legs)}')

    def _check_allowed(self) -> None:
        """Refuse a table of the wrong shape, and customers that no vehicle may serve."""
        if self.allowed is None:
            return
        shape = (len(self.vehicles), self.customers)
        if self.allowed.shape != shape:
            raise ValueError(f'allowed has shape {self.allowed.shape}: it must be {shape}')
        unserved = np.flatnonzero(~self.allowed.any(axis=0))
        if len(unserved):
            raise ValueError(f'no vehicle may serve customer {unserved[0]}')

    @property
    def places(self) -> Floats:
        """Return the coordinates of the sites of legs between points.

        Raises
        ------
        ValueError
            If there are none.
        """
        if self.points is None:
            raise ValueError('points is missing: PointLegs needs it')
        return self.points

    @property
    def sites(self) -> int:
        """Return the number of sites."""
        if self.points is not None:
            return len(self.points)
        return max(len(legs.matrix) for legs in self.legs if isinstance(legs, MatrixLegs))


def one_depot(
    points: Floats, depot: Floats, vehicles: int, legs: PointLegs | None = None
) -> RoutingProblem:
    """Return the problem of equal vehicles that start and end at one depot.

    Parameters
    ----------
    points
        (n, 2 or 3) customers in metres.
    depot
        (2,) or (3,) where every route starts and ends.
    vehicles
        Greatest number of routes.
    legs
        Costs of the legs; metres if not given.
    """
    sites = np.vstack([np.reshape(points, (-1, len(depot))), depot])
    home = len(sites) - 1
    return RoutingProblem(
        customers=home,
        vehicles=(Vehicle(start=home, end=home),) * vehicles,
        legs=(legs or PointLegs(),),
        points=sites,
    )


def leg_cost(problem: RoutingProblem, legs: int, origin: int, target: int | None) -> float:
    """Return the cost of one leg in double precision; a leg to `None` costs nothing."""
    kind = problem.legs[legs]
    if isinstance(kind, MatrixLegs):
        return 0.0 if target is None else float(kind.matrix[origin, target])
    half = kind.stay / 2
    total = half * (origin < problem.customers)
    if target is None:
        return total
    distance = float(np.linalg.norm(problem.places[origin] - problem.places[target]))
    slowness, ramp, short, factor = kind.pace()
    flown = distance * slowness + ramp if distance >= short else factor * distance**0.5
    return total + half * (target < problem.customers) + flown


def path_cost(problem: RoutingProblem, legs: int, vehicle: Vehicle, route: Sequence[int]) -> float:
    """Return the cost of the legs of a route, recomputed from the problem alone."""
    if not route:
        return 0.0
    stops = [vehicle.start, *route]
    total = sum(leg_cost(problem, legs, a, b) for a, b in pairwise(stops))
    return total + leg_cost(problem, legs, stops[-1], vehicle.end)


def route_cost(problem: RoutingProblem, vehicle: int, route: Sequence[int]) -> float:
    """Return the cost of a route for its vehicle."""
    who = problem.vehicles[vehicle]
    if not route:
        return who.idle_cost
    return who.fixed_cost + who.wait_cost + path_cost(problem, who.legs, who, route)


def route_load(problem: RoutingProblem, vehicle: int, route: Sequence[int]) -> float:
    """Return the load of a route, which counts against the limit of its vehicle."""
    who = problem.vehicles[vehicle]
    return path_cost(problem, who.limiting_legs, who, route)
