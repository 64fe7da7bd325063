# SPDX-License-Identifier: Apache-2.0
"""The fastest path within a budget is the optimum, and says so truly."""

import heapq
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from test.ground.grids import random_edges

from rocsafe_ground.errors import BeyondBudgetError, NoWayError
from rocsafe_ground.route.constrained import BoundedPath, RouteSearch, SearchEffort
from rocsafe_ground.route.edges import Edges, Searcher, edges_of

# Sums of some hundred terms in another order.
ROUNDING = 1e-7


def fastest_by_brute_force(edges: Edges, start: int, goal: int, budget: float) -> float:
    """Return the time of the best path: all labels that no other at the same cell dominates."""
    kept: dict[int, list[tuple[float, float]]] = {}
    heap = [(0.0, 0.0, start)]
    while heap:
        time, dose, cell = heapq.heappop(heap)
        if any(dose >= other for _, other in kept.get(cell, ())):
            continue
        kept.setdefault(cell, []).append((time, dose))
        if cell == goal:
            return time
        for m, offset in enumerate(edges.offsets.tolist()):
            total = dose + edges.doses_usv[cell, m]
            if total <= budget:
                heapq.heappush(heap, (time + edges.times_s[cell, m], total, cell + offset))
    return math.inf


def search_of(edges: Edges) -> RouteSearch:
    """Return the search from the first to the last cell."""
    return RouteSearch(Searcher(edges), 0, edges.cells - 1)


def budget_between(search: RouteSearch, share: float) -> float:
    """Return a budget between the cleanest and the fastest path, in logarithm."""
    low, high = search.cleanest.dose_usv, search.fastest.dose_usv
    return float(low * (high / low) ** share)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(40))
def test_route_equals_brute_force(seed):
    """On small grids, whatever the budget."""
    edges = random_edges(9, 11, seed)
    try:
        search = search_of(edges)
    except NoWayError:
        assert math.isinf(fastest_by_brute_force(edges, 0, edges.cells - 1, math.inf))
        return
    for share in (0.0, 0.2, 0.5, 0.8, 1.0):
        budget = budget_between(search, share) * (1.0 + 1e-9)
        found = search.within(budget)
        truth = fastest_by_brute_force(edges, 0, edges.cells - 1, budget)
        assert found.path.time_s == pytest.approx(truth, rel=ROUNDING)
        assert found.path.dose_usv <= budget * (1.0 + ROUNDING)
        assert found.gap_fraction == 0.0


@pytest.mark.slow
def test_dual_bounds_the_optimum_from_both_sides():
    """And the gap it states is not smaller than the true one."""
    for seed in range(10):
        search = search_of(random_edges(30, 30, seed))
        budget = budget_between(search, 0.4)
        dual = search.within(budget, SearchEffort(is_exact=False))
        optimum = search.within(budget).path.time_s
        assert dual.bound_s <= optimum * (1.0 + ROUNDING)
        assert optimum <= dual.path.time_s * (1.0 + ROUNDING)
        assert dual.path.dose_usv <= budget


def test_search_ends_at_the_gap_that_is_enough():
    """The path is within it of the optimum."""
    for seed in range(6):
        search = search_of(random_edges(30, 30, seed))
        budget = budget_between(search, 0.4)
        near = search.within(budget, SearchEffort(enough_gap=0.02))
        optimum = search.within(budget).path.time_s
        assert near.label_count == 0 or near.gap_fraction == 0.0
        assert optimum * (1.0 - ROUNDING) <= near.path.time_s <= optimum / (1.0 - 0.02)


@pytest.mark.slow
@pytest.mark.parametrize('is_exact', [False, True])
def test_bound_holds_whatever_gap_is_enough(is_exact):
    """What is left out is no better than that; the less is asked for, the less is searched."""
    counts = dict.fromkeys((0.0, 0.001, 0.01, 0.1), 0)
    for seed in range(25):
        search = search_of(random_edges(40, 40, seed, blocked=0.0))
        budget = budget_between(search, 0.1 + 0.03 * seed)
        optimum = search.within(budget).path.time_s
        for gap in counts:
            found = search.within(budget, SearchEffort(enough_gap=gap, is_exact=is_exact))
            assert found.bound_s <= optimum * (1.0 + ROUNDING)
            assert optimum * (1.0 - ROUNDING) <= found.path.time_s
            assert found.path.dose_usv <= budget * (1.0 + ROUNDING)
            assert not is_exact or found.gap_fraction <= gap + ROUNDING
            counts[gap] += found.label_count
    assert counts[0.01] <= 0.3 * counts[0.0]


def test_search_that_runs_out_of_labels_says_how_good_it_is():
    """It keeps the path of the dual and a bound that holds."""
    edges = random_edges(40, 40, 3, blocked=0.0)
    search = search_of(edges)
    budget = budget_between(search, 0.4)
    optimum = search.within(budget).path.time_s
    stopped = search.within(budget, SearchEffort(most_labels=200))
    assert stopped.bound_s <= optimum * (1.0 + ROUNDING) <= stopped.path.time_s * (1 + 1e-6)
    assert stopped.path.dose_usv <= budget


