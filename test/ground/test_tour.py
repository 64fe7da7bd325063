# SPDX-License-Identifier: Apache-2.0
"""The round trip through points is as good as the exhaustive one, and names what does not fit."""

import itertools
import math

import numpy as np
import pytest
from test.ground.grids import random_edges

from rocsafe_ground.errors import BeyondBudgetError
from rocsafe_ground.route.edges import Searcher
from rocsafe_ground.tour.orders import EXACT_POINTS, ExactOrders, SearchedOrders, trip_cost
from rocsafe_ground.tour.tour import TourSearch
from rocsafe_ground.tour.trip import Budgets, TourPoint

SIDE = 40
AMPLE = 1e9


def search_of(seed, count=5, priorities=None, **point):
    """Return a search with random points on an open grid."""
    weights = np.ones(count) if priorities is None else priorities
    edges = random_edges(SIDE, SIDE, seed, blocked=0.0)
    cells = np.random.default_rng([seed, 1]).choice(SIDE * SIDE, count + 1, replace=False)
    points = [
        TourPoint(cell=int(cell), priority=float(weight), **point)
        for cell, weight in zip(cells[1:], weights, strict=True)
    ]
    return TourSearch(Searcher(edges), int(cells[0]), points)


def cost_of_best(costs, points):
    """Return the cost of the cheapest round trip, of all orders."""
    return min(trip_cost(costs, order) for order in itertools.permutations(points))


@pytest.mark.slow
@pytest.mark.parametrize('kind', [ExactOrders, SearchedOrders])
@pytest.mark.parametrize('seed', range(5))
def test_order_equals_the_exhaustive_one(seed, kind):
    """For sets of up to six points, both ways; the bound is not above it."""
    generator = np.random.default_rng(seed)
    places = generator.uniform(0, 9, (7, 2))
    costs = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    found = kind(costs)
    for chosen in (0b111111, 0b101101, 0b1000):
        best = cost_of_best(costs, [k + 1 for k in range(6) if chosen >> k & 1])
        assert found.cost(chosen) == pytest.approx(best)
        assert trip_cost(costs, found.order(chosen)) == pytest.approx(best)
        assert 0.9 * best < found.bound(chosen) <= best * (1.0 + 1e-9)


def test_order_equals_the_exhaustive_one_where_the_trip_ends_elsewhere():
    """The way back is another: costs depend on direction."""
    generator = np.random.default_rng(7)
    costs = generator.uniform(1, 9, (7, 7))
    costs = 0.5 * (costs + costs.T)
    costs[1:, 0] = generator.uniform(1, 9, 6)
    best = cost_of_best(costs, range(1, 7))
    for found in (ExactOrders(costs), SearchedOrders(costs)):
        assert found.cost(0b111111) == pytest.approx(best)
        assert found.bound(0b111111) <= best * (1.0 + 1e-9)


@pytest.mark.slow
def test_many_points_are_within_their_bound():
    """More than the exact order takes: within 3 % of what no order is below, all of them visited.

    And the same trip again.
    """
    count = 2 * EXACT_POINTS
    search = search_of(0, count)
    full = (1 << count) - 1
    budget = math.sqrt(search.cleanest_usv(full) * search.fastest(full).dose_usv)
    trip = search.best(Budgets(dose_usv=budget))
    assert sorted(trip.order) == list(range(count))
    assert trip.dose_usv <= budget * (1.0 + 1e-9)
    assert trip.gap_fraction < 0.05
    assert search_of(0, count).best(Budgets(dose_usv=budget)).order == trip.order


@pytest.mark.slow
def test_many_points_that_do_not_all_fit_are_chosen_nearly_as_well_as_of_all_sets(monkeypatch):
    """By greed: the sum of priorities beside that of the exhaustive choice, ten times 8 points."""
    ratios = []
    for seed in range(10):
        priorities = np.random.default_rng([seed, 2]).uniform(0.2, 1.0, 8)
        exact = search_of(seed, 8, priorities)
        budgets = Budgets(dose_usv=0.6 * exact.cleanest_usv(0xFF), time_s=AMPLE)
        best = exact.best(budgets)
        with monkeypatch.context() as patch:
            patch.setattr('rocsafe_ground.tour.orders.EXACT_POINTS', 3)
            greedy = search_of(seed, 8, priorities).best(budgets)
        assert greedy.dose_usv <= budgets.dose_usv * (1.0 + 1e-9)
        ratios.append(sum(priorities[list(greedy.order)]) / sum(priorities[list(best.order)]))
    assert max(ratios) <= 1.0 + 1e-9
    assert np.mean(ratios) > 0.95
    assert min(ratios) > 0.8


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(6))
def test_trip_is_within_the_budget_and_its_bound(seed):
    """Bound <= time, by little even on so coarse a grid; with less budget it is slower."""
    search = search_of(seed)
    low, high = search.cleanest_usv(0b11111), search.fastest(0b11111).dose_usv
    before = 0.0
    for share in (1.0, 0.6, 0.3, 0.0):
        budget = low ** (1 - share) * high**share
        trip = search.best(Budgets(dose_usv=budget * (1 + 1e-9), time_s=AMPLE))
        assert sorted(trip.order) == list(range(5))
        assert trip.dose_usv <= budget * (1.0 + 1e-6)
        assert trip.bound_s <= trip.time_s * (1.0 + 1e-9)
        assert trip.time_s >= before * (1.0 - 1e-9)
        before = trip.time_s
        assert trip.gap_fraction < 0.05
        ends = [leg.cells for leg in trip.legs]
        assert all(a[-1] == b[0] for a, b in itertools.pairwise(ends))
        assert ends[0][0] == ends[-1][-1]


def test_dwell_counts():
    """In time and in dose."""
    plain = search_of(1).best(Budgets(dose_usv=AMPLE, time_s=AMPLE))
    long = search_of(1, dwell_s=60.0, dwell_usv=2.0).best(Budgets(dose_usv=AMPLE, time_s=AMPLE))
    assert long.time_s == pytest.approx(plain.time_s + 300.0)
    assert long.dose_usv == pytest.approx(plain.dose_usv + 10.0)


def test_points_that_do_not_fit_are_named_with_the_budget_that_admits_them():
    """The worthiest set stays; with the budget named a further point is visited."""
    search = search_of(2)
    budget = 0.7 * search.cleanest_usv(0b11111)
    trip = search.best(Budgets(dose_usv=budget, time_s=AMPLE))
    assert 0 < len(trip.order) < 5
    assert len(trip.left_out) == 5 - len(trip.order)
    doses = {point: search.cleanest_usv(trip.chosen | 1 << point) for point in trip.left_out}
    point = min(doses, key=lambda one: doses[one])
    dose = doses[point]
    assert dose > budget
    more = search.best(Budgets(dose_usv=dose * (1 + 1e-9), time_s=AMPLE))
    assert len(more.order) > len(trip.order)
    assert point not in trip.order


def test_budgets_too_small_for_any_point_are_refused():
    """Of dose and of time."""
    search = search_of(3)
    least = min(search.cleanest_usv(1 << k) for k in range(5))
    with pytest.raises(BeyondBudgetError, match='too small'):
        search.best(Budgets(dose_usv=0.999 * least, time_s=AMPLE))
    assert search.best(Budgets(dose_usv=1.001 * least, time_s=AMPLE)).order
    with pytest.raises(BeyondBudgetError, match='too small'):
        search.best(Budgets(dose_usv=AMPLE, time_s=1.0))
