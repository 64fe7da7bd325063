# SPDX-License-Identifier: Apache-2.0
"""Flights between battery swaps: what each may take, and routes made of them."""

import dataclasses
import math

import pytest

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan.objective import OBJECTIVE_VALUES
from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.routing.battery_swaps import optimised_with_swaps
from rocsafe_planner.routing.costs import finish_s, objective_value
from rocsafe_planner.routing.flight_search import (
    caps_within,
    full_caps,
    may_search,
    time_of_flights,
)
from rocsafe_planner.routing.solver_method import optimised
from rocsafe_planner.routing.sorties import sorties
from rocsafe_planner.site.survey_site import survey_site
from rocsafe_planner.solver import solve

from .fleets import FLEET, problem, request, vehicle

HERE = GeoPosition(53.28, -9.07, 12.0)
FIELD = [(120.0 + 20.0 * x, 20.0 * y) for x in range(8) for y in range(5)]


def world(count=2, endurance_s=150.0, **changes):
    """Return a field beside a home of vehicles with small batteries."""
    fleet = tuple(
        vehicle(f'rav{k}', endurance_s=endurance_s, battery_swap_s=60.0, **changes)
        for k in range(count)
    )
    return problem(FIELD, [(0.0, 0.0)] * count, fleet)


def test_flights_within_a_time():
    """Two full flights of 150 s, a change of 60 s after each, and 40 s that are left."""
    place = world(1)
    assert caps_within(place, 460.0) == [[40.0, 150.0, 150.0]]
    assert caps_within(place, 425.0) == [[150.0, 150.0]]
    assert caps_within(world(1, used_s=30.0), 460.0) == [[120.0, 150.0, 70.0]]
    lone = dataclasses.replace(place.vehicles[0], battery_swap_s=None)
    assert caps_within(dataclasses.replace(place, vehicles=(lone,)), 460.0) == [[150.0]]


def test_time_of_full_flights():
    """Two vehicles take turns: the third flight ends with the second of one of them."""
    times = [time_of_flights(world(), count) for count in range(1, 5)]
    assert times == pytest.approx([150.0, 150.0, 360.0, 360.0])
    lone = dataclasses.replace(world().vehicles[0], battery_swap_s=None)
    alone = dataclasses.replace(world(), vehicles=(lone, lone))
    assert time_of_flights(alone, 3) == 0.0
    assert full_caps(world(), 3) == [[150.0] * 3] * 2
    assert full_caps(world(), 300) == []


def test_who_is_in_the_air_and_lands_elsewhere_is_left_alone():
    """Its first flight is like none of the others."""
    assert may_search(world())
    assert may_search(world(aloft=Aloft(position=HERE)))
    assert not may_search(world(aloft=Aloft(position=HERE), is_open=True))


@pytest.fixture(scope='module')
def swapped():
    """Return what a search that knows nothing of batteries finds, and what this one finds."""
    place, effort = world(endurance_s=100.0), Effort(proposals=30_000)
    plain = optimised(place, effort).orders
    return place, plain, optimised_with_swaps(place, effort, lambda _value, _bound: True).orders


def test_flights_are_searched_not_only_cut(swapped):
    """The last vehicle lands at least a tenth earlier than with routes cut afterwards."""
    place, plain, orders = swapped
    assert sorted(i for order in orders for i in order) == list(range(len(FIELD)))
    assert finish_s(place, orders) < 0.9 * finish_s(place, plain)


def test_flights_keep_to_their_batteries(swapped):
    """Each is flown on one battery, and none for nothing."""
    place, _, orders = swapped
    for k, order in enumerate(orders):
        flights = sorties(place, k, order)
        assert [i for flight in flights for i in flight] == order
        assert all(0.0 < place.duration_s(k, flight) <= 100.0 for flight in flights)


@pytest.mark.slow
@pytest.mark.parametrize(('objective', 'share'), [('total_distance', 0.99), ('energy', 1.0)])
def test_other_objectives_count_the_flights_too(objective, share):
    """Routes that are cut afterwards cost no less, and often more, whatever is added up."""
    place, effort = world(endurance_s=100.0), Effort(objective=objective, proposals=8_000)
    plain = optimised(place, effort).orders
    orders = optimised_with_swaps(place, effort, lambda _value, _bound: True).orders
    values = [objective_value(place, each, objective) for each in (orders, plain)]
    assert sorted(i for order in orders for i in order) == list(range(len(FIELD)))
    assert values[0] <= share * values[1] * (1.0 + 1e-9) < math.inf


def test_values_of_objectives_are_those_of_the_plan():
    """Flights, changes of batteries and stands: counted once, in search and plan alike."""
    fleet = tuple(dataclasses.replace(v, endurance_s=230.0, battery_swap_s=60.0) for v in FLEET)
    wish = request(vehicles=fleet, method='nearest_to_shortest')
    plan, place = plan_survey(wish), survey_site(wish).problem
    orders = [[view.id for view in route.viewpoints] for route in plan.routes]
    assert max(len(route.sorties) for route in plan.routes) > 1
    for objective, stated in OBJECTIVE_VALUES.items():
        value = objective_value(place, orders, objective)
        unit = 3600.0 if objective == 'energy' else 1.0
        assert value / unit == pytest.approx(stated(plan))


def test_without_need_nothing_else_is_searched():
    """With batteries that last the routes are those of the search for them."""
    place, effort = world(endurance_s=2000.0), Effort(proposals=5_000)
    found = optimised_with_swaps(place, effort, lambda _value, _bound: True)
    assert found.orders == optimised(place, effort).orders


@pytest.mark.slow
@pytest.mark.parametrize('may_do', [False, True])
def test_searches_for_flights_count_few_proposals(monkeypatch, may_do):
    """All together three times those of the first; none without changes where a bound forbids."""
    effort = Effort(proposals=20_000)
    free = optimised(world(endurance_s=2000.0), effort)
    needed_s = finish_s(world(endurance_s=2000.0), free.orders)
    endurance_s = 0.5 * (free.bound + needed_s) if may_do else 0.95 * free.bound
    counted: dict[str, list[int]] = {'solver_method': [], 'flight_search': []}
    for module, seen in counted.items():
        path = f'rocsafe_planner.routing.{module}.solve'

        def counting(task, options, *others, _seen=seen, **named):
            _seen.append(options.proposals)
            return solve(task, options, *others, **named)

        monkeypatch.setattr(path, counting)
    optimised_with_swaps(world(endurance_s=endurance_s), effort, lambda _value, _bound: True)
    first, *without_swaps = counted['solver_method']
    assert first == 20_000
    assert counted['flight_search']
    assert sum(without_swaps) + sum(counted['flight_search']) <= 2 * first
    assert len(without_swaps) == may_do
