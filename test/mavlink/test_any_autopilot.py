# SPDX-License-Identifier: Apache-2.0
"""The same flights with the fake copter and, where there is one, with a real ArduCopter.

`ROCSAFE_SITL` names the executable of ArduPilot's simulator; without it those are skipped.
"""

import math

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from std_srvs.srv import Trigger
from test.mavlink.airspace import Airspace
from test.mavlink.operator_post import HOME_PLACE, Ground, survey
from test.mavlink.sitl import BINARY, SitlAirspace

from rocsafe_geo.position import offset
from rocsafe_interfaces.action import FlyRoute, PlanSurvey
from rocsafe_interfaces.msg import (
    CameraSpec,
    GeoPolygon,
    Region,
    Route,
    VehicleSpec,
    VehicleState,
    Viewpoint,
)
from rocsafe_planner.conversions import message_of_plan, request_of_goal
from rocsafe_planner.options import PlannerOptions
from rocsafe_planner.planning import plan_survey
from rocsafe_ros import topics
from rocsafe_ros.conversions import point_of_position

# Wall time for a flight of some minutes on a busy machine.
DEADLINE_S = 120.0
# Of a fake copter: as fast as a bridge on a busy machine reads without dropping a message.
RATE, THREE_RATE = 15.0, 8.0
CIRCLE = {'FENCE_ENABLE': 1, 'FENCE_TYPE': 2, 'FENCE_RADIUS': 120, 'FENCE_ACTION': 1}
LOW_BATTERY_RETURNS = {'BATT_LOW_VOLT': 11.0, 'BATT_FS_LOW_ACT': 2}
# Time-outs of the autopilot run as fast as its time: slow enough for heartbeats once a second.
SLOW = 3.0
needs_sitl = pytest.mark.skipif(not BINARY, reason='ROCSAFE_SITL names no ArduPilot simulator')


@pytest.fixture(params=['fake', pytest.param('sitl', marks=[needs_sitl, pytest.mark.system])])
def make_air(request, tmp_path):
    """Give a function that puts copters into the air."""
    made = []

    def make(systems=(1,), parameters=None, rate=None):
        if request.param == 'sitl':
            made.append(SitlAirspace(systems, tmp_path, rate or 10.0, parameters))
        else:
            returns = bool((parameters or {}).get('FS_GCS_ENABLE'))
            made.append(Airspace(systems, rate or RATE, returns=returns))
        return made[-1]

    yield make
    for air in made:
        air.close()


@pytest.fixture
def start(ros, make_air, tmp_path):
    """Give a function that puts copters into the air and a bridge on the ground."""
    grounds = []

    def begin(systems=(1,), parameters=None, rate=None, **options):
        air = make_air(systems, parameters, rate)
        grounds.append(Ground(ros, air, tmp_path / 'state', **options))
        return grounds[-1]

    yield begin
    for ground in grounds:
        ground.close()


def routes_for(air, count, width_m, height_m):
    """Return the routes of a survey: of our planner where a real autopilot flies them.

    Before the first plan of a process its solver is compiled, which takes longer than a fake
    copter flies; it gets lanes.
    """
    if hasattr(air, 'is_real'):
        return planned(count, width_m, height_m)
    share_m = width_m / count
    return {
        f'rav{n + 1}': lanes(f'rav{n + 1}', n * share_m, share_m, height_m) for n in range(count)
    }


