# SPDX-License-Identifier: Apache-2.0
"""Routes cut at battery swaps, and vehicles kept apart."""

import dataclasses
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.flights.flight_choice import FlightChoice
from rocsafe_planner.flights.flight_track import FlightTrack
from rocsafe_planner.flights.separation import TOLERANCE_M, minimum_separation_m
from rocsafe_planner.flights.timetable import timetable
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.routing.methods import nearest_to_shortest
from rocsafe_planner.routing.sorties import sorties
from rocsafe_planner.site.survey_site import survey_site

from .fleets import FLEET, problem, request, vehicle

ROW = [(20.0 * k, 0.0) for k in range(1, 9)]


def swapper(endurance_s, swap_s=30.0):
    """Return a row of eight points and a vehicle that swaps batteries at its west end."""
    return problem(ROW, [(0.0, 0.0)], (vehicle(endurance_s=endurance_s, battery_swap_s=swap_s),))


def test_a_sufficient_battery_flies_once():
    """Nothing is cut without need; nothing is flown for nothing."""
    assert sorties(swapper(1000.0), 0, list(range(8))) == [list(range(8))]
    assert sorties(swapper(1000.0), 0, []) == []


def test_the_cut_is_the_cheapest_of_all():
    """Against all ways to cut eight points into flights that the battery lasts for."""
    world = swapper(90.0)
    order = list(range(8))

    def cost(cuts):
        ends = [0, *cuts, 8]
        flights = [world.duration_s(0, order[a:b]) for a, b in pairwise(ends)]
        return sum(flights) + 30.0 * len(cuts) if max(flights) <= 90.0 else np.inf

    every = min(cost(cuts) for count in range(8) for cuts in combinations(range(1, 8), count))
    found = sorties(world, 0, order)
    assert len(found) > 1
    assert cost([sum(map(len, found[:k])) for k in range(1, len(found))]) == pytest.approx(every)


def test_a_point_out_of_reach_is_refused():
    """The point, the time and the battery are named; so is a vehicle that cannot swap."""
    with pytest.raises(BeyondEnduranceError, match=r'rav1 needs 5\d s for viewpoint 6 alone'):
        sorties(swapper(50.0), 0, list(range(8)))
    lone = problem(ROW, [(0.0, 0.0)], (vehicle(endurance_s=90.0),))
    with pytest.raises(BeyondEnduranceError, match='8 viewpoints: its endurance_s is 90 s'):
        sorties(lone, 0, list(range(8)))


def test_who_cannot_get_home_is_refused():
    """In the air with 20 s left it reaches neither its home nor a viewpoint and home."""
    spent = vehicle(
        endurance_s=300.0,
        battery_swap_s=30.0,
        aloft=Aloft(position=FLEET[0].home, used_s=280.0),
    )
    world = dataclasses.replace(swapper(300.0), vehicles=(spent,), starts=np.array([[500.0, 0.0]]))
    with pytest.raises(BeyondEnduranceError, match=r'endurance_s is 300 s, 20 s of it left$'):
        sorties(world, 0, list(range(8)))


def test_a_viewpoint_out_of_reach_is_named_as_users_know_it():
    """By the id that was given to it, and its place."""
    weak = tuple(dataclasses.replace(v, endurance_s=60.0, battery_swap_s=9.0) for v in FLEET)
    plan = plan_survey(request())
    some = tuple(view for view in plan.routes[0].viewpoints if view.id > 20)
    with pytest.raises(BeyondEnduranceError) as caught:
        plan_survey(request(vehicles=weak, viewpoints=some))
    known = {f'viewpoint {v.id} at {v.position.latitude_deg:.6f}' for v in some}
    assert any(name in str(caught.value) for name in known)


def test_a_plan_with_swaps_is_valid():
    """Three flights and their swaps, stated and checked."""
    fleet = tuple(dataclasses.replace(v, endurance_s=260.0, battery_swap_s=90.0) for v in FLEET)
    plan = plan_survey(request(vehicles=fleet))
    assert max(len(route.sorties) for route in plan.routes) > 1
    assert check_plan(plan) == []


