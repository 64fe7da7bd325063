# SPDX-License-Identifier: Apache-2.0
"""The certificate: no bound ever exceeds the optimum, and on known problems it comes close."""

import itertools

import numpy as np
import pytest

from rocsafe_planner.solver import held_karp_bound, improving_bounds, one_depot

from . import tiny_routing

LOOKS = 40


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(200, 220))
def test_no_bound_exceeds_the_optimum(seed):
    """Every bound of mixed problems, from every argument, against the best plan of all."""
    objective = 'sum' if seed % 3 == 2 else 'max'
    problem = tiny_routing.random_problem(seed, 5, 2 + seed % 2, objective)
    best = tiny_routing.optimum(problem)
    bounds = list(itertools.islice(improving_bounds(problem, best), LOOKS))
    assert max(bound.value for bound in bounds) <= best * (1 + 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(12))
def test_bounds_of_one_depot_hold(seed):
    """The same for plain problems, where every argument applies; Held-Karp too."""
    points = np.random.default_rng(seed).uniform(0, 100, (6, 2))
    problem = one_depot(points[:-1] if seed % 2 else points, np.full(2, 50.0), 2)
    best = tiny_routing.optimum(problem)
    bounds = list(itertools.islice(improving_bounds(problem, best), LOOKS))
    assert {'farthest', 'spacing'} & {bound.name for bound in bounds}
    assert 0.6 * best < max(bound.value for bound in bounds) <= best * (1 + 1e-9)
    assert held_karp_bound(problem, best) <= best * (1 + 1e-9)


def test_bounds_only_grow():
    """What is yielded later is at least as good."""
    points = np.random.default_rng(1).uniform(0, 100, (50, 2))
    bounds = list(itertools.islice(improving_bounds(one_depot(points, points[0], 4), 500.0), 60))
    values = [bound.value for bound in bounds]
    assert values == sorted(values)


def test_the_grid_of_the_paper_is_bounded_within_one_and_a_half_percent():
    """20 x 20 points, five vehicles from a corner: 84.4 is proven at once, 85.63 can be flown."""
    points = np.array([(x, y) for x in range(20) for y in range(20)], float)
    problem = one_depot(points[1:], points[0], 5)
    best = max(bound.value for bound in itertools.islice(improving_bounds(problem, 85.63), 4))
    assert 84.4 < best < 85.63


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(8))
def test_bounds_of_small_grids_hold(seed):
    """Where all neighbours are equally far, the shells' bounds come close and never too close."""
    rng = np.random.default_rng(seed)
    cells = rng.permutation(9)[:6]
    points = np.column_stack([cells % 3, cells // 3]).astype(float)
    problem = one_depot(points, np.array([-float(rng.integers(1, 5)), 0.0]), 2 + seed % 2)
    best = tiny_routing.optimum(problem)
    bounds = list(itertools.islice(improving_bounds(problem, best), LOOKS))
    assert 0.75 * best < max(bound.value for bound in bounds) <= best * (1 + 1e-9)
