# SPDX-License-Identifier: Apache-2.0
"""The checker finds what is wrong, and nothing wrong with what the planner makes."""

import dataclasses

import pytest
from hypothesis import HealthCheck, assume, given, settings

from rocsafe_geo.position import offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.errors import BeyondEnduranceError, NoWayError
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.routing.methods import METHODS

from .fleets import FLEET, STARTS, changed, request, vehicle
from .surveys import ring, surveys

PLAN = plan_survey(request())
ROUTE = PLAN.routes[0]
SORTIE = ROUTE.sorties[0]


def spoilt(**changes):
    """Return the plan with a changed first flight."""
    sortie = dataclasses.replace(SORTIE, **changes)
    route = dataclasses.replace(ROUTE, sorties=(sortie,))
    return dataclasses.replace(PLAN, routes=(route, *PLAN.routes[1:]))


@pytest.mark.slow
@pytest.mark.parametrize('altitude_m', [-400.0, 584.0, 4500.0])
def test_plan_at_any_altitude_is_valid(altitude_m):
    """Areas and lengths are those of the plane of the homes, in the high Andes, too."""
    fleet = tuple(vehicle(f'rav{n}', home, altitude_m) for n, home in enumerate(STARTS, start=1))
    assert check_plan(plan_survey(request(vehicles=fleet))) == []


@pytest.mark.slow
@pytest.mark.parametrize('method', METHODS)
@settings(max_examples=8, suppress_health_check=list(HealthCheck))
@given(survey=surveys())
def test_every_plan_is_valid(method, survey):
    """Concave, holed, thin or tiny regions, exclusions, wind, unlike fleets: no fault."""
    try:
        plan = plan_survey(changed(survey, method=method, proposals=10_000))
    except (BeyondEnduranceError, NoWayError, ValueError) as error:
        assume(not any(word in str(error) for word in ('exclusion', 'endurance')))
        raise
    assert check_plan(plan) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ('plan', 'fault'),
    [
        (spoilt(viewpoints=SORTIE.viewpoints[1:], bends=SORTIE.bends[1:]), 'are not visited'),
        (
            spoilt(
                viewpoints=(*SORTIE.viewpoints, SORTIE.viewpoints[0]), bends=((), *SORTIE.bends)
            ),
            'more than once',
        ),
        (spoilt(length_m=SORTIE.length_m - 1.0), 'rav1: flight 1 states'),
        (spoilt(duration_s=SORTIE.duration_s + 5.0), 'rav1: flight 1 states'),
        (spoilt(bends=SORTIE.bends[1:]), 'has bends for'),
        (dataclasses.replace(PLAN, lower_bound_s=PLAN.makespan_s + 1.0), 'lower_bound_s is'),
        (
            dataclasses.replace(PLAN, covered_area_m2=0.9 * PLAN.covered_area_m2),
            'covered_area_m2 is',
        ),
        (dataclasses.replace(PLAN, minimum_separation_m=90.0), 'vehicles come within'),
        (
            dataclasses.replace(PLAN, request=request(distance_m=50.0)),
            'separation distance_m is 50',
        ),
        (dataclasses.replace(PLAN, request=request(vehicles=FLEET[::-1])), 'not one a vehicle'),
        (
            dataclasses.replace(
                PLAN,
                request=request(
                    exclusions=(
                        SurveyArea(ring([(-300, -40), (-250, -40), (-250, 60), (-300, 60)])),
                    )
                ),
            ),
            'nearer to an exclusion',
        ),
    ],
)
def test_faults_are_found(plan, fault):
    """Each kind of fault is named."""
    assert fault in ' '.join(check_plan(plan))


def test_a_bend_at_a_viewpoint_is_no_second_photograph():
    """A viewpoint on the edge of an exclusion may be a corner of the way as well."""
    bent = ((SORTIE.viewpoints[0].position,), *SORTIE.bends[1:])
    assert check_plan(spoilt(bends=bent)) == []


def test_an_exhausted_battery_is_found():
    """A flight longer than its battery lasts is named."""
    weak = dataclasses.replace(FLEET[0], endurance_s=100.0)
    route = dataclasses.replace(ROUTE, vehicle=weak)
    plan = dataclasses.replace(PLAN, routes=(route, *PLAN.routes[1:]))
    assert 'too long for its battery' in ' '.join(check_plan(plan))


def test_a_viewpoint_beyond_a_sharp_corner_may_be_left_out():
    """Legs keep to a zone widened with pointed corners: what lies in such a point is shut off."""
    here = PLAN.routes[0].viewpoints[3]
    ring = tuple(
        offset(here.position, e, n - 24.0)  # two clearances beyond a corner of 40 degrees
        for e, n in ((0.0, 0.0), (-9.0, -25.0), (9.0, -25.0))
    )
    views = tuple(view for route in PLAN.routes for view in route.viewpoints)
    wish = request(exclusions=(SurveyArea(ring),), clearance_m=10.0, viewpoints=views)
    plan = plan_survey(wish)
    assert here.id not in {view.id for route in plan.routes for view in route.viewpoints}
    assert check_plan(plan) == []


def test_a_leg_along_a_long_edge_is_beside_it():
    """Without a clearance legs follow edges; planes that differ by millimetres are no fault."""
    home = FLEET[0].home
    low, high = (offset(home, 15.0, n) for n in (-2000.0, 2000.0))
    wall = SurveyArea((low, high, offset(high, 9.0, 0.0), offset(low, 9.0, 0.0)))
    fleet = (dataclasses.replace(FLEET[0], home=offset(low, -0.01, 0.0)), FLEET[1])
    plan = plan_survey(
        request(vehicles=fleet, exclusions=(wall,), clearance_m=0.0, method='strips')
    )
    assert check_plan(plan) == []
