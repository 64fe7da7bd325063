# SPDX-License-Identifier: Apache-2.0
"""The lower bound never exceeds the best plan there is."""

import dataclasses
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.motion.autopilot import DIRECT, Autopilot
from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.routing.bound import lower_bound
from rocsafe_planner.routing.costs import finish_s
from rocsafe_planner.routing.methods import nearest_to_shortest
from rocsafe_planner.routing.solver_method import optimised
from rocsafe_planner.routing.tours.tour_splitting import makespan_s
from rocsafe_planner.solver.bounds.walk_prices import PriceOptions

from .fleets import problem, vehicle

PLACES = st.tuples(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0))
# Rounding of sums of some thousand seconds.
ROUNDING_S = 1e-9


@st.composite
def fleets(draw):
    """Draw vehicles that differ in everything, with homes anywhere."""
    return tuple(
        vehicle(
            f'rav{k}',
            cruise_speed_mps=draw(st.floats(1.0, 20.0)),
            acceleration_mps2=draw(st.floats(0.5, 5.0)),
            climb_rate_mps=draw(st.floats(0.5, 5.0)),
            hover_s=draw(st.just(0.0) | st.floats(0.1, 20.0)),
            autopilot=draw(st.sampled_from((DIRECT, Autopilot()))),
        )
        for k in range(draw(st.integers(1, 3)))
    )


def best_makespan(world):
    """Return the optimum: all assignments, all orders."""
    count, vehicles = len(world.points), range(len(world.vehicles))
    best_route = {
        (k, subset): min(world.duration_s(k, order) for order in permutations(subset))
        for k in vehicles
        for subset in {tuple(i for i in range(count) if mask >> i & 1) for mask in range(2**count)}
    }
    return min(
        max(best_route[k, tuple(i for i in range(count) if owner[i] == k)] for k in vehicles)
        for owner in product(vehicles, repeat=count)
    )


def bound_of(world):
    """Return the bound, steered by a real plan's makespan."""
    orders = nearest_to_shortest(world)
    makespan = max(world.duration_s(k, order) for k, order in enumerate(orders))
    return lower_bound(world, makespan, lambda _bound: True, PriceOptions())


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.lists(PLACES, min_size=1, max_size=4), fleets(), st.data())
def test_bound_holds_against_brute_force(points, vehicles, data):
    """On every small world, also with unequal vehicles and scattered homes."""
    homes = [data.draw(PLACES) for _ in vehicles]
    world = problem(points, homes, vehicles)
    assert bound_of(world).makespan_s <= best_makespan(world) + ROUNDING_S


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(st.lists(PLACES, min_size=1, max_size=3), fleets(), st.data())
def test_bounds_hold_in_wind_and_anywhere(points, vehicles, data):
    """In wind, to ends elsewhere or open, from the air: this bound, and that of the search."""
    vehicles = tuple(
        dataclasses.replace(
            v,
            is_open=data.draw(st.booleans()),
            aloft=Aloft(position=v.home) if data.draw(st.booleans()) else None,
        )
        for v in vehicles
    )
    places = [np.array([data.draw(PLACES) for _ in vehicles]) for _ in range(2)]
    wind = (data.draw(st.floats(-0.6, 0.6)), data.draw(st.floats(-0.6, 0.6)))
    world = dataclasses.replace(
        problem(points, places[0], vehicles), ends=places[1], wind_mps=wind
    )
    best = best_makespan(world)
    assert bound_of(world).makespan_s <= best + ROUNDING_S
    found = optimised(world, Effort(proposals=2000))
    # Of flights that pass viewpoints the search proves nothing: NaN.
    assert not found.bound > best * (1.0 + 1e-6)
    # A short search may miss the best of so odd a world: it is not below it.
    assert makespan_s(world, found.orders) >= best * (1.0 - 1e-5)


def test_slow_photographer_may_fly_home_as_fast():
    """One vehicle needs twice as long for a photograph, but no longer for the way."""
    fleet = (vehicle('rav0', hover_s=1.0), vehicle('rav1', hover_s=2.0))
    ends = np.array([(0.0, 1.0)] * 2)
    world = dataclasses.replace(problem([(0.0, 0.0)] * 3, [(0.0, 0.0)] * 2, fleet), ends=ends)
    found = optimised(world, Effort(proposals=2000))
    assert found.bound <= best_makespan(world) * (1.0 + 1e-6)


def test_bound_holds_where_the_papers_does_not():
    """Two drones above their own waypoints, far apart, need climb, photograph and descent only.

    The paper's bound, half the tour through both, would claim some 130 s of flight more.
    """
    places = [(0.0, 0.0), (1000.0, 0.0)]
    world = problem(places, homes=places)
    needed = world.duration_s(0, [0])
    bound = bound_of(world)
    assert needed == pytest.approx(10 / 3 + 10 / 2 + 2.0)
    assert bound.makespan_s == pytest.approx(needed)


