# SPDX-License-Identifier: Apache-2.0
"""Vehicles kept apart by layers of height instead of waiting."""

import dataclasses
import functools
import json
import math

import pytest
from hypothesis import HealthCheck, assume, given, settings

from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.errors import BeyondEnduranceError, NoFreeHeightError, NoWayError
from rocsafe_planner.flights.keeping_apart import _turns
from rocsafe_planner.plan.plan_json import plan_document
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.survey_options import UnheardVehicle
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.replanning import replan

from .fleets import STARTS, changed, request, vehicle
from .surveys import surveys

# From one meadow, a few metres apart, all to the same rows.
CROWD = tuple(vehicle(f'rav{k}', (STARTS[0][0] + 2e-4 * k, STARTS[0][1])) for k in range(1, 5))


@functools.cache
def crowded(**changes):
    """Return the plan of four neighbours whose routes cross."""
    return plan_survey(request(vehicles=CROWD, distance_m=15.0, **changes))


@pytest.mark.slow
def test_layers_keep_apart():
    """Nobody comes nearer than asked for, some fly higher by whole separations, fewer wait."""
    waiting, layered = crowded(), crowded(by='layers')
    for plan in (waiting, layered):
        assert plan.minimum_separation_m >= 15.0
        assert check_plan(plan) == []
    heights = {route.flight_height_m for route in layered.routes}
    assert heights > {32.0}
    assert all((height - 32.0) % 15.0 == 0.0 for height in heights)
    assert {route.flight_height_m for route in waiting.routes} == {32.0}
    assert layered.makespan_s <= waiting.makespan_s + 1e-6


def test_a_layer_is_in_heights_footprints_and_times():
    """From a higher layer the camera is higher, sees more, and the climb takes longer."""
    layered, base = crowded(by='layers'), plan_survey(request(vehicles=CROWD))
    high = next(r for r in layered.routes if r.flight_height_m > 32.0)
    low = next(r for r in base.routes if r.vehicle.name == high.vehicle.name)
    more = high.flight_height_m - 32.0
    assert high.duration_s - low.duration_s == pytest.approx(more / 3.0 + more / 2.0)
    for above, below in zip(high.viewpoints, low.viewpoints, strict=True):
        assert above.position.altitude_m == pytest.approx(below.position.altitude_m + more)
        assert above.height_agl_m == 32.0 + more
        wide = above.footprint[1].longitude_deg - above.footprint[0].longitude_deg
        narrow = below.footprint[1].longitude_deg - below.footprint[0].longitude_deg
        assert wide / narrow == pytest.approx(high.flight_height_m / 32.0, rel=1e-6)


@pytest.mark.slow
def test_a_weak_battery_stays_low():
    """Who has no time for the climb waits instead."""
    free = plan_survey(request(vehicles=CROWD))
    longest = max(route.duration_s for route in free.routes)
    fleet = tuple(dataclasses.replace(v, endurance_s=longest + 1.0) for v in CROWD)
    plan = plan_survey(request(vehicles=fleet, distance_m=15.0, by='layers'))
    assert plan.minimum_separation_m >= 15.0
    assert check_plan(plan) == []
    assert all(s.duration_s <= longest + 1.0 for r in plan.routes for s in r.sorties)


def test_the_checker_sees_who_flies_in_another_layer():
    """A height that was not asked for is a fault, also where it is stated."""
    plan = crowded(by='layers')
    denied = changed(plan.request, by='delay')
    assert 'm high: height_agl_m is 32' in ' '.join(
        check_plan(dataclasses.replace(plan, request=denied))
    )


@pytest.mark.slow
@settings(max_examples=10, deadline=None, suppress_health_check=list(HealthCheck))
@given(surveys(distance_m=8.0, by='layers'))
def test_layered_plans_are_valid(survey):
    """All kinds of regions, exclusions, fleets and wind: the checker accepts the plan."""
    try:
        plan = plan_survey(changed(survey, method='nearest_to_shortest'))
    except (BeyondEnduranceError, NoWayError, ValueError) as error:
        assume(not any(word in str(error) for word in ('exclusion', 'endurance')))
        raise
    assert check_plan(plan) == []
    assert plan.minimum_separation_m >= 8.0 or math.isinf(plan.minimum_separation_m)


