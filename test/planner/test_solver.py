# SPDX-License-Identifier: Apache-2.0
"""The solver: plans that are valid, repeatable, and as good as can be where that is known."""

import dataclasses
import importlib
import math
import os
import pkgutil
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from rocsafe_planner import solver
from rocsafe_planner.solver import (
    MatrixLegs,
    PointLegs,
    RoutingProblem,
    SearchOptions,
    Vehicle,
    one_depot,
    solve,
)
from rocsafe_planner.solver.model.compiled import KeptCode, cache_directory
from rocsafe_planner.solver.model.flatten import tables_of
from rocsafe_planner.solver.model.neighbours import near_all_round, near_rows
from rocsafe_planner.solver.precompile import compile_kernels
from rocsafe_planner.solver.search.choosing import AdaptiveChoices
from rocsafe_planner.solver.search.giant_tour import braid, cut, tour_of
from rocsafe_planner.solver.search.population import Lane, Manner
from rocsafe_planner.solver.search.starts import first_plans, sector_plan
from rocsafe_planner.solver.search.state import empty_state, load
from rocsafe_planner.solver.search.tuning import USUAL

from . import tiny_routing

QUICK = SearchOptions(proposals=20_000, lanes=2, bound_share=0.0)


def grid(side, spacing=10.0):
    """Return a square grid of points without its corner, which is the depot."""
    points = [(spacing * x, spacing * y) for x in range(side) for y in range(side)]
    return np.array(points[1:])


@pytest.mark.parametrize('seed', range(25))
def test_small_problems_are_solved_to_the_optimum(seed):
    """Whatever the fleet, no plan of all is better; costs are those of the definition."""
    objective = 'sum' if seed % 3 == 2 else 'max'
    problem = tiny_routing.random_problem(seed, 5, 2 + seed % 2, objective)
    found = solve(problem, QUICK)
    assert tiny_routing.faults(problem, found.routes) == []
    assert found.value == pytest.approx(tiny_routing.value(problem, found.routes), rel=1e-9)
    assert found.value == pytest.approx(tiny_routing.optimum(problem), rel=1e-6)


@pytest.mark.parametrize('seed', range(100, 115))
def test_endurance_is_kept_where_that_is_possible(seed):
    """A plan without faults is found if there is one; if there is none, the solution says so."""
    problem = tiny_routing.random_problem(seed, 5, 3, limited=True)
    found = solve(problem, QUICK)
    best = tiny_routing.optimum(problem)
    assert found.feasible == (tiny_routing.faults(problem, found.routes) == [])
    assert found.feasible == math.isfinite(best)
    if found.feasible:
        assert best * (1 - 1e-6) <= found.value <= best * 1.01


def test_limits_may_count_other_legs_than_the_objective():
    """Metres are minimised, minutes limited: the far customer goes to the one who has time."""
    points = np.array([[100.0, 0.0], [1.0, 0.0], [0.0, 0.0]])
    tired, fresh = (
        Vehicle(start=2, end=2, limit=limit, limit_legs=1) for limit in (50.0, math.inf)
    )
    problem = RoutingProblem(
        customers=2,
        vehicles=(tired, fresh),
        legs=(PointLegs(), PointLegs(speed_mps=2.0)),
        points=points,
        objective='sum',
    )
    found = solve(problem, QUICK)
    assert found.feasible
    assert 0 in found.routes[1]


def test_wind_decides_the_way_round():
    """Of two orders of the same customers the one with the wind is taken."""
    matrix = np.full((4, 4), 9.0)
    for origin, target in ((3, 2), (2, 1), (1, 0), (0, 3)):
        matrix[origin, target] = 1.0
    problem = RoutingProblem(
        customers=3, vehicles=(Vehicle(start=3, end=3),), legs=(MatrixLegs(matrix=matrix),)
    )
    found = solve(problem, QUICK)
    assert found.routes == ((2, 1, 0),)
    assert found.value == 4.0