def lanes(vehicle, west_m, width_m, height_m, step_m=20.0):
    """Return a route of viewpoints on lanes to and fro."""
    places = []
    for lane in range(int(width_m // step_m) + 1):
        norths = [20.0 + step_m * n for n in range(int(height_m // step_m) + 1)]
        east = 20.0 + west_m + step_m * lane
        places += [(east, north) for north in (norths if lane % 2 == 0 else norths[::-1])]
    return Route(
        vehicle=vehicle,
        home=point_of_position(HOME_PLACE),
        viewpoints=[
            Viewpoint(
                id=number,
                position=point_of_position(offset(HOME_PLACE, *place, 25.0)),
                height_agl_m=25.0,
            )
            for number, place in enumerate(places)
        ],
    )


def planned(count, width_m, height_m):
    """Return the routes of a plan of our planner for `count` vehicles."""
    corners = [(20, 20), (20 + width_m, 20), (20 + width_m, 20 + height_m), (20, 20 + height_m)]
    boundary = [point_of_position(offset(HOME_PLACE, *corner)) for corner in corners]
    specs = [
        VehicleSpec(
            name=f'rav{number + 1}',
            home=point_of_position(HOME_PLACE),
            cruise_speed_mps=10.0,
            acceleration_mps2=2.5,
            climb_rate_mps=2.5,
            descent_rate_mps=1.0,
            hover_s=0.0,
            endurance_s=1500.0,
        )
        for number in range(count)
    ]
    goal = PlanSurvey.Goal(
        region=Region(name='field', boundary=GeoPolygon(points=boundary)),
        camera=CameraSpec(
            horizontal_fov_rad=math.radians(60.0), image_width_px=640, image_height_px=480
        ),
        vehicles=specs,
        height_agl_m=25.0,
        spacing_rule='iou',
        overlap_fraction=0.2,
        front_overlap_fraction=-1.0,
        max_viewpoints=500,
    )
    plan = plan_survey(request_of_goal(goal, PlannerOptions()))
    return {route.vehicle: route for route in message_of_plan(plan).routes}


def in_air(ground, route=None):
    """Fly; return the future of the result when the first waypoint is behind."""
    result = ground.fly(route=route)
    ground.listen(topics.STATE)
    ground.until(lambda: result.done() or ground.seen().viewpoints_visited >= 1, DEADLINE_S)
    assert not result.done(), result.result().result.error_msg
    return result


def ended(ground, result):
    """Return how a flight ended."""
    ground.until(result.done, DEADLINE_S)
    return result.result().result


def test_planned_survey_is_flown(start):
    """Thirty viewpoints and more, planned by our planner, every one visited, photographed."""
    ground = start()
    route = routes_for(ground.air, 1, 150.0, 110.0)['rav1']
    assert len(route.viewpoints) >= 30
    events = ground.listen(topics.EVENTS)
    ground.listen(topics.STATE)
    answer = ended(ground, ground.fly(route=route))
    assert (answer.outcome, answer.error_msg) == (FlyRoute.Result.COMPLETED, '')
    assert answer.viewpoints_visited == len(route.viewpoints)
    assert ground.seen().state == VehicleState.LANDED
    assert ground.seen().shots_taken == len(route.viewpoints)
    assert 'item reached' in {event.kind for event in events}


def test_three_vehicles_fly_one_plan(start):
    """On one port, through one process: each flies its own route."""
    ground = start((1, 2, 3), rate=THREE_RATE)
    routes = routes_for(ground.air, 3, 120.0, 80.0)
    states = {name: ground.listen(topics.STATE, name) for name in routes}
    results = {name: ground.fly_as(name, route) for name, route in routes.items()}
    for name, result in results.items():
        answer = ended(ground, result)
        assert (answer.outcome, answer.error_msg) == (FlyRoute.Result.COMPLETED, ''), name
        assert answer.viewpoints_visited == len(routes[name].viewpoints)
        assert states[name][-1].state == VehicleState.LANDED


def test_hold_resume_and_return(start):
    """The operator's orders are obeyed, and answered when they are."""
    ground = start()
    result = in_air(ground, survey(10))
    held = ground.call('rav1/hold', Trigger)
    assert (held.success, held.message) == (True, '')
    ground.until(lambda: ground.seen().state == VehicleState.HOLDING, DEADLINE_S)
    assert ground.call('rav1/resume', Trigger).success
    visited = ground.seen().viewpoints_visited
    ground.until(lambda: ground.seen().viewpoints_visited > visited, DEADLINE_S)
    assert ground.call('rav1/return_home', Trigger).success
    ground.until(lambda: ground.seen().state == VehicleState.RETURNING, DEADLINE_S)
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.RETURNED_EARLY
    assert visited < answer.viewpoints_visited < 10


def test_route_is_replaced_in_flight(start):
    """Paused, uploaded, read back, continued; the new route is flown to its end."""
    ground = start()
    first = in_air(ground, survey(10))
    second = ground.fly('p2', survey(3, height_m=35.0), replace=True)
    ground.until(first.done, DEADLINE_S)
    answer = ended(ground, second)
    assert (answer.outcome, answer.error_msg) == (FlyRoute.Result.COMPLETED, '')
    assert answer.viewpoints_visited == 3


def test_low_battery_ends_the_flight(start):
    """It returns by itself; the result names the reason in its own words."""
    ground = start(parameters=LOW_BATTERY_RETURNS)
    result = in_air(ground, survey(30))
    ground.air.drain()
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.BATTERY_LOW
    assert 'Battery' in answer.error_msg


def test_fence_ends_the_flight(start):
    """It leaves its circle, returns by itself, and is not sent out again."""
    ground = start(parameters=CIRCLE)
    result = in_air(ground, survey(12))
    ground.air.leave_fence()
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.FAILSAFE_FENCE
    assert 'fence breached' in answer.error_msg
    assert answer.viewpoints_visited < 12


def test_camera_is_triggered_by_distance(start):
    """Every 20 m between the first and the last waypoint, the counter without gaps."""
    ground = start(trigger_distance_m=20.0)
    answer = ended(ground, ground.fly(route=survey(6, step_m=40.0)))
    assert answer.outcome == FlyRoute.Result.COMPLETED
    ground.listen(topics.STATE)
    ground.until(lambda: ground.seen().vehicle == 'rav1', DEADLINE_S)
    # 200 m, the first at once.
    assert ground.seen().shots_taken == pytest.approx(11, abs=1)


def test_autopilot_that_starts_again_is_asked_anew(start):
    """Its rates are gone: within seconds positions come again, and nothing else was sent."""
    ground = start()
    fixes, events = ground.listen(topics.FIX), ground.listen(topics.EVENTS)
    ground.until(lambda: len(fixes) > 20 and fixes[-1].status.status >= 0, DEADLINE_S)
    ground.air.restart()
    ground.until(
        lambda: any(event.kind in ('started again', 'found') for event in events), DEADLINE_S
    )
    count = len(fixes)
    ground.until(lambda: len(fixes) > count + 20 and fixes[-1].status.status >= 0, DEADLINE_S)


def test_lost_receiver_ends_the_flight(start):
    """No fix is published, and the flight ends by landing."""
    ground = start()
    fixes = ground.listen(topics.FIX)
    result = in_air(ground, survey(30))
    ground.air.lose_gps()
    ground.until(lambda: fixes[-1].status.status == -1, DEADLINE_S)
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.FAILSAFE_POSITION
    assert 'EKF Failsafe' in answer.error_msg


def test_heartbeats_end_with_the_supervisor(start):
    """Nobody watches any more: the vehicle returns by itself, and is not told to resume."""
    ground = start(parameters={'FS_GCS_ENABLE': 1}, rate=SLOW, needs_supervisor=True)
    ground.supervise()
    result = in_air(ground, survey(20, height_m=10.0, step_m=20.0))
    ground.abandon()
    ground.until(lambda: ground.seen().state == VehicleState.RETURNING, DEADLINE_S)
    ground.supervise()
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.FAILSAFE_LINK
    assert 'GCS Failsafe' in answer.error_msg


def test_autopilot_that_is_gone_is_lost(start):
    """STALE, then LOST, with the place where it should be."""
    ground = start()
    predicted = ground.listen(topics.PREDICTED_FIX)
    in_air(ground, survey(30))
    ground.air.fall_silent()
    ground.until(lambda: ground.seen().state == VehicleState.LOST, DEADLINE_S)
    assert 'silent for' in ground.seen().text
    assert len(predicted) >= 6
    assert predicted[-1].latitude > predicted[0].latitude
