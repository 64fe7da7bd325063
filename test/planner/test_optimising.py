# SPDX-License-Identifier: Apache-2.0
"""The method `solver`: better than simple methods, always the same, for every objective."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rocsafe_geo.motion.autopilot import ARDUCOPTER
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.plan.objective import OBJECTIVE_VALUES, objective_gap
from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_planner.routing.methods import METHODS
from rocsafe_planner.routing.solver_method import optimised
from rocsafe_planner.routing.solver_problem import routing_problem
from rocsafe_planner.routing.tours.tour_splitting import makespan_s
from rocsafe_planner.solver import route_cost

from .fleets import FLEET, changed, problem, request
from .surveys import surveys

pytestmark = pytest.mark.slow

TOOLS = ('boustrophedon_equal', 'boustrophedon_minmax', 'strips')


@settings(max_examples=3, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_never_worse_than_survey_tools(seed, vehicles):
    """On random points, which are no grid at all, and on grids with corners missing."""
    generator = np.random.default_rng(seed)
    places = generator.uniform(0.0, 300.0, (25, 2))
    grid = np.array([(20.0 * x, 20.0 * y) for x in range(7) for y in range(7)])
    for points in (places, grid[generator.random(49) < 0.8]):
        world = problem(points, generator.uniform(-100.0, 400.0, (vehicles, 2)))
        best = makespan_s(world, METHODS['solver'](world))
        assert best <= min(makespan_s(world, METHODS[tool](world)) for tool in TOOLS) + 1e-3


@settings(max_examples=4, deadline=None, suppress_health_check=list(HealthCheck))
@given(surveys(distance_m=0.0, exclusions=()))
def test_never_worse_than_survey_tools_on_regions(survey):
    """On concave, holed, thin and tiny regions, with unlike fleets, ends, sensors and wind."""
    fleet = tuple(
        dataclasses.replace(v, battery_swap_s=None, endurance_s=1e5) for v in survey.vehicles
    )
    makespans = {
        method: plan_survey(
            changed(survey, vehicles=fleet, method=method, proposals=20_000)
        ).makespan_s
        for method in (*TOOLS, 'solver')
    }
    assert makespans['solver'] <= min(makespans.values()) + 1e-3


def test_who_stands_together_is_alike():
    """Vehicles at one home begin and end at one site, so that the search may exchange them."""
    world = problem([(20.0 * k, 9.0) for k in range(9)], [(0.0, 0.0), (0.0, 0.0), (5.0, 0.0)])
    routed = routing_problem(world, 'longest_time').vehicles
    assert routed[0].start == routed[0].end == routed[1].start != routed[2].start
    assert routed[2].start == routed[2].end


def test_corners_that_are_flown_round_count_in_the_end():
    """Whoever passes viewpoints is compared with survey tools as it is flown, not as estimated."""
    fleet = tuple(dataclasses.replace(v, hover_s=0.0, autopilot=ARDUCOPTER) for v in FLEET)
    world = problem(
        [(20.0 * x, 20.0 * y) for x in range(5) for y in range(4)],
        [(-90.0, 0.0), (0.0, -90.0), (120.0, 90.0)],
        fleet,
    )
    few = Effort(proposals=1)
    best = min(makespan_s(world, METHODS[tool](world)) for tool in TOOLS)
    assert makespan_s(world, optimised(world, few).orders) <= best


def test_there_is_a_plan_before_the_search(monkeypatch):
    """A plan is told as soon as there is one, before tables of legs; whoever stops has it."""
    told = []

    def watch(value, _bound):
        told.append(value)
        return False

    def tables(*arguments):
        assert told[0] == makespan_s(world, METHODS['boustrophedon_minmax'](world))
        return routing_problem(*arguments)

    monkeypatch.setattr('rocsafe_planner.routing.solver_method.routing_problem', tables)
    world = problem([(20.0 * x, 20.0 * y) for x in range(5) for y in range(4)], [(0.0, 0.0)] * 2)
    found = optimised(world, Effort(), watch)
    assert makespan_s(world, found.orders) <= told[0]
    assert sorted(point for order in found.orders for point in order) == list(range(20))


def test_derailment_is_a_fifth_shorter_than_the_papers():
    """The seed's own mission, by the paper's method and by the solver."""
    paper, ours = (plan_survey(request(method=m)) for m in ('paper_greedy', 'solver'))
    assert ours.makespan_s < 0.82 * paper.makespan_s
    assert check_plan(ours) == []


def test_without_a_budget_always_the_same():
    """The same question has the same answer; another seed may have another."""
    first, second = (plan_survey(request(method='solver', proposals=20_000)) for _ in range(2))
    assert first == second


@settings(max_examples=10, deadline=None)
@given(surveys(distance_m=0.0))
def test_costs_are_those_of_the_time_model(survey):
    """What the solver counts, for each objective, is what the planner states."""
    from rocsafe_planner.errors import PlannerError
    from rocsafe_planner.site.survey_site import survey_site

    try:
        world: FleetProblem = survey_site(survey).problem
    except (PlannerError, ValueError):
        return
    order = list(range(len(world.points)))
    if world.may_visit is not None:
        order = [i for i in order if world.may_visit[0, i]]
    for objective, count in (
        ('longest_time', world.duration_s),
        ('total_distance', world.length_m),
    ):
        if objective == 'longest_time' and survey.vehicles[0].hover_s == 0.0:
            continue  # corners that are passed cost the solver an estimate
        routed = route_cost(routing_problem(world, objective), 0, order)
        assert routed == pytest.approx(count(0, order), rel=1e-6)


@pytest.fixture(scope='module')
def pursued():
    """Plan the derailment for each objective."""
    return {
        name: plan_survey(request(method='solver', objective=name, proposals=50_000))
        for name in OBJECTIVE_VALUES
    }


@pytest.mark.parametrize('objective', OBJECTIVE_VALUES)
def test_each_objective_is_pursued(objective, pursued):
    """No other objective's plan is much better in it, and none can beat its proof."""
    value, plan = OBJECTIVE_VALUES[objective], pursued[objective]
    least = min(value(other) for other in pursued.values())
    assert value(plan) <= 1.02 * least
    assert plan.objective_bound <= least * (1.0 + 1e-9)
    assert objective_gap(plan) < 0.3
    assert check_plan(plan) == []


