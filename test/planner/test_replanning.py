# SPDX-License-Identifier: Apache-2.0
"""The rest of a survey, planned anew by those who are left."""

import dataclasses

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.errors import BeyondEnduranceError, NothingLeftError, PlannerError
from rocsafe_planner.export.plan_files import write_plan
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.vehicle import Aloft
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.replanning import leaving_exclusions_m, replan, unreachable

from .fleets import FIELD, FLEET, changed, request, vehicle

pytestmark = pytest.mark.slow

PLAN = plan_survey(
    request(area=FIELD, height_agl_m=60.0, method='boustrophedon_minmax', proposals=4000)
)


def midway(plan, share, lost):
    """Return the situation after each vehicle flew `share` of its viewpoints; one is lost."""
    visited, alive = set(), {}
    for route in plan.routes:
        done = route.viewpoints[: int(share * len(route.viewpoints))]
        visited |= {view.id for view in done}
        if route.vehicle.name != lost:
            place = done[-1].position if done else route.vehicle.home
            alive[route.vehicle.name] = Aloft(position=place, used_s=share * route.duration_s)
    return Situation(alive=alive, visited=frozenset(visited))


def ids(plan):
    """Return the ids of a plan's viewpoints in flying order."""
    return [view.id for route in plan.routes for view in route.viewpoints]


@pytest.mark.parametrize('lost', ['rav1', 'rav2', 'rav3'])
def test_nothing_is_lost_and_nothing_flown_twice(lost):
    """Two thirds of a field are left when one of three is lost: the others share it."""
    situation = midway(PLAN, 0.33, lost)
    rest = replan(PLAN, situation)
    assert sorted(ids(rest)) == sorted(set(ids(PLAN)) - situation.visited)
    assert check_plan(rest) == []
    assert rest.covered_fraction == pytest.approx(PLAN.covered_fraction)
    assert rest.lower_bound_s <= rest.makespan_s
    assert replan(PLAN, situation) == rest


def test_an_idle_vehicle_comes_home():
    """One viewpoint is left beside the first vehicle: the others fly home, and that is counted."""
    last = PLAN.routes[0].viewpoints[-1]
    alive = {
        name: Aloft(position=offset(last.position, 20.0 + 100.0 * k, 0.0))
        for k, name in enumerate(('rav1', 'rav2', 'rav3'))
    }
    situation = Situation(alive=alive, visited=frozenset(set(ids(PLAN)) - {last.id}))
    rest = replan(PLAN, situation)
    assert ids(rest) == [last.id]
    assert all(route.duration_s > 0.0 and len(route.sorties) == 1 for route in rest.routes)
    assert check_plan(rest) == []


def test_new_places_and_exclusions():
    """A place outside is added, another one shut off: that is left out and named."""
    situation = midway(PLAN, 0.5, 'rav2')
    target = offset(PLAN.routes[0].viewpoints[-1].position, 15.0, 200.0)
    shut = PLAN.routes[1].viewpoints[-1]
    ring = tuple(
        offset(shut.position, e, n)
        for e, n in ((-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0))
    )
    changed = Situation(
        alive=situation.alive,
        visited=situation.visited,
        new_places=(GeoPosition(target.latitude_deg, target.longitude_deg),),
        new_exclusions=(SurveyArea(ring),),
    )
    rest = replan(PLAN, changed)
    new = max(ids(PLAN)) + 1
    left = set(ids(PLAN)) - situation.visited
    assert sorted(ids(rest)) == sorted((left | {new}) - {shut.id})
    assert unreachable(rest) == (shut.id,)
    assert check_plan(rest) == []


def test_who_stands_at_home_takes_off_again():
    """A vehicle that landed with a fresh battery is one of the fleet; its climb is counted."""
    situation = midway(PLAN, 0.5, 'rav3')
    alive = {**situation.alive, 'rav1': None}
    rest = replan(PLAN, Situation(alive=alive, visited=situation.visited))
    assert rest.routes[0].vehicle.aloft is None
    assert check_plan(rest) == []


def test_a_plan_for_the_rest_can_be_planned_anew_too():
    """Two losses, one after the other: what was visited before each counts."""
    once = replan(PLAN, midway(PLAN, 0.3, 'rav1'))
    twice = replan(once, midway(once, 0.3, 'rav2'))
    done = {view.id for view in twice.request.continuation.visited}
    assert sorted(done | set(ids(twice))) == sorted(ids(PLAN))
    assert not done & set(ids(twice))
    assert check_plan(twice) == []


