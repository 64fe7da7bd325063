# SPDX-License-Identifier: Apache-2.0
"""The checker finds what is wrong, and nothing wrong with what the planner makes."""

import dataclasses

import pytest
from hypothesis import HealthCheck, assume, given, settings

from rocsafe_geo.area import SurveyArea
from rocsafe_planner.errors import BeyondEnduranceError, NoWayError
from rocsafe_planner.plan_checker import check_plan
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.routing import METHODS

from .fleets import FLEET, request
from .surveys import ring, surveys

PLAN = plan_survey(request())
ROUTE = PLAN.routes[0]
SORTIE = ROUTE.sorties[0]


def spoilt(**changes):
    """Return the plan with a changed first flight."""
    sortie = dataclasses.replace(SORTIE, **changes)
    route = dataclasses.replace(ROUTE, sorties=(sortie,))
    return dataclasses.replace(PLAN, routes=(route, *PLAN.routes[1:]))


@pytest.mark.parametrize('method', METHODS)
@settings(max_examples=12, suppress_health_check=list(HealthCheck))
@given(survey=surveys())
def test_every_plan_is_valid(method, survey):
    """Concave, holed, thin or tiny regions, exclusions, wind, unlike fleets: no fault."""
    try:
        plan = plan_survey(dataclasses.replace(survey, method=method, proposals=50_000))
    except (BeyondEnduranceError, NoWayError, ValueError) as error:
        assume(not any(word in str(error) for word in ('exclusion', 'endurance')))
        raise
    assert check_plan(plan) == []


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
        (dataclasses.replace(PLAN, request=request(separation_m=50.0)), 'separation_m is 50'),
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


def test_an_exhausted_battery_is_found():
    """A flight longer than its battery lasts is named."""
    weak = dataclasses.replace(FLEET[0], endurance_s=100.0)
    route = dataclasses.replace(ROUTE, vehicle=weak)
    plan = dataclasses.replace(PLAN, routes=(route, *PLAN.routes[1:]))
    assert 'too long for its battery' in ' '.join(check_plan(plan))
