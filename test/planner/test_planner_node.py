# SPDX-License-Identifier: Apache-2.0
"""The planner node over real topics and actions."""

import json
import math

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.parameter import Parameter

from rocsafe_interfaces.action import PlanSurvey
from rocsafe_interfaces.msg import (
    CameraSpec,
    GeoPoint,
    GeoPolygon,
    Region,
    SurveyCoverage,
    VehicleNow,
    VehicleSpec,
)
from rocsafe_planner.planner_node import PlannerNode
from rocsafe_ros.interfaces.topics import PLAN, create_subscription

from .terrains import write_terrain

# Of a search whose loops are compiled first, on a machine that does ten other things.
DEADLINE_S = 60.0
RECTANGLE = [
    (53.27959959, -9.0617270785),
    (53.2805257315, -9.0621271428),
    (53.2801009832, -9.0648776011),
    (53.2791748417, -9.0644775368),
]
FIELD = [
    (53.28323, -9.062691),
    (53.28215, -9.055781),
    (53.27884, -9.057240),
    (53.27887, -9.065051),
    (53.28164, -9.067411),
]


def goal(corners=RECTANGLE, **changes):
    """Return a goal for one vehicle over the seed's survey rectangle."""
    vehicle = VehicleSpec(
        name='rav1',
        home=GeoPoint(latitude=53.28, longitude=-9.07, altitude=12.0),
        cruise_speed_mps=8.0,
        acceleration_mps2=2.5,
        climb_rate_mps=3.0,
        descent_rate_mps=2.0,
        hover_s=2.0,
        endurance_s=10_000.0,
    )
    points = [GeoPoint(latitude=lat, longitude=lon, altitude=math.nan) for lat, lon in corners]
    values = {
        'region': Region(name='rectangle', boundary=GeoPolygon(points=points)),
        'camera': CameraSpec(
            horizontal_fov_rad=math.radians(60.0), image_width_px=640, image_height_px=480
        ),
        'vehicles': [vehicle],
        'coverage': SurveyCoverage(
            height_agl_m=32.0, spacing_rule='iou', overlap_fraction=0.2, grid='axis_aligned'
        ),
    }
    wish = PlanSurvey.Goal(**values)
    wish.effort.proposals = 2000
    for name, value in changes.items():
        groups = (wish, wish.coverage, wish.airspace, wish.separation, wish.effort)
        setattr(next(group for group in groups if hasattr(group, name)), name, value)
    return wish


class Desk:
    """A planner node, and a client that asks it."""

    def __init__(self, ros, **parameters):
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        self.ros = ros
        self.node = PlannerNode(context=ros.context, parameter_overrides=overrides)
        self.client_node = Node('client', context=ros.context)
        self.feedback, self.plans = [], []
        self.client = ActionClient(self.client_node, PlanSurvey, 'plan_survey')
        create_subscription(self.client_node, PLAN, self.plans.append)
        ros.executor.add_node(self.node)
        ros.executor.add_node(self.client_node)
        ros.spin_until(self.client.server_is_ready, DEADLINE_S)

    def wait_for(self, future):
        """Spin until a future is done and return its result."""
        self.ros.spin_until(future.done, DEADLINE_S)
        return future.result()

    def send(self, request):
        """Return the handle of an accepted goal."""
        return self.wait_for(
            self.client.send_goal_async(
                request, feedback_callback=lambda message: self.feedback.append(message.feedback)
            )
        )

    def ask(self, request):
        """Return the result of a goal."""
        return self.wait_for(self.send(request).get_result_async()).result

    def close(self):
        """Take both nodes down."""
        self.client.destroy()
        self.client_node.destroy_node()
        self.node.destroy_node()


@pytest.fixture
def open_desk(ros):
    """Give a function that opens a desk with parameters; close them all after the test."""
    desks = []

    def open_one(**parameters):
        desks.append(Desk(ros, **parameters))
        return desks[-1]

    yield open_one
    for desk in desks:
        desk.close()