@pytest.mark.slow
def test_flights_take_their_turns_to_keep_apart():
    """With another flight first, who would wait for 26 s takes off earlier; all is still true."""
    fleet = tuple(vehicle(f'rav{k}', endurance_s=190.0, battery_swap_s=60.0) for k in range(3))
    wish = request(vehicles=fleet, method='nearest_to_shortest', distance_m=8.0)
    plan = plan_survey(wish)
    as_cut = survey_site(wish)
    before = [
        sorties(as_cut.problem, k, order)
        for k, order in enumerate(nearest_to_shortest(as_cut.problem))
    ]
    assert max(route.delay_s for route in plan.routes) < max(delays(as_cut.problem, before, 8.0))
    assert check_plan(plan) == []


def test_the_sensor_goes_where_it_is_needed():
    """Only the vehicle that carries the sensor visits the region that requires it."""
    fleet = (dataclasses.replace(FLEET[0], sensors=('gamma',)), *FLEET[1:])
    plain = request(vehicles=fleet)
    region = dataclasses.replace(plain.regions[0], sensors=('gamma',))
    plan = plan_survey(dataclasses.replace(plain, regions=(region,)))
    assert [len(route.viewpoints) > 0 for route in plan.routes] == [True, False, False]


def delays(world, flights, separation_m):
    """Return how long vehicles wait that fly these flights and no others."""
    only = {k: [FlightChoice(world, k, own, 0.0, [])] for k, own in enumerate(flights)}
    starts = timetable(only, separation_m).starts_s
    return [float(starts[k]) for k in only]


def tracks(world, orders):
    """Return the tracks of single flights."""
    return [FlightTrack(world, k, [order]) for k, order in enumerate(orders)]


def test_a_meeting_by_hand():
    """Two that fly towards each other over 200 m meet half way; 10 m apart sideways."""
    world = problem([(200.0, 0.0), (0.0, 10.0)], [(0.0, 0.0), (200.0, 10.0)])
    assert minimum_separation_m(tracks(world, [[0], [1]]), [0.0, 0.0]) == pytest.approx(
        10.0, abs=TOLERANCE_M
    )


def test_a_lone_vehicle_meets_nobody():
    """No two in the air: infinitely far."""
    world = problem([(200.0, 0.0)], [(0.0, 0.0)])
    assert minimum_separation_m(tracks(world, [[0]]), [0.0]) == np.inf


@pytest.mark.slow
@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.sampled_from((0.0, 8.0, 30.0)))
def test_delays_keep_vehicles_apart(seed, separation):
    """Three vehicles that cross each other's ways, one home for two: apart once delayed."""
    generator = np.random.default_rng(seed)
    homes = [(0.0, 0.0), (0.0, 0.0), (200.0, 0.0)]
    world = problem(generator.uniform(0.0, 200.0, (12, 2)), homes)
    orders = [list(range(k, 12, 3)) for k in range(3)]
    flown = tracks(world, orders)
    late = delays(world, [[order] for order in orders], separation) if separation else [0.0] * 3
    least = minimum_separation_m(flown, late)
    assert least >= separation - TOLERANCE_M
    times = np.arange(0.0, 600.0, 0.5)
    for (a, late_a), (b, late_b) in combinations(zip(flown, late, strict=True), 2):
        flying = (
            (times >= late_a)
            & (times >= late_b)
            & (times <= min(a.windows[0, 1] + late_a, b.windows[0, 1] + late_b))
        )
        apart = a.places(times[flying] - late_a) - b.places(times[flying] - late_b)
        assert np.sqrt((apart**2).sum(axis=1)).min(initial=np.inf) >= least - 1e-6


def test_motions_that_are_kept_are_those_of_each_height_and_place():
    """Of the first flight and of later ones, and in layers, which share them."""
    points = np.array([[50.0, 0.0], [50.0, 40.0], [90.0, 10.0]])
    world = problem(points, [(0.0, 0.0), (10.0, 0.0)])
    for layers in ((0.0, 0.0), (15.0, 0.0), (0.0, 0.0)):
        other = world.in_layers(layers)
        for one in (0, 1):
            for order in ([0, 1], [1, 0, 2]):
                for is_first, is_last in ((True, False), (False, True)):
                    kept = other.kept_motion(one, order, is_first=is_first, is_last=is_last)
                    made = other.motion(one, order, is_first=is_first, is_last=is_last)
                    assert kept.places_enu == made.places_enu
                    assert kept.duration_s == made.duration_s