@pytest.mark.parametrize('is_symmetric', [True, False])
def test_partial_costs_are_those_of_the_legs(is_symmetric):
    """After thousands of moves the routes have the costs that they have when they are set anew."""
    matrices = np.random.default_rng(5).integers(1, 1000, (2, 31, 31)).astype(np.float64)
    if is_symmetric:
        matrices += matrices.transpose(0, 2, 1)
    problem = RoutingProblem(
        customers=30,
        vehicles=tuple(Vehicle(start=30, end=30, legs=k % 2, limit=1e5) for k in range(3)),
        legs=tuple(MatrixLegs(matrix=matrix) for matrix in matrices),
    )
    tables = tables_of(problem)
    lane = Lane(tables, 1.0, 7, 0, 0.0)
    lane.begin(next(iter(first_plans(problem, tables))))
    manner = Manner(hot=3.0, cold=2.0, floor=0.2, width=0.02, sharper=0.0, ruins=100, long=3)
    fresh = empty_state(tables)
    for _ in range(20):
        lane.anneal(manner, 0.0, 250, 1e-4)
        found = lane.state
        stride = len(found.node) // 3
        ends = [r * stride + 1 + int(found.length[r]) for r in range(3)]
        order = np.concatenate([found.node[r * stride + 1 : ends[r]] for r in range(3)])
        load(tables, fresh, order, found.length)
        for name in ('place', 'route', 'cost', 'load'):
            assert getattr(found, name).tolist() == getattr(fresh, name).tolist()
        for name in ('ahead', 'back'):
            ours, theirs = (getattr(one, name).reshape(2, -1) for one in (found, fresh))
            for r in range(3):
                used = slice(r * stride, ends[r] + 1)
                assert ours[:, used].tolist() == theirs[:, used].tolist()


def test_a_slower_vehicle_serves_fewer():
    """Half the speed gets clearly less than half of the customers."""
    problem = one_depot(grid(8), np.zeros(2), 2)
    slow = dataclasses.replace(problem.vehicles[0], legs=1)
    problem = dataclasses.replace(
        problem,
        legs=(PointLegs(speed_mps=2.0), PointLegs(speed_mps=1.0)),
        vehicles=(problem.vehicles[0], slow),
    )
    found = solve(problem, dataclasses.replace(QUICK, proposals=200_000))
    assert tiny_routing.faults(problem, found.routes) == []
    assert 0.4 < len(found.routes[1]) / len(found.routes[0]) < 0.62
    assert found.value < 1.06 * 650 / 3


@pytest.mark.parametrize('threads', [1, 3])
def test_proposals_decide_the_plan_alone(threads):
    """The same seed and number of proposals give the same plan, however many threads there are."""
    problem = one_depot(grid(7), np.zeros(2), 3)
    options = SearchOptions(proposals=100_000, lanes=3, threads=2, seed=7)
    first = solve(problem, options)
    again = solve(problem, dataclasses.replace(options, threads=threads))
    assert again.routes == first.routes
    assert again.bound == first.bound
    assert again.proposals == first.proposals


def test_the_plan_is_the_same_on_every_machine():
    """A plan that another machine has found: integers and plain sums leave nothing to chance."""
    problem = one_depot(grid(5), np.zeros(2), 2)
    found = solve(problem, SearchOptions(proposals=50_000, lanes=1, seed=3, bound_share=0.0))
    assert found.value == pytest.approx(146.50281539872884, abs=1e-9)


def test_given_plans_are_never_worsened():
    """The solution is at least as good as any plan that it was given."""
    points = np.random.default_rng(5).uniform(0, 100, (60, 2))
    problem = one_depot(points, np.zeros(2), 4)
    good = solve(problem, SearchOptions(proposals=400_000, bound_share=0.0))
    poor = solve(problem, SearchOptions(proposals=1, bound_share=0.0), starts=[good.routes])
    assert poor.value <= good.value * (1 + 1e-9)


def test_it_stops_when_told_and_reports_improvements():
    """A long budget is cut short by `stop`; reports are monotone and the first is a valid plan."""
    problem = one_depot(grid(12), np.zeros(2), 3)
    stop, seen = threading.Event(), []

    def watch(progress):
        seen.append((progress.value, progress.bound.value))
        if len(seen) == 5:
            stop.set()

    found = solve(problem, SearchOptions(budget_s=60.0), watch, stop)
    assert found.elapsed_s < 30
    values, bounds = zip(*seen, strict=True)
    assert list(values) == sorted(values, reverse=True)
    assert list(bounds) == sorted(bounds)
    assert found.value <= values[-1] * (1 + 1e-6)
    assert tiny_routing.faults(problem, found.routes) == []