def test_shortest_trees_equal_those_of_scipy():
    """Also around blocked cells."""
    edges = random_edges(25, 20, 1, blocked=0.3)
    from_, m = np.nonzero(np.isfinite(edges.times_s))
    graph = coo_matrix(
        (edges.times_s[from_, m], (from_, from_ + edges.offsets[m])), shape=(edges.cells,) * 2
    )
    found = Searcher(edges).tree(0, (1.0, 0.0, 0.0)).costs
    assert found == pytest.approx(dijkstra(graph.tocsr(), indices=0), rel=ROUNDING)


def test_diagonal_step_does_not_cut_a_corner():
    """Both cells beside it must be free."""
    is_free = np.array([[True, False], [True, True]])
    edges = edges_of(is_free, np.ones((2, 2)), np.ones((2, 2)), 1.0)
    with_corner = Searcher(edges).tree(2, (1.0, 0.0, 0.0)).costs
    assert with_corner.tolist() == pytest.approx([1.0, math.inf, 0.0, 1.0])
    blocked = edges_of(is_free[::-1], np.ones((2, 2)), np.ones((2, 2)), 1.0)
    assert np.isinf(blocked.times_s[2]).sum() == 7


@pytest.mark.parametrize('distance_m', [2.0, 5.0])
def test_dose_of_a_straight_pass_is_that_of_the_closed_form(distance_m):
    """Of a point source, by 1 / r^2, within 1 % at cells of half a metre."""
    cell, speed, strength = 0.5, 0.8, 90_000.0
    x = np.arange(-40.0, 40.0 + cell / 2.0, cell)
    rates = (strength / (x**2 + distance_m**2))[None, :].repeat(2, axis=0)
    edges = edges_of(np.ones_like(rates, bool), np.full_like(rates, 1.0 / speed), rates, cell)
    dose = edges.path_of(np.arange(len(x))).dose_usv
    exact = 2.0 * strength / 3600.0 / (speed * distance_m) * math.atan(40.0 / distance_m)
    assert dose == pytest.approx(exact, rel=0.01)


def test_budget_below_the_cleanest_way_names_what_would_do():
    """In one line."""
    search = search_of(random_edges(12, 12, 0, blocked=0.0))
    least = search.cleanest.dose_usv
    with pytest.raises(BeyondBudgetError, match=f'the cleanest way takes {least:.4g} uSv'):
        search.within(0.5 * least)


def test_walled_goal_has_no_way():
    """Nothing is planned through a wall."""
    edges = random_edges(6, 6, 0, blocked=0.0)
    walled = replace(edges, times_s=np.full_like(edges.times_s, math.inf))
    with pytest.raises(NoWayError, match='no drivable ground'):
        search_of(walled)


@pytest.mark.parametrize(
    ('change', 'name'),
    [
        ({'cell_m': 0.0}, 'cell_m'),
        ({'slowness_spm': np.zeros((3, 3))}, 'slowness_spm'),
        ({'rates_usvh': np.full((3, 3), math.nan)}, 'rates_usvh'),
        ({'rates_usvh': np.full((3, 3), -1.0)}, 'rates_usvh'),
        ({'rates_usvh': np.ones((2, 3))}, 'one shape'),
    ],
)
def test_nonsense_has_no_edges(change, name):
    """Each refusal names the argument."""
    good = {
        'is_free': np.ones((3, 3), bool),
        'slowness_spm': np.ones((3, 3)),
        'rates_usvh': np.ones((3, 3)),
        'cell_m': 1.0,
    }
    with pytest.raises(ValueError, match=name):
        edges_of(**{**good, **change})


def test_dual_alone_is_a_whole_search():
    """Without prices nothing is joined; an exact search refuses that."""
    search = search_of(random_edges(30, 30, 1, blocked=0.0))
    budget = budget_between(search, 0.4)
    found = search.within(budget, SearchEffort(is_exact=False, prices=()))
    assert found.path.dose_usv <= budget
    assert found.bound_s <= search.within(budget).path.time_s * (1.0 + ROUNDING)
    with pytest.raises(ValueError, match='prices is empty'):
        SearchEffort(prices=())


def test_curve_of_trade_off_falls():
    """More dose never costs more time; its ends are the cleanest and the fastest path."""
    search = search_of(random_edges(40, 40, 7))
    curve: tuple[tuple[float, BoundedPath], ...] = search.trade_off(8)
    times = [found.path.time_s for _, found in curve]
    assert times == sorted(times, reverse=True)
    assert times[0] <= search.cleanest.time_s * (1.0 + ROUNDING)
    assert times[-1] == pytest.approx(search.fastest.time_s)