@pytest.mark.parametrize('landing', [{'end': CROWD[0].home}, {'is_open': True}, {}])
@pytest.mark.parametrize('aloft', [Aloft(position=CROWD[0].home), None])
@pytest.mark.parametrize('count', [1, 2, 3])
def test_flights_that_take_turns_are_all_flown_once(landing, aloft, count):
    """Also of a vehicle in the air that lands elsewhere, whose only flight is first and last."""
    flights = [[number] for number in range(count)]
    turns = _turns(vehicle(aloft=aloft, **landing), flights)
    assert turns[0] == flights
    for turn in turns:
        assert sorted(turn) == flights
        assert turn[0] == flights[0] or aloft is None
        assert turn[-1] == flights[-1] or not landing


@pytest.mark.slow
def test_no_layer_is_above_the_greatest_height():
    """Vehicles wait instead."""
    plan = crowded(by='layers', max_height_agl_m=45.0)
    heights = {route.flight_height_m for route in plan.routes}
    assert max(heights) <= 45.0 < max(r.flight_height_m for r in crowded(by='layers').routes)
    assert check_plan(plan) == []


def rest_of(plan, *, number=1, unheard=True, places=None, homes=None, **request_changes):
    """Return the rest of a plan for all but vehicle `number`, which nobody hears in the air."""
    plan = dataclasses.replace(plan, request=dataclasses.replace(plan.request, **request_changes))
    ids = [view.id for route in plan.routes for view in route.viewpoints]
    first, *others = plan.routes
    silent = others.pop(number - 1)
    place = first.viewpoints[0].position
    now = Aloft(position=dataclasses.replace(place, altitude_m=0.0), used_s=60.0)
    alive = {first.vehicle.name: now, **{route.vehicle.name: None for route in others}}
    lost = [
        UnheardVehicle(
            name=silent.vehicle.name,
            flight_height_m=silent.flight_height_m,
            home=home,
            places=places or tuple(view.position for view in silent.viewpoints),
        )
        for home in homes or [silent.vehicle.home]
    ]
    situation = Situation(
        alive=alive, visited=frozenset(ids[:1]), unheard=tuple(lost) if unheard else ()
    )
    return replan(plan, situation)


def stating(plan, **changes):
    """Return a plan with other statements about the vehicle that nobody hears."""
    request = dataclasses.replace(
        plan.request,
        continuation=dataclasses.replace(
            plan.request.continuation,
            unheard=changes.pop('unheard', plan.request.continuation.unheard),
        ),
    )
    return dataclasses.replace(plan, request=request, **changes)


@pytest.mark.slow
@pytest.mark.parametrize('by', ['layers', 'delay'])
def test_rest_keeps_away_from_the_height_of_a_vehicle_that_nobody_hears(by, tmp_path):
    """It goes on along its route by itself, at its height: the others fly in other layers."""
    plan = plan_survey(request(vehicles=CROWD, distance_m=15.0, by=by))
    # The others would fly in the lowest layer, too.
    heights_m = [route.flight_height_m for route in plan.routes]
    silent = 1 + heights_m[1:].index(min(heights_m[1:]))
    silent_m = heights_m[silent]
    rest = rest_of(plan, number=silent)
    flown = [route for route in rest.routes if route.sorties]
    assert flown
    assert all(abs(route.flight_height_m - silent_m) >= 15.0 - 1e-6 for route in flown)
    assert check_plan(rest) == []
    (document,) = plan_document(rest)['request']['continuation']['unheard']
    assert (document['name'], document['flight_height_m']) == (
        plan.routes[silent].vehicle.name,
        silent_m,
    )
    (tmp_path / 'plan.json').write_text(json.dumps(plan_document(rest)))
    again = read_plan(tmp_path / 'plan.json')
    assert again.request.continuation.unheard == rest.request.continuation.unheard
    assert again.near_unheard == rest.near_unheard
    free = rest_of(plan, number=silent, unheard=False)
    assert any(abs(route.flight_height_m - silent_m) < 15.0 for route in free.routes)
    again = stating(free, unheard=rest.request.continuation.unheard)
    assert any('is occupied' in fault for fault in check_plan(again))


def away(place, east_deg, north_deg=0.0):
    """Return a place beside another."""
    return dataclasses.replace(
        place,
        latitude_deg=place.latitude_deg + north_deg,
        longitude_deg=place.longitude_deg + east_deg,
    )


