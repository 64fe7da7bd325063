# SPDX-License-Identifier: Apache-2.0
"""Whole plans."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, distance_m, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.errors import (
    BeyondEnduranceError,
    PlanningCancelledError,
    TooManyViewpointsError,
)
from rocsafe_planner.plan.survey_options import CoverageOptions
from rocsafe_planner.planning import plan_survey

from .fleets import FIELD, FLEET, RECTANGLE, STARTS, request, vehicle


def test_derailment_plan():
    """The seed's rectangle and starts: all seen, all visited once, figures that agree."""
    plan = plan_survey(request())
    assert plan.spacing_m == pytest.approx(24.634, abs=5e-4)
    assert plan.covered_fraction == pytest.approx(1.0, abs=1e-9)
    ids = sorted(v.id for route in plan.routes for v in route.viewpoints)
    assert ids == list(range(plan.viewpoint_count))
    assert [route.vehicle for route in plan.routes] == list(FLEET)
    assert plan.makespan_s == max(route.duration_s for route in plan.routes)
    assert 0.0 < plan.lower_bound_s <= plan.makespan_s
    assert plan.gap_fraction == pytest.approx(plan.makespan_s / plan.lower_bound_s - 1.0)
    assert plan.total_length_m == sum(route.length_m for route in plan.routes)


@pytest.mark.slow
def test_lengths_agree_with_the_geodesic():
    """A route's length is the sum of the distances between its places."""
    for route in plan_survey(request(area=FIELD)).routes:
        home = route.vehicle.home
        stops = [home, *(v.position for v in route.viewpoints), home]
        legs = [distance_m(a, b) for a, b in pairwise(stops)]
        assert route.length_m == pytest.approx(sum(legs), rel=1e-5)


def test_one_photograph_by_hand():
    """A yard smaller than one tile: climb, out, photograph, back, descend; proven optimal."""
    home = GeoPosition(53.28, -9.06, 40.0)
    yard = SurveyArea(
        tuple(offset(home, e, n) for e, n in ((98, -2), (102, -2), (102, 2), (98, 2)))
    )
    plan = plan_survey(request(area=yard, vehicles=(vehicle(home=(53.28, -9.06), altitude=40.0),)))
    (viewpoint,) = plan.routes[0].viewpoints
    assert distance_m(viewpoint.position, offset(home, 100.0, 0.0)) < 0.001
    assert viewpoint.position.altitude_m == pytest.approx(72.0, abs=0.001)
    assert viewpoint.height_agl_m == 32.0
    assert viewpoint.yaw_rad == pytest.approx(math.pi / 2)
    leg = 100.0 / 8.0 + 8.0 / 2.5
    assert plan.makespan_s == pytest.approx(32 / 3 + 32 / 2 + 2 * leg + 2.0, abs=1e-3)
    assert plan.gap_fraction == pytest.approx(0.0, abs=1e-9)


def test_footprints_are_what_the_camera_sees():
    """37 m across and 28 m along, about the point below the camera, image top to the north."""
    viewpoint = plan_survey(request()).routes[0].viewpoints[0]
    frame = LocalFrame(dataclasses.replace(viewpoint.position, altitude_m=0.0))
    corners = np.array([frame.enu_of(corner)[:2] for corner in viewpoint.footprint])
    x, y = 0.5 * 36.950, 0.5 * 27.713
    np.testing.assert_allclose(corners, [(-x, -y), (x, -y), (x, y), (-x, y)], atol=0.01)


def test_unknown_ground_altitude_stays_unknown():
    """Without the altitude of any home the camera's altitude is NaN, its height is not."""
    blind = vehicle(altitude=math.nan)
    known = plan_survey(request(vehicles=(vehicle(),))).routes[0]
    unknown = plan_survey(request(vehicles=(blind,))).routes[0]
    assert all(math.isnan(v.position.altitude_m) for v in unknown.viewpoints)
    assert unknown.viewpoints[0].height_agl_m == 32.0
    assert unknown.duration_s == pytest.approx(known.duration_s, rel=1e-5)


def test_the_same_request_has_the_same_plan():
    """Twice the same question: equal plans with one name; any other question has another."""
    assert plan_survey(request()) == plan_survey(request())
    names = {
        request(**changes).identity()
        for changes in (
            {},
            {'seed': 1},
            {'height_agl_m': 33.0},
            {'method': 'nearest_to_shortest'},
            {'overlap_fraction': 0.3},
            {'spacing_rule': 'linear'},
            {'area': FIELD},
            {'vehicles': FLEET[:2]},
            {'grid': 'rotated'},
            {'vehicles': FLEET[::-1]},
        )
    }
    assert len(names) == 10
    assert request(height_agl_m=32).identity() == request(height_agl_m=32.0).identity()
    assert request(max_height_agl_m=200.0).identity() == request().identity()


@pytest.mark.slow
def test_more_vehicles_than_viewpoints():
    """Vehicles without viewpoints stay at home, for no time at all."""
    many = tuple(vehicle(f'rav{k}', STARTS[k % 3]) for k in range(80))
    plan = plan_survey(request(vehicles=many))
    idle = [route for route in plan.routes if not route.viewpoints]
    assert len(idle) == 80 - plan.viewpoint_count
    assert all(route.duration_s == route.length_m == 0.0 for route in idle)