def test_a_goal_gets_its_plan(open_desk, tmp_path):
    """Result, latched topic and exported file hold the same plan; feedback ends with its gap."""
    desk = open_desk(export_directory=str(tmp_path / 'out'))
    result = desk.ask(goal())
    assert (result.error_code, result.error_msg) == (PlanSurvey.Result.NONE, '')
    plan = result.plan
    assert plan.method == 'solver'
    assert plan.spacing_m == pytest.approx(24.634, abs=5e-4)
    assert plan.lower_bound_s <= plan.makespan_s == plan.routes[0].duration_s
    assert sorted(v.id for v in plan.routes[0].viewpoints) == list(range(59))
    desk.ros.spin_until(lambda: desk.plans, DEADLINE_S)
    assert [(p.plan_id, p.routes, p.header) for p in desk.plans] == [
        (plan.plan_id, plan.routes, plan.header)
    ]
    document = json.loads((tmp_path / 'out' / 'plan.json').read_text())
    assert document['plan_id'] == plan.plan_id
    assert desk.feedback[-1].best_makespan_s == plan.makespan_s
    assert desk.feedback[-1].gap_fraction >= plan.gap_fraction - 1e-12


def test_given_viewpoints_are_visited_instead_of_a_grid(open_desk, tmp_path):
    """All of them, once, with files of their own beside those of the survey."""
    desk = open_desk(export_directory=str(tmp_path / 'out'))
    home = goal().vehicles[0].home
    wanted = [
        GeoPoint(latitude=home.latitude, longitude=home.longitude + step, altitude=100.0)
        for step in (1e-4, 2e-4, 3e-4)
    ]
    result = desk.ask(goal(viewpoints=wanted))
    assert result.error_code == PlanSurvey.Result.NONE
    flown = [view for route in result.plan.routes for view in route.viewpoints]
    places = sorted(round(view.position.longitude - home.longitude, 6) for view in flown)
    assert places == [1e-4, 2e-4, 3e-4]
    folder = tmp_path / 'out' / f'further-{result.plan.plan_id}'
    assert (folder / 'plan.json').is_file()
    assert not (tmp_path / 'out' / 'plan.json').exists()


@pytest.mark.parametrize(
    ('changes', 'code', 'text'),
    [
        (
            {'height_agl_m': -1.0},
            PlanSurvey.Result.INVALID_REQUEST,
            'height_agl_m is -1 m: must be',
        ),
        ({'vehicles': []}, PlanSurvey.Result.INVALID_REQUEST, 'number of vehicles is 0: must be'),
        (
            {'region': Region()},
            PlanSurvey.Result.INVALID_REQUEST,
            'boundary has 0 distinct corners',
        ),
        ({'max_viewpoints': 9}, PlanSurvey.Result.TOO_MANY_VIEWPOINTS, 'max_viewpoints is 9'),
    ],
)
def test_a_refusal_says_why(open_desk, changes, code, text):
    """The result names what was wrong; no plan is published; the node goes on."""
    desk = open_desk()
    result = desk.ask(goal(**changes))
    assert result.error_code == code
    assert text in result.error_msg
    assert desk.plans == []
    assert desk.ask(goal()).error_code == PlanSurvey.Result.NONE


def test_a_short_battery_is_refused(open_desk):
    """The vehicle, the time it needs and its limit are named."""
    request = goal()
    request.vehicles[0].endurance_s = 100.0
    result = open_desk().ask(request)
    assert result.error_code == PlanSurvey.Result.BEYOND_ENDURANCE
    assert 'rav1 needs ' in result.error_msg
    assert 'endurance_s is 100 s' in result.error_msg


