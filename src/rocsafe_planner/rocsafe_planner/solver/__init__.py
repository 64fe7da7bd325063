# SPDX-License-Identifier: Apache-2.0
"""Routing core: routes whose longest is short, and a proof of how short any could be.

`solve` searches (simulated annealing with constant-time moves), `improving_bounds` proves. Neither
knows ROS, regions or cameras; everything is sites, legs and vehicles.
"""

from rocsafe_planner.solver.bounds.certificate import Bound, held_karp_bound, improving_bounds
from rocsafe_planner.solver.model.problem import (
    MatrixLegs,
    PointLegs,
    Routes,
    RoutingProblem,
    Vehicle,
    one_depot,
    route_cost,
    route_load,
)
from rocsafe_planner.solver.search.outcome import Progress, SearchOptions, Solution
from rocsafe_planner.solver.solve import solve

__all__ = [
    'Bound',
    'MatrixLegs',
    'PointLegs',
    'Progress',
    'Routes',
    'RoutingProblem',
    'SearchOptions',
    'Solution',
    'Vehicle',
    'held_karp_bound',
    'improving_bounds',
    'one_depot',
    'route_cost',
    'route_load',
    'solve',
]
