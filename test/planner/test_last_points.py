# SPDX-License-Identifier: Apache-2.0
"""Rests of surveys in which some viewpoints come last, and layers that are reserved."""

import dataclasses
import json
import math

import pytest

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.plan_json import plan_document
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.situation import Situation
from rocsafe_planner.plan.survey_options import CoverageOptions, Effort, SeparationOptions
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Aloft, Vehicle
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.replanning import replan

CORNER = GeoPosition(53.28, -9.06, 10.0)
CAMERA = PinholeCamera(2.0 * math.atan(15.0 / 32.0), 1000, 1000)


def request(side_m: float = 120.0, fleet: int = 3, **changes: object) -> SurveyRequest:
    """Return the survey of a square by vehicles with layers of their own."""
    corners = ((0, 0), (side_m, 0), (side_m, side_m), (0, side_m))
    area = SurveyArea(tuple(offset(CORNER, east - 10, north - 10) for east, north in corners))
    homes = [offset(CORNER, 30.0 * k, -40.0) for k in range(fleet)]
    return SurveyRequest(
        regions=(SurveyRegion(area=area),),
        camera=CAMERA,
        vehicles=tuple(Vehicle(name=f'rav{k}', home=home) for k, home in enumerate(homes)),
        coverage=CoverageOptions(height_agl_m=32.0),
        **{
            'separation': SeparationOptions(by='reserved'),
            'effort': Effort(proposals=20_000),
            **changes,
        },
    )


@pytest.fixture(scope='module')
def plan() -> SurveyPlan:
    """Give its plan."""
    return plan_survey(request())


def lost(plan: SurveyPlan, done: int = 3) -> Situation:
    """Return the situation in which the first vehicle is silent, all have visited `done`."""
    visited = {view.id for route in plan.routes for view in route.viewpoints[:done]}
    aloft = {
        route.vehicle.name: Aloft(position=route.viewpoints[done - 1].position, used_s=60.0)
        for route in plan.routes[1:]
    }
    last = frozenset(view.id for view in plan.routes[0].viewpoints[done:])
    return Situation(alive=aloft, visited=frozenset(visited), last=last)


@pytest.mark.slow
def test_last_viewpoints_come_after_all_others(plan: SurveyPlan):
    """Each vehicle visits them at its end, and nothing is lost or visited twice."""
    situation = lost(plan)
    rest = replan(plan, situation)
    flown = [[view.id in situation.last for view in route.viewpoints] for route in rest.routes]
    assert all(order == sorted(order) for order in flown)
    everything = {view.id for route in plan.routes for view in route.viewpoints}
    seen = [view.id for route in rest.routes for view in route.viewpoints]
    assert set(seen) == everything - situation.visited
    assert len(seen) == len(set(seen))
    assert replan(plan, situation) == rest


@pytest.mark.slow
def test_last_viewpoints_are_shared_out(plan: SurveyPlan):
    """The routes with the last viewpoints are balanced, not each part by itself."""
    situation = lost(plan)
    rest = replan(plan, situation)
    free = replan(plan, dataclasses.replace(situation, last=frozenset()))
    assert free.makespan_s <= rest.makespan_s + 1.0
    assert rest.makespan_s < 1.08 * free.makespan_s
    durations = [route.duration_s for route in rest.routes]
    assert max(durations) - min(durations) < 0.25 * max(durations)


def test_layers_stay_reserved_when_vehicles_are_lost(plan: SurveyPlan):
    """A layer belongs to a vehicle, not to a place in the list of those that are left."""
    heights = {route.vehicle.name: route.flight_height_m for route in plan.routes}
    assert sorted(heights.values()) == [32.0, 42.0, 52.0]
    for route in replan(plan, lost(plan)).routes:
        assert route.flight_height_m == heights[route.vehicle.name]


def test_files_keep_layers_and_last_viewpoints(plan: SurveyPlan, tmp_path):
    """What is read from a plan file has the same identity."""
    rest = replan(plan, lost(plan))
    for name, one in (('plan', plan), ('rest', rest)):
        path = tmp_path / f'{name}.json'
        path.write_text(json.dumps(plan_document(one)))
        assert read_plan(path).request.identity() == one.plan_id


def test_more_vehicles_than_layers_are_refused():
    """The text names the height and its limit."""
    with pytest.raises(ValueError, match='reserved layers is at 122 m: must be at most'):
        request(fleet=10)


def test_no_reserved_layer_changes_no_plan_id():
    """Ids of plans made before there were reserved layers stay as they are."""
    usual = request(separation=SeparationOptions())
    assert all(vehicle.layer is None for vehicle in usual.vehicles)
    assert usual.identity() == '74033615231a8b2f'
