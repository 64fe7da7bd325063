# SPDX-License-Identifier: Apache-2.0
"""Routing methods on worlds small enough to solve by hand."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_planner.routing.methods import METHODS, nearest_to_shortest, paper_greedy
from rocsafe_planner.routing.tours.tour_splitting import makespan_s

from .fleets import problem, vehicle

PLACES = st.tuples(st.floats(-500.0, 500.0), st.floats(-500.0, 500.0))


def test_paper_greedy_by_hand():
    """Vehicles take turns from their own homes; each goes to the nearest point left."""
    line = problem([(0, 0), (10, 0), (20, 0), (30, 0), (40, 0)], homes=[(12, 0), (100, 0)])
    # rav0: 10 (nearest to 12); rav1: 40; rav0: 0 or 20 are equally far from 10: the first;
    # rav1: 30; rav0: 20.
    assert paper_greedy(line) == [[1, 0, 2], [4, 3]]


def test_paper_greedy_honours_the_starts():
    """Exchanged homes exchange the routes."""
    points = [(0, 0), (10, 0), (90, 0), (100, 0)]
    assert paper_greedy(problem(points, [(0, 0), (100, 0)])) == [[0, 1], [3, 2]]
    assert paper_greedy(problem(points, [(100, 0), (0, 0)])) == [[3, 2], [0, 1]]


def test_paper_greedy_rotates_strictly():
    """A slow vehicle gets as many points as a fast one: the printed method's weakness."""
    vehicles = (vehicle('slow', cruise_speed_mps=0.5), vehicle('fast', cruise_speed_mps=15.0))
    orders = paper_greedy(problem([(i, 0) for i in range(10)], [(0, 0), (9, 0)], vehicles))
    assert [len(order) for order in orders] == [5, 5]


def test_nearest_to_shortest_spares_the_slow():
    """The slow vehicle gets less to do, and the fleet is done earlier."""
    vehicles = (vehicle('slow', cruise_speed_mps=0.5), vehicle('fast', cruise_speed_mps=15.0))
    world = problem([(20 * i, 0) for i in range(10)], [(0, 0), (180, 0)], vehicles)
    orders = nearest_to_shortest(world)
    assert len(orders[0]) < len(orders[1])

    def makespan(routes):
        return max(world.duration_s(k, order) for k, order in enumerate(routes))

    assert makespan(orders) < makespan(paper_greedy(world))


def test_nearest_to_shortest_leaves_the_far_at_home():
    """A vehicle whose way there and back outlasts the whole survey is sent once only."""
    world = problem([(i, 0) for i in range(8)], homes=[(0, 0), (5000, 0)])
    assert [len(order) for order in nearest_to_shortest(world)] == [7, 1]


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@pytest.mark.parametrize('method', METHODS)
@given(
    points=st.lists(PLACES, min_size=1, max_size=30),
    homes=st.lists(PLACES, min_size=1, max_size=5),
)
def test_every_point_is_visited_once(method, points, homes):
    """Routes partition the points, also when there are more vehicles than points."""
    orders = METHODS[method](problem(points, homes))
    assert len(orders) == len(homes)
    assert sorted(i for order in orders for i in order) == list(range(len(points)))


def test_time_and_length_by_hand():
    """Climb, two legs of 80 m and one of 113 m, two hovers, descent; nothing for a short route."""
    world = problem([(80, 0), (80, 80)], [(0, 0)], height=30.0)
    assert world.length_m(0, [0, 1]) == pytest.approx(80.0 + 80.0 + 80.0 * 2**0.5)
    legs = 2 * (80 / 8 + 8 / 2.5) + (80 * 2**0.5 / 8 + 8 / 2.5)
    assert world.duration_s(0, [0, 1]) == pytest.approx(30 / 3 + 30 / 2 + legs + 2 * 2.0)
    assert world.duration_s(0, []) == world.length_m(0, []) == 0.0


def test_splits_of_a_row_by_hand():
    """Two vehicles at the ends of a row of six: three points each, whatever the method."""
    world = problem([(20.0 * k, 0.0) for k in range(6)], [(0.0, 0.0), (100.0, 0.0)])
    for method in ('boustrophedon_equal', 'boustrophedon_minmax', 'christofides'):
        assert [sorted(order) for order in METHODS[method](world)] == [[0, 1, 2], [3, 4, 5]]


def test_strips_by_hand():
    """Four rows for two vehicles: two whole rows each, flown to and fro."""
    grid = problem(
        [(20.0 * x, 50.0 * y) for y in range(4) for x in range(3)], [(0.0, 0.0), (0.0, 150.0)]
    )
    assert METHODS['strips'](grid) == [[0, 1, 2, 5, 4, 3], [6, 7, 8, 11, 10, 9]]


@pytest.mark.slow
@given(
    points=st.lists(PLACES, min_size=1, max_size=40, unique=True),
    homes=st.lists(PLACES, min_size=1, max_size=4),
)
def test_min_max_split_beats_the_equal_one(points, homes):
    """Of the same track: the cut that is sought is never longer than the one by count."""
    world = problem(points, homes)
    equal, sought = (
        makespan_s(world, METHODS[f'boustrophedon_{kind}'](world)) for kind in ('equal', 'minmax')
    )
    assert sought <= equal * (1.0 + 1e-5)
