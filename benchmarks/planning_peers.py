# SPDX-License-Identifier: Apache-2.0
"""What others make of a min-max routing problem with one depot: longest route in metres.

OR-Tools and PyVRP are optional: ``pip install -r requirements/benchmarks.txt``. Both calculate
with whole numbers; the routes they return are measured with the exact distances.
"""

import importlib
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from planning_instances import AbsentError, Floats

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_planner.routing.methods import METHODS

SCALE = 100.0
"""Whole units a metre."""
SPAN_COEFFICIENT = 100
BISECTIONS = 6


def longest(points: Floats, routes: list[list[int]]) -> float:
    """Return the length of the longest closed route; site 0 is the depot."""
    paths = [points[[0, *route, 0]] for route in routes]
    return max(float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) for path in paths)


def simple_method(name: str) -> Callable[[Floats, int, float], float]:
    """Return a method of the planner's own table as a peer; it takes no time."""

    def run(points: Floats, vehicles: int, _budget_s: float) -> float:
        drone = Vehicle(
            name='drone',
            home=GeoPosition(0.0, 0.0, 0.0),
            cruise_speed_mps=1.0,
            acceleration_mps2=1e9,
            climb_rate_mps=1e3,
            descent_rate_mps=1e3,
            hover_s=0.0,
            endurance_s=1e9,
        )
        problem = FleetProblem(
            vehicles=(drone,) * vehicles,
            homes=np.repeat(points[:1], vehicles, axis=0),
            points=points[1:],
            height_m=1.0,
        )
        orders = METHODS[name](problem)
        return longest(points, [[i + 1 for i in order] for order in orders])

    return run


def or_tools(points: Floats, vehicles: int, budget_s: float) -> float:
    """Return what OR-Tools finds: arc cost and span cost, guided local search."""
    solver = _library('ortools.constraint_solver.pywrapcp')
    enums = _library('ortools.constraint_solver.routing_enums_pb2')
    matrix = _whole_distances(points)
    manager = solver.RoutingIndexManager(len(points), vehicles, 0)
    model = solver.RoutingModel(manager)
    transit = model.RegisterTransitMatrix(matrix.tolist())
    model.SetArcCostEvaluatorOfAllVehicles(transit)
    model.AddDimension(transit, 0, int(matrix.max()) * len(points), True, 'length')
    model.GetDimensionOrDie('length').SetGlobalSpanCostCoefficient(SPAN_COEFFICIENT)
    options = solver.DefaultRoutingSearchParameters()
    options.first_solution_strategy = enums.FirstSolutionStrategy.PATH_CHEAPEST_ARC
    options.local_search_metaheuristic = enums.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    options.time_limit.FromMilliseconds(int(budget_s * 1000))
    found = model.SolveWithParameters(options)
    if found is None:
        return float('nan')
    return longest(points, [_or_tools_route(manager, model, found, k) for k in range(vehicles)])


def _or_tools_route(manager: Any, model: Any, found: Any, vehicle: int) -> list[int]:
    route, index = [], found.Value(model.NextVar(model.Start(vehicle)))
    while not model.IsEnd(index):
        route.append(manager.IndexToNode(index))
        index = found.Value(model.NextVar(index))
    return route


def py_vrp(points: Floats, vehicles: int, budget_s: float) -> float:
    """Return what PyVRP finds when the greatest distance allowed is bisected."""
    _library('pyvrp')
    matrix = _whole_distances(points)
    low, high = 2.0 * float(matrix[0].max()), float(matrix[0].sum() + matrix.max())
    best = float('nan')
    began = time.monotonic()
    cap = 2.0 * float(np.sort(matrix + np.diag([matrix.max()] * len(matrix)))[:, 0].sum())
    high = min(high, max(low, cap))
    for step in range(BISECTIONS):
        left = budget_s - (time.monotonic() - began)
        middle = low + (high - low) / (vehicles if step == 0 else 2)
        routes = _py_vrp_within(matrix, vehicles, int(middle), left / (BISECTIONS - step))
        if routes is None:
            low = middle
            continue
        value = longest(points, routes)
        best, high = value if not best <= value else best, min(value * SCALE, middle)
    return best


def _py_vrp_within(
    matrix: NDArray[np.int64], vehicles: int, cap: int, budget_s: float
) -> list[list[int]] | None:
    """Return routes of at most `cap` each, None if none are found in time."""
    pyvrp = _library('pyvrp')
    stop = _library('pyvrp.stop')
    model = pyvrp.Model()
    places = [model.add_location(x=0, y=0) for _ in range(len(matrix))]
    model.add_depot(places[0])
    for place in places[1:]:
        model.add_client(place)
    model.add_vehicle_type(vehicles, max_distance=cap)
    for i, origin in enumerate(places):
        for j, target in enumerate(places):
            if i != j:
                model.add_edge(origin, target, distance=int(matrix[i, j]))
    result = model.solve(stop=stop.MaxRuntime(max(budget_s, 0.1)), display=False)
    if not result.is_feasible():
        return None
    return [_py_vrp_route(route) for route in result.best.routes()]


def _py_vrp_route(route: Any) -> list[int]:
    return [stop.idx + 1 for stop in route.schedule() if stop.is_client()]


def _whole_distances(points: Floats) -> NDArray[np.int64]:
    """Return distances in whole units, rounded."""
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.asarray(np.rint(apart * SCALE), np.int64)


def _library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise AbsentError(f'{name.split(".")[0]} is not installed') from error


PEERS: dict[str, Callable[[Floats, int, float], float]] = {
    "paper's greedy": simple_method('paper_greedy'),
    'equal split': simple_method('boustrophedon_equal'),
    'min-max split': simple_method('boustrophedon_minmax'),
    'strips': simple_method('strips'),
    'OR-Tools': or_tools,
    'PyVRP': py_vrp,
}
"""By the name in the table: points (depot first), vehicles, seconds -> longest route."""
INSTANT = ("paper's greedy", 'equal split', 'min-max split', 'strips')
