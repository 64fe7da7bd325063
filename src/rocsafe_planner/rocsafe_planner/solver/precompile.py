# SPDX-License-Identifier: Apache-2.0
"""Compile all kernels and keep them: ``python -m rocsafe_planner.solver.precompile``.

The set-up runs this, so that the first plan of a new user does not wait for the compiler.
"""

import dataclasses
import functools
import shutil
import sys

import numpy as np

from rocsafe_planner.solver.bounds.certificate import improving_bounds
from rocsafe_planner.solver.bounds.forest import SPARSE_FROM
from rocsafe_planner.solver.bounds.walk_prices import price_bounds
from rocsafe_planner.solver.model.compiled import CACHE_PREFIX, cache_directory
from rocsafe_planner.solver.model.flatten import tables_of
from rocsafe_planner.solver.model.problem import RoutingProblem, Vehicle, one_depot
from rocsafe_planner.solver.search.outcome import SearchOptions
from rocsafe_planner.solver.search.population import Lane, Manner
from rocsafe_planner.solver.solve import plan_of, solve

_QUICK = SearchOptions(proposals=1, bound_share=0.0)


def compile_kernels() -> None:
    """Call every kernel once, with arguments of the only types that they are ever given."""
    points = np.random.default_rng(0).uniform(0, 100, (SPARSE_FROM + 1, 2))
    problem = one_depot(points[:9], points[0], 2)
    routes = solve(problem, _QUICK).routes
    lane = Lane(tables_of(problem), 1.0, 0, 0, 0.0)
    manner = Manner(hot=0.0, cold=-1.0, floor=0.2, width=0.02, sharper=0.0, ruins=0, long=0)
    lane.cross(plan_of(routes), plan_of(routes), [0], manner)
    home = Vehicle(start=2, end=2)
    # Nobody serves both neighbours of any order: no order can be cut, customers are assigned.
    picky = np.array([[True, False], [False, True]])
    solve(
        RoutingProblem(customers=2, vehicles=(home, home), points=points[:3], allowed=picky),
        _QUICK,
    )
    for _ in zip(range(6), improving_bounds(one_depot(points, points[0], 2), 0.0), strict=False):
        pass
    next(price_bounds(dataclasses.replace(problem, apart=1.0), 1e3))


@functools.cache
def load_kernels() -> None:
    """Load the machine code of all kernels, once, if it was compiled before: it takes a second."""
    if cache_directory().is_dir():
        compile_kernels()


def main() -> int:
    """Compile, and remove what earlier versions of the sources left."""
    compile_kernels()
    present = cache_directory()
    for folder in present.parent.glob(f'{CACHE_PREFIX}*'):
        if folder != present:
            shutil.rmtree(folder, ignore_errors=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