def test_nothing_is_proven_of_a_search_that_was_stopped():
    """Where proposals are counted, the bound comes after them: nobody waits for it any more."""
    stop = threading.Event()
    found = solve(
        one_depot(grid(12), np.zeros(2), 3),
        SearchOptions(proposals=100_000_000),
        lambda _progress: stop.set(),
        stop,
    )
    assert (found.bound.name, found.feasible) == ('none', True)


@pytest.mark.parametrize(
    ('points', 'vehicles'),
    [
        (np.zeros((0, 2)), 2),
        (np.array([[3.0, 4.0]]), 3),
        (np.zeros((6, 2)), 2),
        (np.array([[float(k), 0.0] for k in range(9)]), 2),
    ],
    ids=['nobody', 'one', 'all at the depot', 'a line'],
)
def test_odd_worlds_have_plans(points, vehicles):
    """No customer, one, all in one place, all in a line."""
    problem = one_depot(points, np.zeros(2), vehicles)
    found = solve(problem, QUICK)
    assert tiny_routing.faults(problem, found.routes) == []
    assert found.value == pytest.approx(tiny_routing.value(problem, found.routes))


def test_customers_beyond_a_table_of_legs():
    """A thousand customers, whose legs are computed on the fly, make a plan of known costs."""
    rng = np.random.default_rng(2)
    problem = one_depot(
        rng.uniform(0, 1000, (1000, 3)),
        np.array([500.0, 500.0, 0.0]),
        5,
        PointLegs(speed_mps=8.0, acceleration_mps2=2.0, stay=3.0),
    )
    found = solve(problem, dataclasses.replace(QUICK, proposals=60_000))
    assert tiny_routing.faults(problem, found.routes) == []
    assert found.value == pytest.approx(tiny_routing.value(problem, found.routes), rel=1e-9)


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'objective': 'fun'}, "objective is 'fun'"),
        ({'customers': 9}, 'customers is 9'),
        ({'vehicles': ()}, 'must not be empty'),
        ({'vehicles': (Vehicle(start=0, end=0),)}, 'starts or ends at site'),
        ({'vehicles': (Vehicle(start=2, end=2, legs=4),)}, 'counts legs 4'),
        ({'points': np.array([[0.0, math.nan]] * 3)}, 'not finite'),
        ({'points': None}, 'points is missing'),
        ({'legs': (MatrixLegs(matrix=np.zeros((5, 5))),)}, 'matrix has 5 sites'),
        ({'allowed': np.zeros((1, 2), bool)}, 'no vehicle may serve customer 0'),
        ({'allowed': np.ones((2, 2), bool)}, 'allowed has shape'),
    ],
)
def test_a_problem_that_does_not_fit_together_is_refused(change, words):
    """One line that names what is wrong."""
    sound = {
        'customers': 2,
        'vehicles': (Vehicle(start=2, end=2),),
        'points': np.zeros((3, 2)),
    }
    with pytest.raises(ValueError, match=words):
        RoutingProblem(**(sound | change))


WITHOUT_NUMBA = """
import logging, sys, warnings
warnings.simplefilter('error')
logging.basicConfig(level='WARNING', format='%(message)s')
sys.modules['numba'] = None
import numpy as np
from rocsafe_planner.solver import SearchOptions, one_depot, solve
points = np.array([(x, y) for x in range(12) for y in range(12)], float)
found = solve(one_depot(points[1:], points[0], 3), SearchOptions(budget_s=1.0))
assert sorted(i for route in found.routes for i in route) == list(range(143))
print(found.value, found.bound.value)
"""


def test_without_numba_simple_methods_plan():
    """A machine without numba is told so, once, and gets a valid plan with a bound."""
    done = subprocess.run(
        [sys.executable, '-c', WITHOUT_NUMBA],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        env=os.environ | {'PYTHONPATH': os.pathsep.join(sys.path)},
    )
    assert done.returncode == 0, done.stderr
    value, bound = (float(word) for word in done.stdout.split())
    assert 48.0 < bound <= value < 1.35 * bound
    assert done.stderr.count('numba is not installed') == 1