def test_a_long_planning_can_be_cancelled(open_desk):
    """The node answers while it plans, and stops when asked to."""
    desk = open_desk(max_viewpoints=20_000)
    handle = desk.send(goal(FIELD, height_agl_m=10.0, proposals=0))
    desk.ros.spin_until(lambda: desk.feedback, DEADLINE_S)
    desk.wait_for(handle.cancel_goal_async())
    result = desk.wait_for(handle.get_result_async()).result
    assert result.error_code == PlanSurvey.Result.CANCELLED
    assert desk.plans == []


def test_a_cancelled_search_gives_its_best(open_desk):
    """Long before its budget is spent, after feedback of time, best and bound: a whole plan."""
    desk = open_desk()
    handle = desk.send(goal(method='solver', budget_s=600.0))
    desk.ros.spin_until(
        lambda: desk.feedback and math.isfinite(desk.feedback[-1].best_makespan_s), DEADLINE_S
    )
    told = desk.feedback[-1]
    assert told.elapsed_s > 0.0
    assert told.best_makespan_s >= told.lower_bound_s
    desk.wait_for(handle.cancel_goal_async())
    result = desk.wait_for(handle.get_result_async()).result
    assert result.error_code == PlanSurvey.Result.CANCELLED
    assert 'the plan is the best so far' in result.error_msg
    assert sorted(v.id for v in result.plan.routes[0].viewpoints) == list(range(59))
    assert result.plan.makespan_s <= told.best_makespan_s + 1e-3
    assert desk.plans == []


def test_a_search_stopped_before_it_had_a_plan_is_cancelled(open_desk):
    """So far no routes that batteries last for: that is no refusal of the goal."""
    desk = open_desk()
    request = goal(method='solver', budget_s=600.0)
    request.vehicles[0].endurance_s = 795.0  # too little, and no cheap bound proves it
    handle = desk.send(request)
    desk.ros.spin_until(
        lambda: desk.feedback and math.isfinite(desk.feedback[-1].best_makespan_s), DEADLINE_S
    )
    desk.wait_for(handle.cancel_goal_async())
    result = desk.wait_for(handle.get_result_async()).result
    assert result.error_code == PlanSurvey.Result.CANCELLED
    assert result.error_msg == 'planning was stopped: cancelled; there is no plan yet'


def test_goals_reach_all_that_planning_can(open_desk, tmp_path):
    """Battery swaps, an open end, wind, separation, terrain, sensors and given viewpoints."""
    path = write_terrain(tmp_path / 'hill.tif', np.full((400, 400), 5.0, np.float32))
    request = goal(distance_m=5.0, by='layers', terrain_file=str(path), wind_east_mps=1.0)
    (vehicle,) = request.vehicles
    vehicle.endurance_s, vehicle.battery_swap_s = 250.0, 60.0
    vehicle.is_open, vehicle.sensors = True, ['gamma']
    request.region.sensors = ['gamma']
    (route,) = open_desk().ask(request).plan.routes
    assert len(route.flights) > 1
    assert sum(len(flight.viewpoints) for flight in route.flights) == len(route.viewpoints) == 59
    assert route.is_open
    assert list(route.flights[-1].homeward) == []
    lone = goal(viewpoints=[GeoPoint(latitude=53.2799, longitude=-9.063, altitude=math.nan)])
    (view,) = open_desk().ask(lone).plan.routes[0].viewpoints
    assert (view.position.latitude, view.position.longitude) == pytest.approx((53.2799, -9.063))


def test_a_newer_goal_takes_the_place(open_desk):
    """The older one ends with what it has; the newer one's plan is published."""
    desk = open_desk(max_viewpoints=20_000)
    older = desk.send(goal(FIELD, height_agl_m=10.0, proposals=0))
    newer = desk.ask(goal())
    result = desk.wait_for(older.get_result_async()).result
    assert result.error_code == PlanSurvey.Result.CANCELLED
    assert 'a newer goal took its place' in result.error_msg
    assert newer.error_code == PlanSurvey.Result.NONE
    desk.ros.spin_until(lambda: desk.plans, DEADLINE_S)
    assert [plan.plan_id for plan in desk.plans] == [newer.plan.plan_id]