@settings(max_examples=8, deadline=None)
@given(st.lists(PLACES, min_size=2, max_size=3), PLACES)
def test_bound_holds_where_viewpoints_are_passed(points, home):
    """Corners flown without a stop save time, and the bound leaves it to them."""
    spec = vehicle('rav1', hover_s=0.0, autopilot=Autopilot())
    world = problem(points, [home], (spec,))
    assert bound_of(world).makespan_s <= best_makespan(world) + ROUNDING_S


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(4))
def test_flights_through_a_grid_are_bounded_within_a_seventh(seed):
    """The turns at the ends of the rows are left, but neither the ramps nor the stops."""
    rng = np.random.default_rng(seed)
    points = [(20.0 * i, 20.0 * j) for j in range(5) for i in range(6)]
    fleet = tuple(vehicle(f'rav{k}', hover_s=0.0, autopilot=Autopilot()) for k in range(2))
    world = problem(points, rng.uniform(-40.0, 0.0, (2, 2)), fleet)
    orders = optimised(world, Effort(proposals=20_000)).orders
    makespan = makespan_s(world, orders)
    proven = lower_bound(world, makespan, lambda _bound: True).makespan_s
    assert makespan / 1.14 < proven <= makespan


def test_one_far_point_is_bounded_by_its_trip():
    """With many vehicles and one far point, its trip is the bound, and it is met."""
    world = problem([(0, 1), (1, 0), (2000, 0)], [(0, 0)] * 3)
    bound = bound_of(world)
    assert bound.method == 'farthest'
    assert bound.makespan_s == pytest.approx(best_makespan(world))


def test_bound_is_tight_on_a_ring():
    """One vehicle and points on a circle about its home's height: the tour is proven optimal."""
    angles = np.linspace(0.0, 2 * np.pi, 13)[1:-1]
    points = np.column_stack([100 * np.cos(angles), 100 * np.sin(angles)])
    world = problem(points, [(100.0, 0.0)])
    optimum = world.duration_s(0, list(range(11)))
    bound = bound_of(world)
    assert bound.makespan_s == pytest.approx(optimum, rel=1e-3)


@pytest.mark.slow
def test_bound_comes_close_on_a_survey_grid():
    """On a grid of 10 by 10 with homes at three corners a simple plan is proven within 25 %."""
    points = [(25 * i, 25 * j) for j in range(10) for i in range(10)]
    world = problem(points, [(-25, -25), (250, -25), (250, 250)])
    orders = nearest_to_shortest(world)
    makespan = max(world.duration_s(k, order) for k, order in enumerate(orders))
    assert makespan / 1.25 < bound_of(world).makespan_s <= makespan


def best_finish(world):
    """Return when the last vehicle has landed under the best plan, with changes of batteries."""
    count, vehicles = len(world.points), range(len(world.vehicles))
    best = np.inf
    for owner in product(vehicles, repeat=count):
        groups = [[i for i in range(count) if owner[i] == k] for k in vehicles]
        for orders in product(*(permutations(group) for group in groups)):
            best = min(best, finish_s(world, [list(order) for order in orders]))
    return best


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.lists(PLACES, min_size=1, max_size=3), st.integers(1, 2), st.data())
def test_bound_holds_where_batteries_are_changed(points, count, data):
    """Small batteries, changed by some or all, to ends elsewhere or open, from the air."""
    fleet = tuple(
        vehicle(
            f'rav{k}',
            cruise_speed_mps=data.draw(st.floats(5.0, 10.0)),
            hover_s=data.draw(st.sampled_from((0.0, 2.0, 20.0))),
            endurance_s=data.draw(st.floats(120.0, 400.0)),
            battery_swap_s=data.draw(st.sampled_from((0.0, 60.0, None))),
            is_open=data.draw(st.booleans()),
        )
        for k in range(count)
    )
    places = [np.array([data.draw(PLACES) for _ in fleet]) for _ in range(2)]
    fleet = tuple(
        dataclasses.replace(v, aloft=Aloft(position=v.home, used_s=data.draw(st.floats(0, 100))))
        if data.draw(st.booleans())
        else v
        for v in fleet
    )
    world = dataclasses.replace(problem(points, places[0], fleet), ends=places[1])
    best = best_finish(world)
    if np.isfinite(best):
        found = lower_bound(
            world, data.draw(st.floats(1.0, 1e4)), lambda _bound: True, PriceOptions()
        )
        assert found.makespan_s <= best + ROUNDING_S


def test_every_battery_pays_its_way():
    """Four places far away, of which a battery lasts for one: three changes, eight long ways."""
    spec = vehicle('rav1', endurance_s=150.0, battery_swap_s=100.0, hover_s=20.0)
    world = problem([(400.0 + k, 0.0) for k in range(4)], [(0.0, 0.0)], (spec,))
    best = best_finish(world)
    bound = lower_bound(world, best, lambda _bound: True)
    assert bound.method == 'batteries'
    assert 0.97 * best < bound.makespan_s <= best + ROUNDING_S


@pytest.mark.slow
def test_large_worlds_are_bounded_by_simpler_legs(monkeypatch):
    """Where tables would be too large, shorter legs without jerk prove nearly as much."""
    points = [(25 * i, 31 * j) for j in range(6) for i in range(7)]
    world = problem(points, [(0, -50), (200, 200)])
    exact = bound_of(world).makespan_s
    monkeypatch.setattr('rocsafe_planner.routing.solver_problem.MOST_CLOSED_SITES', 1)
    assert 0.9 * exact < bound_of(world).makespan_s <= exact * (1.0 + 1e-6)


def test_the_ascent_can_be_ended():
    """It stops at the first refusal, with a bound that holds."""
    calls = []
    world = problem([(25 * i, 0) for i in range(8)], [(0, -50)])
    full = bound_of(world).makespan_s
    early = lower_bound(world, 200.0, lambda bound: bool(calls.append(bound)))
    assert len(calls) == 1
    assert 0.0 < early.makespan_s <= full