@pytest.mark.slow
def test_who_climbs_beside_the_way_of_a_vehicle_that_nobody_hears_is_free():
    """Its column and its route are elsewhere: nothing is stated, whatever the layer."""
    plan = plan_survey(request(vehicles=CROWD, distance_m=15.0, by='layers'))
    far = [away(view.position, 0.01) for view in plan.routes[1].viewpoints]
    rest = rest_of(plan, places=tuple(far), homes=[away(CROWD[1].home, 0.01)])
    assert rest.near_unheard == ()
    assert check_plan(rest) == []


@pytest.mark.slow
def test_who_must_climb_where_a_vehicle_may_be_that_nobody_hears_is_named():
    """Its homeward way crosses the columns of the others, and no layer below is free."""
    plan = plan_survey(request(vehicles=CROWD, distance_m=15.0, by='layers'))
    low = dataclasses.replace(plan.routes[1], flight_height_m=32.0)
    plan = dataclasses.replace(plan, routes=(plan.routes[0], low, *plan.routes[2:]))
    rest = rest_of(plan, places=tuple(vehicle.home for vehicle in CROWD))
    flown = {route.vehicle.name for route in rest.routes if route.sorties}
    assert flown
    assert set(rest.near_unheard) == flown
    assert check_plan(rest) == []
    hidden = check_plan(stating(rest, near_unheard=()))
    assert any('comes near to where rav2 may be' in fault for fault in hidden)


@pytest.mark.slow
def test_layer_is_changed_for_the_column_of_a_vehicle_that_nobody_hears():
    """Where it is higher, who would fly through the column of its home flies above it."""
    plan = plan_survey(request(vehicles=CROWD, distance_m=15.0, by='layers'))
    under = plan.routes[0].viewpoints[1].position
    high = dataclasses.replace(plan.routes[1], flight_height_m=47.0)
    plan = dataclasses.replace(plan, routes=(plan.routes[0], high, *plan.routes[2:]))
    beyond = away(under, 0.0, 0.002)
    free = rest_of(plan, homes=[beyond], places=(away(beyond, 1e-4),))
    rest = rest_of(plan, homes=[under], places=(away(under, 1e-4),))
    name = plan.routes[0].vehicle.name
    heights = [
        next(r.flight_height_m for r in one.routes if r.vehicle.name == name)
        for one in (free, rest)
    ]
    assert heights[0] < 47.0 < heights[1]
    assert name not in rest.near_unheard
    assert check_plan(rest) == []


@pytest.mark.slow
def test_rest_without_a_free_height_is_refused():
    """The others then go on with their own routes, which keep apart from that of the silent."""
    plan = plan_survey(request(vehicles=CROWD, distance_m=15.0))
    low = dataclasses.replace(plan.request.airspace, max_height_agl_m=40.0)
    with pytest.raises(NoFreeHeightError, match=r'up to 40 m keeps 15 m from .* at 32 m'):
        rest_of(plan, airspace=low)


@pytest.mark.slow
def test_rest_of_a_rest_in_another_layer_is_planned():
    """The silent vehicle is heard again: the next plan may use its height."""
    plan = plan_survey(request(vehicles=CROWD, distance_m=15.0))
    rest = rest_of(plan)
    names = [route.vehicle.name for route in rest.routes]
    last = replan(rest, Situation(alive=dict.fromkeys(names), visited=frozenset()))
    assert check_plan(last) == []
    assert min(r.flight_height_m for r in last.routes if r.sorties) == 32.0


@pytest.mark.slow
def test_rest_above_a_silent_vehicle_is_planned_within_the_batteries():
    """The climb to the lowest free layer counts: what it leaves no time for is left out."""
    plan = plan_survey(request(vehicles=CROWD, distance_m=15.0))
    first, silent = plan.routes[0].vehicle, plan.routes[1].vehicle
    unheard = UnheardVehicle(name=silent.name, flight_height_m=32.0, home=silent.home, places=())
    for left_s in (150.0, 180.0, 210.0):
        used = {first.name: first.endurance_s - left_s}
        rest = replan(plan, Situation(alive=used, visited=frozenset(), unheard=(unheard,)))
        assert check_plan(rest) == []
        assert rest.left_out
        assert rest.routes[0].flight_height_m >= 47.0
        assert left_s - 30.0 < rest.makespan_s <= left_s