@pytest.mark.slow
def test_nearest_to_shortest_is_better_here():
    """On both of the seed's areas the second method is done earlier than the paper's."""
    for area in (RECTANGLE, FIELD):
        paper, other = (
            plan_survey(request(area=area, method=method))
            for method in ('paper_greedy', 'nearest_to_shortest')
        )
        assert other.makespan_s < paper.makespan_s


@pytest.mark.slow
def test_planning_stops_when_told():
    """The first refusal to go on ends it: without a plan at first, later with the best so far."""
    for limit in (1, 2, 3, 4):
        reports = []

        def go_on(*figures, reports=reports, limit=limit):
            reports.append(figures)
            return len(reports) < limit

        if limit < 3:
            with pytest.raises(PlanningCancelledError):
                plan_survey(request(), go_on)
        else:
            assert check_plan(plan_survey(request(), go_on)) == []
        assert len(reports) == limit


def test_battery_too_small_is_refused():
    """The worst vehicle is named with what it needs and what it has."""
    weak = (FLEET[0], dataclasses.replace(FLEET[1], endurance_s=200.0), FLEET[2])
    with pytest.raises(BeyondEnduranceError, match=r'rav2 needs 3\d\d s .* endurance_s is 200 s'):
        plan_survey(request(vehicles=weak))


@pytest.mark.parametrize(
    ('endurance_s', 'message'),
    [
        (10.0, r'rav1 needs \d+ s for viewpoint \d+ at 53\.\d+, -9\.\d+ alone: .* is 10 s'),
        (
            250.0,
            r'no plan for 59 viewpoints .* needs at least 262 s, .* at most 250 s',
        ),
    ],
)
def test_batteries_that_never_do_are_refused_without_a_search(endurance_s, message, monkeypatch):
    """What a bound or a single flight proves is said at once, without trying."""

    def searched(*_arguments, **_options):
        raise AssertionError('searched')

    monkeypatch.setattr('rocsafe_planner.routing.solver_method.solve', searched)
    weak = tuple(dataclasses.replace(v, endurance_s=endurance_s) for v in FLEET)
    with pytest.raises(BeyondEnduranceError, match=message):
        plan_survey(request(vehicles=weak, method='solver'))


@pytest.mark.slow
def test_no_survey_is_refused_for_a_few_thousand_photographs():
    """From 18 m the field has 2000 viewpoints: the usual limit is for slips of the pen."""
    plan = plan_survey(
        request(
            height_agl_m=18.0,
            method='strips',
            max_viewpoints=CoverageOptions(height_agl_m=18.0).max_viewpoints,
            area=FIELD,
        )
    )
    assert plan.viewpoint_count > 2000


def test_too_large_region_is_refused():
    """The number needed and the limit are named."""
    with pytest.raises(TooManyViewpointsError, match=r'at least 45 .* max_viewpoints is 10'):
        plan_survey(request(max_viewpoints=10))


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'vehicles': ()}, 'number of vehicles is 0: must be 1 to 1000'),
        ({'vehicles': (FLEET[0], FLEET[0])}, "vehicle name 'rav1' is given 2 times"),
        ({'height_agl_m': 0.0}, 'height_agl_m is 0 m: must be above 0'),
        ({'height_agl_m': 1e6}, 'height_agl_m is 1e.06 m: must be at most 20000 m'),
        ({'height_agl_m': 120.5}, 'height_agl_m is 120.5 m: must be at most max_height'),
        ({'height_agl_m': math.nan}, 'height_agl_m is nan'),
        ({'overlap_fraction': 1.0}, 'overlap_fraction is 1'),
        ({'spacing_rule': 'x'}, "spacing_rule is 'x': must be one of iou, linear"),
        ({'method': 'x'}, "method is 'x': must be one of solver, boustrophedon_minmax"),
        ({'grid': 'x'}, "grid is 'x': must be one of best, rotated"),
        ({'seed': -1}, 'seed is -1'),
        ({'max_viewpoints': 0}, 'max_viewpoints is 0: must be 1 to'),
        ({'budget_s': -1.0}, 'budget_s is -1 s: must be 0 or above'),
        (
            {'vehicles': (vehicle(home=(48.0, 11.0)),)},
            'rav1 home is 1\\d\\d\\d km from the region',
        ),
    ],
)
def test_impossible_requests_are_refused(changes, message):
    """Thing, value and limit are named in one line."""
    with pytest.raises(ValueError, match=message):
        plan_survey(request(**changes))


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'name': '../rav'}, "vehicle name is '../rav': must be a letter and"),
        ({'name': ''}, "vehicle name is ''"),
        ({'cruise_speed_mps': 0.0}, 'rav1 cruise_speed_mps is 0: must be above 0'),
        ({'hover_s': -1.0}, 'rav1 hover_s is -1: must be 0 or above'),
        ({'endurance_s': math.inf}, 'rav1 endurance_s is inf: must be a finite number'),
    ],
)
def test_impossible_vehicles_are_refused(changes, message):
    """The vehicle, the field, its value and its limit are named."""
    with pytest.raises(ValueError, match=message):
        vehicle(**changes)
