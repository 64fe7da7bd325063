# SPDX-License-Identifier: Apache-2.0
"""Bounds from prices: never above the optimum, near to what is flown, the same each time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_planner.planning import plan_survey
from rocsafe_planner.routing import bound as bounding
from rocsafe_planner.routing.costs import finish_s
from rocsafe_planner.solver import PointLegs, SearchOptions, one_depot, solve
from rocsafe_planner.solver.bounds.walk_prices import PriceOptions, price_bounds
from rocsafe_planner.solver.bounds.walks import (
    best_ends,
    chain_flights,
    collect,
    count_visits,
)

from . import tiny_routing
from .fleets import problem, request, vehicle


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(300, 315))
def test_no_bound_exceeds_the_optimum(seed):
    """Of mixed fleets with limits, one-way legs and customers that few may serve."""
    problem = tiny_routing.random_problem(seed, 5, 2 + seed % 2, 'max')
    best = tiny_routing.optimum(problem)
    known = best if np.isfinite(best) else 1e3
    bounds = list(price_bounds(problem, known))
    assert bounds == sorted(bounds)
    assert max(bounds, default=0.0) <= best * (1 + 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize('vehicles', [2, 5])
def test_a_survey_is_bounded_within_four_percent(vehicles):
    """Where the forest alone leaves more than 8 %."""
    points = np.random.default_rng(3).uniform(0.0, 200.0, (40, 2))
    legs = PointLegs(speed_mps=8.0, acceleration_mps2=3.0, stay=2.0)
    problem = one_depot(points, np.array([-40.0, 30.0]), vehicles, legs)
    found = solve(problem, SearchOptions(proposals=400_000))
    bounds = [list(price_bounds(problem, found.value)) for _ in range(2)]
    assert bounds[0] == bounds[1]
    assert found.value > 1.08 * found.bound.value
    assert bounds[0][-1] <= found.value <= 1.04 * bounds[0][-1]


def test_legs_shorter_than_a_step_have_no_bound():
    """Rounded down they would cost nothing, and walks would not end."""
    points = np.array([[0.0, 0.0], [1e-6, 0.0], [500.0, 0.0]])
    assert list(price_bounds(one_depot(points, np.zeros(2), 2), 1000.0)) == []


def test_too_much_work_is_not_begun():
    """A bound from a few rounds would be worth less than the time."""
    points = np.random.default_rng(1).uniform(0.0, 100.0, (50, 2))
    problem = one_depot(points, points[0], 2)
    assert list(price_bounds(problem, 500.0, PriceOptions(work=1e6))) == []


@given(st.integers(0, 10_000))
def test_what_is_collected_is_the_most_of_all_walks(seed):
    """Against all walks without i, j, i; and the walk found collects what is said."""
    rng = np.random.default_rng(seed)
    n, moments = 3, 9
    legs = rng.integers(1, 4, (n, n)).astype(np.int32)
    first, last = (rng.integers(0, 4, n).astype(np.int32) for _ in range(2))
    price = rng.uniform(0.0, 1.0, n)
    prizes, before = np.empty((2, moments, n)), np.empty((2, moments, n), np.int32)
    collected = np.empty(moments)
    collect(legs, first, last, price, prizes[0], before[0], prizes[1], before[1], collected)
    most = np.zeros(moments)

    def walk(i, time, prize, previous):
        if time >= moments:
            return
        most[time + last[i] :] = np.maximum(most[time + last[i] :], prize)
        for j in range(n):
            if j not in (i, previous):
                walk(j, time + legs[i, j], prize + price[j], i)

    for i in range(n):
        walk(i, first[i], price[i], -1)
    assert collected == pytest.approx(most)
    ends, times = best_ends(prizes[0], last, moments - 1, 1)
    visits = np.empty((len(ends), n), np.int32)
    count_visits(legs, before[0], before[1], ends, times, visits)
    assert (visits @ price).max(initial=0.0) == pytest.approx(most[-1])


@given(st.integers(0, 10_000))
def test_flights_are_chained_as_well_as_can_be(seed):
    """Against all sequences of flights with changes between them."""
    rng = np.random.default_rng(seed)
    moments, change = 9, int(rng.integers(1, 4))
    first, further = np.cumsum(rng.integers(0, 3, (2, moments)), axis=1).astype(float)
    first[0] = further[0] = 0.0
    best, flown = np.empty(moments), np.empty(moments, np.int32)
    chain_flights(first, best, further, change, best, flown)

    def most(left, prize_of):
        after = [
            prize_of[s] + most(left - s - change, further)
            for s in range(left + 1)
            if left - s - change >= 0
        ]
        return max([prize_of[left], *after])

    assert best.tolist() == [most(t, first) for t in range(moments)]


@pytest.mark.slow
@pytest.mark.parametrize('count', [1, 2])
def test_each_change_of_a_battery_is_counted(count):
    """Eight far places, two a battery: what vehicles collect by a time is whole flights."""
    spec = {'endurance_s': 142.0, 'battery_swap_s': 60.0, 'hover_s': 20.0}
    fleet = tuple(vehicle(f'rav{k}', **spec) for k in range(count))
    world = problem([(300.0 + 5.0 * k, 0.0) for k in range(8)], [(0.0, 0.0)] * count, fleet)
    each = 8 // count
    orders = [list(range(k * each, (k + 1) * each)) for k in range(count)]
    known = finish_s(world, orders)
    routed = bounding.routing_problem(world, 'longest_time', is_bounded=True)
    changes = bounding.battery_changes(world)
    assert max(price_bounds(routed, known)) < 0.8 * known
    assert 0.98 * known < max(price_bounds(routed, known, None, changes)) <= known


@pytest.mark.slow
def test_a_plan_of_the_solver_is_proven_by_prices():
    """By default; a method without a search is bounded as fast as it plans."""
    proven = plan_survey(request(method='solver'))
    assert proven.lower_bound_method == 'prices'
    assert proven.gap_fraction < 0.03
    greedy = plan_survey(request())
    assert greedy.lower_bound_method not in ('prices', 'none')