def test_short_batteries_are_kept_to():
    """A fleet that the simple methods cannot use is used: nobody flies longer than it may."""
    paper = plan_survey(request(method='boustrophedon_minmax'))
    limit = 0.985 * paper.makespan_s
    fleet = tuple(dataclasses.replace(v, endurance_s=limit) for v in FLEET)
    plan = plan_survey(request(method='solver', vehicles=fleet))
    assert plan.makespan_s <= limit


def test_few_swap_rather_than_all():
    """Batteries 3 % too weak: not everybody flies twice, and it takes less time than that."""
    free = plan_survey(request(method='solver', proposals=600_000))
    limit = 0.97 * free.makespan_s
    fleet = tuple(dataclasses.replace(v, endurance_s=limit, battery_swap_s=60.0) for v in FLEET)
    plan = plan_survey(request(method='solver', vehicles=fleet, proposals=600_000))
    flights = [len(route.sorties) for route in plan.routes]
    assert min(flights) == 1
    assert max(flights) > 1
    assert plan.makespan_s < 1.8 * free.makespan_s
    assert check_plan(plan) == []


def test_a_search_stops_when_told():
    """Long before its budget is spent, with routes that visit everything."""
    world = problem([(20.0 * x, 20.0 * y) for x in range(9) for y in range(9)], [(0.0, 0.0)] * 3)
    reports = []

    def watch(value, bound):
        reports.append((value, bound))
        return len(reports) < 3

    found = optimised(world, Effort(budget_s=60.0), watch)
    assert sorted(i for order in found.orders for i in order) == list(range(81))
    assert all(math.isfinite(value) for value, _ in reports)
