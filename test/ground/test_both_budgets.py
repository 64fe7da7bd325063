# SPDX-License-Identifier: Apache-2.0
"""Routes within budgets of dose and of toxic load equal those of brute force."""

import heapq
import math

import numpy as np
import pytest
from test.ground.grids import random_grid

from rocsafe_ground.errors import BeyondBudgetError, NoWayError
from rocsafe_ground.route.both_budgets import fastest_within
from rocsafe_ground.route.constrained import RouteSearch, SearchEffort
from rocsafe_ground.route.edges import Searcher, edges_of

ROUNDING = 1e-9


def gassed_edges(side, seed, blocked=0.15):
    """Return a random grid with a cloud of gas across it, besides its hot sources."""
    generator = np.random.default_rng([seed, 9])
    east, north = np.meshgrid(np.arange(side), np.arange(side))
    x, y = generator.uniform(0.2, 0.8, 2) * side
    loads = 1e-3 * np.exp(-((east - x) ** 2 + (north - y) ** 2) / (0.1 * side**2))
    return edges_of(*random_grid(side, side, seed, blocked), 1.0, loads)


def brute_force(edges, start, goal, budgets):
    """Return the least time of all paths within both budgets: labels, none pruned by bounds."""
    kept = {}
    heap = [(0.0, 0.0, 0.0, start)]
    while heap:
        time, dose, load, cell = heapq.heappop(heap)
        if any(d <= dose and x <= load for d, x in kept.get(cell, ())):
            continue
        kept.setdefault(cell, []).append((dose, load))
        if cell == goal:
            return time
        for m, offset in enumerate(edges.offsets.tolist()):
            more = dose + edges.doses_usv[cell, m], load + edges.loads[cell, m]
            if more[0] <= budgets[0] and more[1] <= budgets[1]:
                heapq.heappush(heap, (time + edges.times_s[cell, m], *more, cell + offset))
    return math.inf


def budgets_between(edges, start, goal, shares):
    """Return budgets between the least of each and what the fastest path takes."""
    searcher = Searcher(edges)
    paths = [
        edges.path_of(searcher.tree(start, weights).path_to(goal))
        for weights in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    ]
    dose = paths[1].dose_usv ** (1.0 - shares[0]) * paths[0].dose_usv ** shares[0]
    load = paths[2].load ** (1.0 - shares[1]) * paths[0].load ** shares[1]
    return dose * (1.0 + 1e-7), load * (1.0 + 1e-7)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(40))
def test_route_is_that_of_brute_force(seed):
    """For budgets between the extremes; where brute force finds none, none is found."""
    edges = gassed_edges(12, seed)
    searcher, ends = Searcher(edges), (0, edges.cells - 1)
    if math.isinf(searcher.tree(0, (1.0, 0.0, 0.0)).costs[ends[1]]):
        with pytest.raises(NoWayError):
            fastest_within(searcher, ends, (1e9, 1e9))
        return
    for shares in ((0.7, 0.7), (0.3, 0.8), (0.6, 0.2), (0.15, 0.15)):
        budgets = budgets_between(edges, *ends, shares)
        truth = brute_force(edges, *ends, tuple(one * (1.0 + ROUNDING) for one in budgets))
        if math.isinf(truth):
            with pytest.raises(BeyondBudgetError):
                fastest_within(searcher, ends, budgets)
            continue
        found = fastest_within(searcher, ends, budgets)
        assert found.path.time_s == pytest.approx(truth, rel=ROUNDING)
        assert found.path.dose_usv <= budgets[0] * (1.0 + 1e-8)
        assert found.path.load <= budgets[1] * (1.0 + 1e-8)
        assert found.gap_fraction == 0.0


def test_budget_of_load_that_does_not_bind_changes_nothing():
    """The route is that of the dose budget alone."""
    edges = gassed_edges(20, 1)
    searcher, ends = Searcher(edges), (0, edges.cells - 1)
    dose, _ = budgets_between(edges, *ends, (0.4, 1.0))
    alone = RouteSearch(searcher, *ends).within(dose)
    both = fastest_within(searcher, ends, (dose, 1e9))
    assert both.path.time_s == pytest.approx(alone.path.time_s, rel=ROUNDING)


def test_search_that_runs_out_of_labels_keeps_a_bound_that_holds():
    """And the dual alone is not better than the optimum."""
    edges = gassed_edges(30, 2, blocked=0.0)
    searcher, ends = Searcher(edges), (0, edges.cells - 1)
    budgets = budgets_between(edges, *ends, (0.6, 0.6))
    optimum = fastest_within(searcher, ends, budgets)
    for effort in (SearchEffort(most_labels=200), SearchEffort(is_exact=False)):
        found = fastest_within(searcher, ends, budgets, effort)
        assert found.bound_s <= optimum.path.time_s * (1.0 + ROUNDING)
        assert optimum.path.time_s <= found.path.time_s * (1.0 + ROUNDING)


@pytest.mark.parametrize(
    ('budgets', 'match'), [((1e-9, 1.0), 'cleanest way takes'), ((1e9, 1e-12), 'purest way takes')]
)
def test_budget_below_the_least_is_one_line(budgets, match):
    """With the least that would do."""
    edges = gassed_edges(12, 0, blocked=0.0)
    with pytest.raises(BeyondBudgetError, match=match):
        fastest_within(Searcher(edges), (0, edges.cells - 1), budgets)