def test_a_spent_battery_is_changed_on_the_way():
    """A vehicle with 60 s left flies home, takes a new battery, and does the rest."""
    fleet = tuple(
        vehicle(v.name, (v.home.latitude_deg, v.home.longitude_deg), battery_swap_s=60.0)
        for v in FLEET
    )
    plan = plan_survey(request(vehicles=fleet, method='boustrophedon_minmax'))
    home = fleet[0].home
    alive = {'rav1': Aloft(position=offset(home, 30.0, 0.0), used_s=10_000.0 - 60.0)}
    rest = replan(plan, Situation(alive=alive))
    assert [len(s.viewpoints) > 0 for s in rest.routes[0].sorties] == [False, True]
    assert check_plan(rest) == []


@pytest.mark.parametrize(
    ('situation', 'error', 'message'),
    [
        (Situation(alive={}), PlannerError, 'no vehicle is left'),
        (Situation(alive={'x': None}), ValueError, "alive has 'x': must be of rav1, rav2, rav3"),
        (
            Situation(alive={'rav1': None}, visited=frozenset({9999})),
            ValueError,
            'visited has viewpoint 9999: the plan has no such one',
        ),
        (
            Situation(alive={'rav1': None}, visited=frozenset(ids(PLAN))),
            NothingLeftError,
            'all are photographed',
        ),
        (
            Situation(alive={'rav1': Aloft(position=FLEET[0].home, used_s=9_999.0)}),
            BeyondEnduranceError,
            'rav1 needs .* its endurance_s is 10000 s, 1 s of it left',
        ),
    ],
)
def test_impossible_situations_are_refused(situation, error, message):
    """Thing, value and limit are named in one line."""
    with pytest.raises(error, match=message):
        replan(PLAN, situation)


@settings(max_examples=4, deadline=None)
@given(st.data())
def test_whatever_happens_the_checker_accepts(data):
    """Any survivors, any share of the work done, in the air or at home."""
    share = data.draw(st.floats(0.0, 0.95))
    lost = data.draw(st.sampled_from(['', 'rav1', 'rav2', 'rav3']))
    situation = midway(PLAN, share, lost)
    rest = replan(PLAN, situation)
    assert sorted(ids(rest)) == sorted(set(ids(PLAN)) - situation.visited)
    assert check_plan(rest) == []


@pytest.mark.parametrize('clearance_m', [0.0, 2.0])
def test_who_is_in_a_new_exclusion_leaves_it_the_shortest_way(clearance_m):
    """Closed around a vehicle in the air, a zone is left at its nearest side; that is told."""
    situation = midway(PLAN, 0.5, 'rav2')
    here = situation.alive['rav1'].position
    ring = tuple(
        offset(here, e, n) for e, n in ((-8.0, -20.0), (30.0, -20.0), (30.0, 20.0), (-8.0, 20.0))
    )
    rest = replan(
        dataclasses.replace(PLAN, request=changed(PLAN.request, clearance_m=clearance_m)),
        Situation(
            alive=situation.alive,
            visited=situation.visited,
            new_exclusions=(SurveyArea(ring),),
        ),
    )
    assert check_plan(rest) == []
    # 8 m to the west, and the clearance
    assert leaving_exclusions_m(rest) == pytest.approx({'rav1': 8.0 + clearance_m}, abs=0.01)
    way_out = rest.routes[0].sorties[0].bends[0][0]
    assert way_out.longitude_deg < here.longitude_deg
    assert way_out.latitude_deg == pytest.approx(here.latitude_deg, abs=1e-7)


