# SPDX-License-Identifier: Apache-2.0
"""Routing problems small enough to try every plan, and costs counted without the solver's code."""

import itertools
import math

import numpy as np

from rocsafe_planner.solver import MatrixLegs, PointLegs, RoutingProblem, Vehicle


def leg(problem, legs, origin, target):
    """Return the cost of one leg, from the definition of the time model."""
    kind = problem.legs[legs]
    if isinstance(kind, MatrixLegs):
        return float(kind.matrix[origin, target])
    distance = math.dist(problem.points[origin], problem.points[target])
    v, a = kind.speed_mps, kind.acceleration_mps2
    reaches_cruise = math.isinf(a) or distance >= v * v / a
    flown = distance / v + v / a if reaches_cruise else 2 * math.sqrt(distance / a)
    stays = (origin < problem.customers) + (target < problem.customers)
    return flown + stays * kind.stay / 2


def legs_cost(problem, legs, vehicle, route):
    """Return what the legs of a route cost; an open route pays its last stay in full."""
    stops = [vehicle.start, *route, *([] if vehicle.end is None else [vehicle.end])]
    total = sum(leg(problem, legs, a, b) for a, b in itertools.pairwise(stops))
    kind = problem.legs[legs]
    if vehicle.end is None and isinstance(kind, PointLegs):
        total += kind.stay / 2
    return total


def cost(problem, number, route):
    """Return what a route costs its vehicle."""
    vehicle = problem.vehicles[number]
    if not route:
        return vehicle.idle_cost
    return vehicle.fixed_cost + legs_cost(problem, vehicle.legs, vehicle, route)


def load(problem, number, route):
    """Return what a route consumes of its vehicle's limit."""
    vehicle = problem.vehicles[number]
    kind = vehicle.legs if vehicle.limit_legs is None else vehicle.limit_legs
    return legs_cost(problem, kind, vehicle, route) if route else 0.0


def value(problem, routes):
    """Return the objective of a plan."""
    costs = [cost(problem, number, route) for number, route in enumerate(routes)]
    return max(costs) if problem.objective == 'max' else sum(costs)


def faults(problem, routes):
    """Return what is wrong with a plan, endurance included."""
    found = []
    if sorted(itertools.chain(*routes)) != list(range(problem.customers)):
        found.append('not every customer exactly once')
    if len(routes) != len(problem.vehicles):
        found.append('not one route a vehicle')
    for number, route in enumerate(routes):
        if problem.allowed is not None and not problem.allowed[number, list(route)].all():
            found.append(f'vehicle {number} serves whom it may not')
        if load(problem, number, route) > problem.vehicles[number].limit * (1 + 1e-6):
            found.append(f'vehicle {number} exceeds its limit')
    return found


def optimum(problem):
    """Return the least objective of all plans without faults, by trying every one; inf if none."""
    crew = range(len(problem.vehicles))
    best_of = {}
    for size in range(problem.customers + 1):
        for group in itertools.combinations(range(problem.customers), size):
            best_of[group] = [_best_order(problem, number, group) for number in crew]
    best = math.inf
    for owners in itertools.product(crew, repeat=problem.customers):
        groups = [tuple(c for c, owner in enumerate(owners) if owner == v) for v in crew]
        costs = [best_of[group][v] for v, group in enumerate(groups)]
        best = min(best, max(costs) if problem.objective == 'max' else sum(costs))
    return best


def _best_order(problem, number, group):
    if problem.allowed is not None and not problem.allowed[number, list(group)].all():
        return math.inf
    limit = problem.vehicles[number].limit
    orders = [
        order for order in itertools.permutations(group) if load(problem, number, order) <= limit
    ]
    return min((cost(problem, number, order) for order in orders), default=math.inf)


def random_problem(seed, customers=5, vehicles=2, objective='max', limited=False):
    """Return a mixed problem: metric or wind legs, depots, open routes, sensors, speeds."""
    rng = np.random.default_rng(seed)
    places = 1 + int(rng.integers(1, 4))
    points = rng.uniform(0, 100, (customers + places, int(rng.integers(2, 4))))
    if rng.random() < 0.2:
        points = np.round(points, -1)
    fleet = []
    legs = [_legs(rng, points) for _ in range(int(rng.integers(1, 3)))]
    for _ in range(vehicles):
        start, end = (int(site) for site in rng.integers(customers, customers + places, 2))
        end = [start, end, None][rng.integers(3)]
        open_allowed = not any(isinstance(kind, MatrixLegs) for kind in legs)
        kind = int(rng.integers(len(legs)))
        fleet.append(
            Vehicle(
                start=start,
                end=end if open_allowed or end is not None else start,
                legs=kind,
                fixed_cost=float(rng.integers(0, 2) * 10),
                idle_cost=float(rng.integers(0, 2) * 5),
                limit=float(rng.uniform(1.0, 2.0) * 100) if limited else math.inf,
            )
        )
    allowed = rng.random((vehicles, customers)) < 0.7
    allowed[rng.integers(vehicles, size=customers), np.arange(customers)] = True
    return RoutingProblem(
        customers=customers,
        vehicles=tuple(fleet),
        legs=tuple(legs),
        points=points,
        allowed=allowed if rng.random() < 0.4 else None,
        objective=objective,
    )


def _legs(rng, points):
    if rng.random() < 0.3:
        apart = np.linalg.norm(points[:, None] - points[None], axis=2)
        return MatrixLegs(matrix=apart * rng.uniform(0.7, 1.5, apart.shape))
    return PointLegs(
        speed_mps=float(rng.uniform(0.5, 3.0)),
        acceleration_mps2=float(rng.choice([0.2, 2.0, math.inf])),
        stay=float(rng.choice([0.0, 2.0])),
    )
