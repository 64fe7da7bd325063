# SPDX-License-Identifier: Apache-2.0
"""Vehicles that take off and land at one place: their waits in the search, in bounds, in plans."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.flights.flight_track import FlightTrack
from rocsafe_planner.flights.keeping_apart import FlightChoices
from rocsafe_planner.plan.survey_options import Effort, SeparationOptions
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.routing.queues import (
    interval_s,
    landing_queues,
    take_off_queues,
    waits_s,
    worthwhile,
)
from rocsafe_planner.routing.solver_method import optimised
from rocsafe_planner.site.survey_site import survey_site
from rocsafe_planner.solver import PointLegs, one_depot
from rocsafe_planner.solver.bounds.certificate import improving_bounds
from rocsafe_planner.solver.bounds.waiting import Crew
from rocsafe_planner.solver.bounds.walk_prices import price_bounds

from . import tiny_routing
from .fleets import STARTS, problem, request, vehicle

SEPARATION_M = 8.0
ROUTES = np.random.default_rng(0).uniform(20.0, 200.0, (12, 2))


def crowd(*homes, vehicles=None):
    """Return a problem of vehicles that stand at these places and keep apart."""
    return dataclasses.replace(
        problem(ROUTES, homes, vehicles), height_m=30.0, separation_m=SEPARATION_M
    )


def test_intervals_are_the_times_near_the_ground():
    """So long a vehicle is lower than the separation, after its take-off and before it stands."""
    world = crowd((0.0, 0.0), (0.0, 0.0))
    track = FlightTrack(world, 0, [[0]])
    (first,), (last,) = take_off_queues(world), landing_queues(world)
    times = np.array([first.interval_s, track.duration_s - last.interval_s])
    for late_s, above in ((-0.3, (False, True)), (0.3, (True, False))):
        ups = track.places(times + late_s)[:, 2]
        assert tuple((ups > SEPARATION_M).tolist()) == above
    assert interval_s(world) == first.interval_s + last.interval_s


def test_who_waits_for_nobody_is_in_no_queue():
    """Homes far apart, vehicles in the air, open ends, and fleets that need no distance."""
    assert take_off_queues(crowd((0.0, 0.0), (0.0, 9.0))) == []
    (near,) = take_off_queues(crowd((0.0, 0.0), (0.0, 7.0)))
    (same,) = take_off_queues(crowd((0.0, 0.0), (0.0, 0.0)))
    assert near.interval_s < same.interval_s
    home = GeoPosition(*STARTS[0])
    aloft = tuple(
        dataclasses.replace(vehicle(f'rav{k}'), aloft=Aloft(position=home)) for k in (1, 2)
    )
    assert take_off_queues(crowd((0.0, 0.0), (0.0, 0.0), vehicles=aloft)) == []
    wide = tuple(vehicle(f'rav{k}', is_open=True) for k in (1, 2))
    assert landing_queues(crowd((0.0, 0.0), (0.0, 0.0), vehicles=wide)) == []
    assert waits_s(dataclasses.replace(crowd((0.0, 0.0)), separation_m=0.0), [0]) == [0.0]


def test_two_of_three_homes_at_one_place_wait_for_each_other_only():
    """The third does not; so nothing is known of each two of all."""
    world = crowd((0.0, 0.0), (0.0, 0.0), (500.0, 0.0))
    assert [queue.vehicles for queue in take_off_queues(world)] == [(0, 1)]
    assert interval_s(world) == 0.0
    waits = waits_s(world, range(3))
    assert waits[2] == 0.0 < min(waits[:2])
    assert waits_s(world, [1, 2]) == [0.0, 0.0, 0.0]


def test_vehicles_that_would_only_wait_stay_on_the_ground():
    """Of twenty at one home for twelve points few fly; all do where their homes are apart."""
    many = worthwhile(crowd(*[(0.0, 0.0)] * 20))
    assert 2 <= len(many) < 12
    assert worthwhile(crowd(*[(0.0, 20.0 * k) for k in range(20)])) == list(range(20))
    swapping = tuple(vehicle(f'rav{k}', battery_swap_s=60.0) for k in range(20))
    assert worthwhile(crowd(*[(0.0, 0.0)] * 20, vehicles=swapping)) == many
    small = tuple(dataclasses.replace(one, endurance_s=30.0) for one in swapping)
    assert worthwhile(crowd(*[(0.0, 0.0)] * 20, vehicles=small)) == list(range(20))
    orders = optimised(crowd(*[(0.0, 0.0)] * 20), Effort(proposals=20_000)).orders
    assert {k for k, order in enumerate(orders) if order} <= set(many)


@pytest.mark.slow
@given(
    st.lists(st.floats(0.0, 3.0), min_size=30, max_size=30),
    st.integers(1, 5),
    st.floats(0.0, 9.0),
    st.randoms(use_true_random=False),
)
def test_a_crew_collects_what_any_waits_allow_at_most(steps, count, apart, random):
    """Waits in any order before take-offs and after landings, some longer than needed."""
    whole = np.cumsum(steps)
    for moment in (12, 29):
        first, second = apart * 0.3, apart * 0.7
        for before, after in itertools.product(itertools.permutations(range(count)), repeat=2):
            if random.random() < 0.8:
                continue
            times = [
                moment - first * a - second * b - random.choice((0.0, 0.0, 4.0))
                for a, b in zip(before, after, strict=True)
            ]
            collected = sum(whole[math.floor(time)] for time in times if time >= 0)
            assert collected <= Crew(whole, count, apart).collected(moment) + 1e-9


def least_makespan(routes, apart):
    """Return when vehicles with these times have landed at the earliest, waits as in `Crew`."""
    times = sorted((time for time in routes if time > 0.0), reverse=True)
    return max((sum(times[:k]) + apart * k * (k - 1) / 2) / k for k in range(1, len(times) + 1))


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(6))
def test_no_bound_exceeds_the_optimum_with_waits(seed):
    """All plans of six points and three vehicles, each with the least waits."""
    generator = np.random.default_rng(seed)
    points, depot = generator.uniform(0.0, 100.0, (6, 2)), generator.uniform(-50.0, 150.0, 2)
    legs = PointLegs(speed_mps=5.0, acceleration_mps2=2.0, stay=1.0)
    world = dataclasses.replace(one_depot(points, depot, 3, legs), apart=float(3 + 5 * seed))
    best = math.inf
    for owners in itertools.product(range(3), repeat=6):
        routes = [[c for c in range(6) if owners[c] == v] for v in range(3)]
        costs = [
            min(tiny_routing.cost(world, v, order) for order in itertools.permutations(route))
            for v, route in enumerate(routes)
        ]
        best = min(best, least_makespan(costs, world.apart))
    bounds = [bound.value for bound in improving_bounds(world, best)]
    assert max(bounds) <= best * (1 + 1e-9)
    prices = max(price_bounds(world, best))
    assert prices <= best * (1 + 1e-9)
    alone = max(price_bounds(dataclasses.replace(world, apart=0.0), best))
    assert prices >= alone


@pytest.mark.slow
def test_a_fleet_at_one_home_shares_the_waits():
    """Who waits longer flies less: all are done before routes of equal length would be."""
    fleet = tuple(vehicle(f'rav{k}', STARTS[0]) for k in range(1, 5))
    plan = plan_survey(request(vehicles=fleet, separation=SeparationOptions(by='delay')))
    assert check_plan(plan) == []
    equal = plan_survey(request(vehicles=fleet))
    (last,) = landing_queues(survey_site(plan.request).problem)
    assert plan.makespan_s < equal.makespan_s + 3 * last.interval_s
    assert plan.lower_bound_s > equal.lower_bound_s


def test_flights_may_be_flown_backwards_if_that_is_all_the_same():
    """Not by who lands elsewhere, nor where some points come last."""
    site = survey_site(request(separation=SeparationOptions(by='delay')))
    order = [3, 1, 2]
    assert [choice.flights for choice in FlightChoices(site, 0, order)] == [[order], [order[::-1]]]
    wide = request(vehicles=(vehicle(is_open=True),), separation=SeparationOptions(by='delay'))
    assert [one.flights for one in FlightChoices(survey_site(wide), 0, order)] == [[order]]