@pytest.mark.parametrize('count', [1, 40])
def test_an_open_route_out_of_a_new_exclusion(count):
    """It leaves the zone and lands at its last viewpoint; with nothing to do it flies home."""
    fleet = tuple(dataclasses.replace(v, is_open=True) for v in FLEET)
    plan = plan_survey(request(vehicles=fleet, method='boustrophedon_minmax'))
    here = offset(fleet[0].home, 60.0, 0.0)
    ring = tuple(offset(here, e, n) for e, n in ((-30.0, -9.0), (30.0, -9.0), (0.0, 20.0)))
    near = plan.routes[2].viewpoints[-1].position
    left = {view.id for view in plan.routes[2].viewpoints[-count:]}
    rest = replan(
        plan,
        Situation(
            alive={'rav1': Aloft(position=here), 'rav3': Aloft(position=near)},
            visited=frozenset(set(ids(plan)) - left),
            new_exclusions=(SurveyArea(ring),),
        ),
    )
    assert check_plan(rest) == []
    assert set(ids(rest)) == left
    assert set(leaving_exclusions_m(rest)) == {'rav1'}
    assert rest.routes[0].vehicle.is_open == (len(rest.routes[0].viewpoints) > 0) == (count > 1)


def test_an_open_route_with_nothing_to_do_lands_where_it_is(tmp_path):
    """Also where there are exclusions, from which it is far; its files say no more."""
    fleet = tuple(dataclasses.replace(v, is_open=True) for v in FLEET)
    plan = plan_survey(request(vehicles=fleet, method='boustrophedon_minmax'))
    here = offset(fleet[0].home, 60.0, 0.0)
    yard = SurveyArea(
        tuple(offset(here, e, n) for e, n in ((90.0, 0.0), (99.0, 0.0), (90.0, 9.0)))
    )
    last = plan.routes[2].viewpoints[-1]
    rest = replan(
        plan,
        Situation(
            alive={'rav1': Aloft(position=here), 'rav3': Aloft(position=last.position)},
            visited=frozenset(set(ids(plan)) - {last.id}),
            new_exclusions=(yard,),
        ),
    )
    assert check_plan(rest) == []
    assert [len(route.viewpoints) for route in rest.routes] == [0, 1]
    assert rest.routes[0].sorties[0].length_m == 0.0
    assert (tmp_path / 'plan-rav1.kmz') in write_plan(rest, tmp_path)


def test_battery_of_who_stands_at_home_counts():
    """A vehicle that landed with 400 s in its battery takes as much as that lasts for."""
    situation = midway(PLAN, 0.5, 'rav3')
    rest = replan(
        PLAN, Situation(alive={**situation.alive, 'rav1': 9_600.0}, visited=situation.visited)
    )
    assert 300.0 < rest.routes[0].duration_s <= 400.0
    assert check_plan(rest) == []


def weak(left_s):
    """Return the field's plan, and a situation in which all stand at home with so much battery."""
    alive = {route.vehicle.name: 10_000.0 - left_s for route in PLAN.routes}
    return PLAN, Situation(alive=alive, visited=frozenset(ids(PLAN)[:10]))


@pytest.mark.parametrize('left_s', [150.0, 220.0])
def test_weak_batteries_do_for_a_part(left_s):
    """All that is left is visited or named, and nobody has room for another viewpoint at once."""
    plan, situation = weak(left_s)
    rest = replan(plan, situation)
    left = set(ids(plan)) - situation.visited
    assert set(ids(rest)) | set(rest.left_out) == left
    assert ids(rest)
    assert rest.left_out
    assert not set(ids(rest)) & set(rest.left_out)
    assert unreachable(rest) == ()
    assert check_plan(rest) == []
    assert replan(plan, situation) == rest


def test_more_battery_serves_more():
    """The number of viewpoints of a partial plan rises with the batteries, up to all."""
    counts = [len(ids(replan(*weak(left_s)))) for left_s in (150.0, 300.0, 5_000.0)]
    assert counts == sorted(set(counts))
    assert counts[-1] == len(ids(PLAN)) - 10


def test_plan_of_a_part_is_read_again_and_continued(tmp_path):
    """What batteries did not do for is planned as soon as there are fresh ones."""
    plan, situation = weak(200.0)
    rest = replan(plan, situation)
    write_plan(rest, tmp_path)
    again = read_plan(tmp_path / 'plan.json')
    assert again.left_out == rest.left_out
    assert check_plan(again) == []
    after = Situation(alive=dict.fromkeys(situation.alive), visited=frozenset(ids(rest)))
    assert set(ids(replan(again, after))) == set(rest.left_out)


def test_checker_finds_a_viewpoint_that_is_neither_flown_nor_left_out():
    """A plan may not forget what it leaves out."""
    rest = replan(*weak(200.0))
    forgetful = dataclasses.replace(rest, left_out=rest.left_out[1:])
    assert any('not visited' in fault for fault in check_plan(forgetful))