def test_a_goal_that_is_sent_twice_is_planned_once(open_desk):
    """An orchestrator whose goal is accepted late sends it again: both get the one plan."""
    desk = open_desk()
    first, second = desk.send(goal(budget_s=1.0)), desk.send(goal(budget_s=1.0))
    results = [desk.wait_for(each.get_result_async()).result for each in (first, second)]
    assert [result.error_code for result in results] == [PlanSurvey.Result.NONE] * 2
    assert results[0].plan.plan_id == results[1].plan.plan_id
    desk.ros.spin_until(lambda: desk.plans, DEADLINE_S)
    assert [plan.plan_id for plan in desk.plans] == [results[0].plan.plan_id]


def test_one_of_two_that_wait_for_a_plan_may_leave(open_desk):
    """Its cancellation does not stop the search of the other."""
    desk = open_desk()
    first, second = desk.send(goal(budget_s=1.0)), desk.send(goal(budget_s=1.0))
    desk.wait_for(first.cancel_goal_async())
    assert desk.wait_for(second.get_result_async()).result.error_code == PlanSurvey.Result.NONE
    cancelled = desk.wait_for(first.get_result_async()).result
    assert cancelled.error_code == PlanSurvey.Result.CANCELLED


def test_a_wrong_goal_stops_no_search(open_desk):
    """It is refused, and the one under way goes on."""
    desk = open_desk()
    older = desk.send(goal(budget_s=1.0))
    assert desk.ask(goal(height_agl_m=-1.0)).error_code == PlanSurvey.Result.INVALID_REQUEST
    assert desk.wait_for(older.get_result_async()).result.error_code == PlanSurvey.Result.NONE


def test_legs_bend_around_exclusions(open_desk):
    """A zone between home and region: the ways around it are in the message, the zone too."""
    corners = [(53.279, -9.066), (53.281, -9.066), (53.281, -9.067), (53.279, -9.067)]
    points = [GeoPoint(latitude=lat, longitude=lon, altitude=math.nan) for lat, lon in corners]
    zone = Region(name='crane', boundary=GeoPolygon(points=points))
    plan = open_desk().ask(goal(exclusions=[zone], clearance_m=1.0)).plan
    (route,) = plan.routes
    bends = [bend for viewpoint in route.viewpoints for bend in viewpoint.approach]
    assert len(route.viewpoints[0].approach) == len(bends) > 0
    assert len(route.homeward) > 0
    for bend in (*bends, *route.homeward):
        assert bend.altitude == pytest.approx(44.0, abs=0.1)
    assert [zone.name for zone in plan.exclusions] == ['crane']
    assert plan.front_overlap_fraction == 0.2
    assert plan.objective == 'longest_time'
    assert plan.minimum_separation_m == math.inf


@pytest.mark.parametrize('is_restarted', [False, True])
def test_the_rest_of_a_plan_is_planned(open_desk, tmp_path, is_restarted):
    """By its id, from memory or from its file: what is left is shared by those who can fly."""
    desk = open_desk(export_directory=str(tmp_path))
    plan = desk.ask(goal(method='strips')).plan
    views = [view for route in plan.routes for view in route.viewpoints]
    if is_restarted:
        desk.node._plans.clear()
    place = views[3].position
    result = desk.ask(
        PlanSurvey.Goal(
            rest_of=plan.plan_id,
            visited=[view.id for view in views[:4]],
            able=[VehicleNow(name=plan.routes[0].vehicle, position=[place], used_s=60.0)],
        )
    )
    assert result.error_msg == ''
    (route,) = result.plan.routes
    assert sorted(view.id for view in route.viewpoints) == sorted(v.id for v in views[4:])
    unknown = desk.ask(PlanSurvey.Goal(rest_of='x'))
    assert unknown.error_msg == "rest_of is 'x': must be a plan of this planner"
