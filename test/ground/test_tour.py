# SPDX-License-Identifier: Apache-2.0
"""The round trip through points is as good as the exhaustive one, and names what does not fit."""

import itertools
import math

import numpy as np
import pytest
from test.ground.grids import random_edges

from rocsafe_ground.errors import BeyondBudgetError
from rocsafe_ground.route.edges import Searcher
from rocsafe_ground.tour.orders import round_trips
from rocsafe_ground.tour.tour import Budgets, TourPoint, TourSearch

SIDE = 40
AMPLE = 1e9


def search_of(seed, count=5, **point):
    """Return a search with random points on an open grid."""
    edges = random_edges(SIDE, SIDE, seed, blocked=0.0)
    cells = np.random.default_rng([seed, 1]).choice(SIDE * SIDE, count + 1, replace=False)
    points = [TourPoint(cell=int(cell), **point) for cell in cells[1:]]
    return TourSearch(Searcher(edges), int(cells[0]), points)


@pytest.mark.parametrize('seed', range(5))
def test_order_equals_the_exhaustive_one(seed):
    """For every set of up to six points."""
    generator = np.random.default_rng(seed)
    times, doses = generator.uniform(1, 9, (2, 7, 7))
    price = 0.7
    found = round_trips(times, doses, price)
    cost = times + price * doses
    for chosen in (0b111111, 0b101101, 0b1000):
        points = [k + 1 for k in range(6) if chosen >> k & 1]
        best = min(
            sum(cost[a, b] for a, b in itertools.pairwise((0, *order, 0)))
            for order in itertools.permutations(points)
        )
        assert found.costs[chosen] == pytest.approx(best)
        order = (0, *found.order(chosen), 0)
        assert sum(times[a, b] for a, b in itertools.pairwise(order)) == pytest.approx(
            found.times_s[chosen]
        )


@pytest.mark.parametrize('seed', range(6))
def test_trip_is_within_the_budget_and_its_bound(seed):
    """Bound <= time, by little even on so coarse a grid; with less budget it is slower."""
    search = search_of(seed)
    clean, quick = search.trips(math.inf), search.trips(0.0)
    before = 0.0
    for share in (1.0, 0.6, 0.3, 0.0):
        budget = float(clean.doses_usv[-1] ** (1 - share) * quick.doses_usv[-1] ** share)
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
    clean = search.trips(math.inf)
    budget = 0.7 * float(clean.doses_usv[-1])
    trip = search.best(Budgets(dose_usv=budget, time_s=AMPLE))
    assert 0 < len(trip.order) < 5
    assert len(trip.left_out) == 5 - len(trip.order)
    doses = {point: search.least_dose(trip.chosen | 1 << point) for point in trip.left_out}
    point = min(doses, key=lambda one: doses[one])
    dose = doses[point]
    assert dose > budget
    more = search.best(Budgets(dose_usv=dose * (1 + 1e-9), time_s=AMPLE))
    assert len(more.order) > len(trip.order)
    assert point not in trip.order


def test_budget_too_small_for_any_point_is_one_line_with_the_least():
    """Of dose and of time."""
    search = search_of(3)
    least = float(search.trips(math.inf).doses_usv[1:].min())
    with pytest.raises(BeyondBudgetError, match=f'takes {least:.4g} uSv'):
        search.best(Budgets(dose_usv=0.5 * least, time_s=AMPLE))
    with pytest.raises(BeyondBudgetError, match='endurance of 1 s is too short'):
        search.best(Budgets(dose_usv=AMPLE, time_s=1.0))