def test_every_kernel_is_compiled_once():
    """One machine type an argument: none is specialised twice, which would take seconds."""
    compile_kernels()
    modules = [
        importlib.import_module(m.name)
        for m in pkgutil.walk_packages(solver.__path__, 'rocsafe_planner.solver.')
    ]
    kernels = {
        value.py_func.__qualname__: value
        for module in modules
        for value in vars(module).values()
        if hasattr(value, 'py_func')
    }
    assert len(kernels) > 40
    assert {name: len(k.signatures) for name, k in kernels.items() if len(k.signatures) > 1} == {}
    assert all(kernels[name].signatures for name in ('anneal', 'complete', 'split', 'join_edges'))


def test_machine_code_is_kept_beside_the_sources_or_at_home(monkeypatch):
    """Where the sources cannot be written, the user's cache folder is used."""
    assert cache_directory().parent.name == '__pycache__'
    monkeypatch.setattr(os, 'access', lambda *_: False)
    assert cache_directory().parent == Path.home() / '.cache' / 'rocsafe'


def test_machine_code_belongs_to_a_text_wherever_it_lies(tmp_path):
    """A wheel brings it, and pip gives its files new times; a changed text has none."""
    source = Path(str(solver.__file__)).with_name('solve.py')
    other = tmp_path / source.name
    other.write_bytes(source.read_bytes())
    os.utime(other, (0.0, 0.0))

    def stamp(path):
        return KeptCode(one_depot, str(path)).get_source_stamp()

    assert stamp(other) == stamp(source)
    other.write_text(source.read_text() + '\n')
    assert stamp(other) != stamp(source)


def test_nearest_rows_are_those_of_a_stable_sort():
    """Of customers that cost as much as the last one, the first are taken."""
    drawn = np.random.default_rng(5)
    costs = drawn.integers(0, 9, (60, 60)).astype(float)
    others = costs + np.diag(np.full(60, np.inf))
    sorted_rows = np.argsort(others, axis=1, kind='stable')
    for count in (1, 10, 58, 59):
        assert (near_rows(costs, count) == sorted_rows[:, :count]).all()


def test_neighbours_lead_out_of_a_cluster():
    """Who stands at the rim of a cluster has neighbours in the next one, not in its own alone."""
    drawn = np.random.default_rng(4)
    points = drawn.uniform(0.0, 1.0, (60, 2)) + np.repeat([[0.0, 0.0], [100.0, 0.0]], 30, axis=0)
    places = np.column_stack([points, np.zeros(60)])
    costs = np.linalg.norm(points[:, None] - points[None, :], axis=2)
    near = near_all_round(places, 5, 3, costs)
    assert (near_all_round(places, 5, 3) == near).all()
    assert near.shape == (60, 17)
    for i, row in enumerate(near):
        assert len(set(row)) == 17
        assert i not in row
        assert list(row[:5]) == sorted(set(range(60)) - {i}, key=lambda j: costs[i, j])[:5]
    rightmost = int(points[:30, 0].argmax())
    assert (near[rightmost, 5:] >= 30).sum() >= 3
    assert (near_rows(costs, 17)[rightmost] < 30).all()


def test_neighbours_in_each_quadrant_are_the_cheapest_there():
    """Those of a slow search, also where many cost the same and where a quadrant is empty."""
    for seed in range(10):
        drawn = np.random.default_rng(seed)
        points = np.column_stack([drawn.integers(0, 9, (70, 2)), np.zeros(70)]).astype(float)
        costs = np.hypot(*(points[:, None, :2] - points[None, :, :2]).transpose(2, 0, 1))
        near = near_all_round(points, 5, 3, costs)
        for i, row in enumerate(near):
            others = sorted(set(range(70)) - {i}, key=lambda j: (costs[i, j], j))
            sides = [tuple(points[j, :2] >= points[i, :2]) for j in others[5:]]
            first = [j for k, j in enumerate(others[5:]) if sides[:k].count(sides[k]) < 3]
            wanted = (others[:5] + first + [j for j in others[5:] if j not in first])[:17]
            assert list(row) == wanted


def test_large_surveys_have_neighbours_outside_of_their_clusters():
    """Of those at the rims, also where no table of legs is made."""
    drawn = np.random.default_rng(4)
    centres = np.repeat([[0.0, 0.0], [1000.0, 0.0], [0.0, 1000.0]], 300, axis=0)
    points = centres + drawn.uniform(0.0, 30.0, (900, 2))
    tables = tables_of(one_depot(points, points[0], 2))
    assert not tables.dense
    assert (np.abs(points[tables.near] - points[:, None]).max(axis=(1, 2)) > 500).mean() > 0.1


def test_few_customers_of_very_many_vehicles_have_neighbours():
    """There, too, no table of legs is made."""
    points = np.random.default_rng(3).uniform(0.0, 100.0, (811, 2))
    vehicles = tuple(Vehicle(start=10 + k, end=10 + k) for k in range(801))
    tables = tables_of(RoutingProblem(customers=10, vehicles=vehicles, points=points))
    assert not tables.dense
    assert [sorted(row) for row in tables.near] == [
        [j for j in range(10) if j != i] for i in range(10)
    ]


@pytest.mark.parametrize('home', [(0.0, 0.0), (2.2, 2.7)])
def test_sectors_serve_everybody_once(home):
    """Equal numbers for all, whether the home is at a corner or in the middle."""
    away = grid(6) / 20.0 - np.array(home)
    order, lengths = sector_plan(away, 5)
    assert sorted(order.tolist()) == list(range(len(away)))
    assert lengths.max() - lengths.min() <= 1


def test_sectors_are_a_better_start_than_strips():
    """Ten vehicles from a corner of 50 by 50 points, each 1 from the next."""
    points = np.array([(x, y) for x in range(50) for y in range(50)], float)
    problem = one_depot(points[1:], points[0], 10)
    plans = [*first_plans(problem, tables_of(problem)), sector_plan(points[1:], 10)]
    longest = [max(solution_costs(problem, plan)) for plan in plans]
    assert longest[-1] == min(longest)


def solution_costs(problem, plan):
    """Return the costs of a plan's routes."""
    routes = np.split(plan[0], np.cumsum(plan[1])[:-1])
    return [solver.route_cost(problem, v, tuple(map(int, r))) for v, r in enumerate(routes)]


def test_tours_are_cut_no_worse_than_they_were():
    """A plan as a tour and back; a braid of two tours has every customer once."""
    points = np.random.default_rng(5).uniform(0.0, 100.0, (40, 2))
    problem = one_depot(points[1:], points[0], 4)
    choices, tables = np.random.default_rng(1), tables_of(problem)
    plans = list(first_plans(problem, tables))
    tours = [tour_of(plan, points[1:] - points[0], choices) for plan in plans]
    for plan, tour in zip(plans, tours, strict=True):
        again = cut(tables, tour)
        assert sorted(again[0].tolist()) == list(range(39))
        assert max(solution_costs(problem, again)) <= max(solution_costs(problem, plan)) + 1e-4
    child = braid(tours[0], tours[1], choices)
    assert sorted(child.tolist()) == list(range(39))


def towns(count, seed):
    """Return places in a few towns of unlike width: the structure that fine temperatures miss."""
    generator = np.random.default_rng(seed)
    centres = 1000.0 * generator.random((6, 2))
    town = generator.integers(6, size=count)
    return centres[town] + (5.0 + 10.0 * town)[:, None] * generator.normal(size=(count, 2))


@pytest.mark.parametrize(('count', 'vehicles'), [(40, 3), (150, 8), (600, 3)])
@pytest.mark.parametrize('seed', [0, 1])
def test_a_longer_search_is_never_worse(count, vehicles, seed):
    """A search with more proposals begins with all that one with fewer does."""
    problem = one_depot(towns(count, seed), np.zeros(2), vehicles)
    values = [
        solve(problem, SearchOptions(proposals=n, seed=seed, bound_share=0.0)).value
        for n in (1_000, 20_000, 33_000, 100_000, 250_000, 900_000)
    ]
    assert values == sorted(values, reverse=True)
    assert count < 600 or values[-1] < 0.99 * values[0]


def test_values_that_bring_better_plans_are_drawn_more_often():
    """Weights follow the scores, and no value is given up."""
    choices = AdaptiveChoices({'x': (1.0, 2.0, 3.0)}, USUAL, np.random.default_rng(4))
    counts = np.zeros(3)
    for _ in range(600):
        drawn = choices.draw()
        counts[drawn['x']] += 1
        is_good = choices.value('x', drawn) == 3.0
        choices.reward(drawn, USUAL.best_score if is_good else USUAL.poor_score)
    assert counts[2] > 3 * max(counts[:2])
    assert min(counts) > 10
