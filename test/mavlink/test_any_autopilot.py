# SPDX-License-Identifier: Apache-2.0
"""The same flights with the fake copter and, where there are any, with real autopilots.

`ROCSAFE_SITL` names the executable of ArduPilot's simulator, `ROCSAFE_PX4` the folder of a build
of PX4; without them those flights are skipped.
"""

import math

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from std_srvs.srv import Trigger
from test.fakes import fake_autopilot
from test.mavlink.airspace import HARMLESS, told_once
from test.mavlink.autopilots import AUTOPILOTS, make_airspace
from test.mavlink.operator_post import HOME_PLACE, Ground, survey

from rocsafe_geo.position import GeoPosition, distance_m, offset
from rocsafe_interfaces.action import FlyRoute, PlanSurvey
from rocsafe_interfaces.msg import (
    CameraSpec,
    GeoPolygon,
    Region,
    Route,
    SurveyCoverage,
    VehicleSpec,
    VehicleState,
    Viewpoint,
)
from rocsafe_interfaces.srv import GoTo, PushFence, PushRally, Resume, SetSpeed
from rocsafe_mavlink import bridge_node
from rocsafe_mavlink.knowledge import telemetry as vehicle
from rocsafe_mavlink.vehicle_interface.node_timing import NodeTiming
from rocsafe_planner.conversions import message_of_plan, request_of_goal
from rocsafe_planner.options import PlannerOptions
from rocsafe_planner.planning import plan_survey
from rocsafe_ros.conversions import point_of_position
from rocsafe_ros.interfaces import topics

# Wall time for a flight of some minutes on a busy machine.
DEADLINE_S = 120.0
# Time-outs of the autopilot run as fast as its time: slow enough for heartbeats once a second.
SLOW = 3.0


@pytest.fixture(params=AUTOPILOTS)
def make_air(request, tmp_path):
    """Give a function that puts copters into the air."""
    made = []

    def make(*arguments):
        made.append(make_airspace(request.param, tmp_path, *arguments))
        return made[-1]

    yield make
    for air in made:
        air.close()


@pytest.fixture
def start(ros, make_air, tmp_path):
    """Give a function that puts copters into the air and a bridge on the ground."""
    grounds = []

    def begin(systems=(1,), precaution='', rate=None, **options):
        air = make_air(systems, precaution, rate)
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
        coverage=SurveyCoverage(
            height_agl_m=25.0, spacing_rule='iou', overlap_fraction=0.2, max_viewpoints=500
        ),
    )
    plan = plan_survey(request_of_goal(goal, PlannerOptions()))
    return {route.vehicle: route for route in message_of_plan(plan).routes}


def in_air(ground, route=None):
    """Fly; return the future of the result when the first waypoint is behind."""
    return ground.in_air(route, DEADLINE_S)


def ended(ground, result):
    """Return how a flight ended."""
    return ground.ended(result, DEADLINE_S)


def yaw_of(odometry):
    """Return the yaw of a level vehicle, or nearly so."""
    turn = odometry.pose.pose.orientation
    return 2.0 * math.atan2(turn.z, turn.w)


def height_of(odometry):
    """Return the height of a vehicle above the mission's origin."""
    return odometry.pose.pose.position.z


def test_planned_survey_is_flown(start):
    """Thirty viewpoints and more, planned by our planner, every one visited, photographed."""
    ground = start()
    route = routes_for(ground.air, 1, 150.0, 110.0)['rav1']
    assert len(route.viewpoints) >= 30
    events, odometries = ground.listen(topics.EVENTS), ground.listen(topics.ODOM)
    ground.listen(topics.STATE)
    result = ground.fly(route=route)
    # Of a faster flight a busy machine drops the odometry.
    with ground.air.calm(8.0):
        answer = ended(ground, result)
    assert (answer.outcome, answer.error_msg) == (FlyRoute.Result.COMPLETED, '')
    assert answer.viewpoints_visited == len(route.viewpoints)
    ground.until(lambda: ground.seen().state == VehicleState.LANDED, DEADLINE_S)
    assert ground.seen().shots_taken == len(route.viewpoints)
    ground.until(lambda: 'item reached' in {event.kind for event in events})
    # It looks as planned all the way, not where it flies; what it said of that may be late.
    ground.until(lambda: height_of(odometries[-1]) < 3.0, DEADLINE_S)
    (planned_yaw,) = {viewpoint.yaw_rad for viewpoint in route.viewpoints}
    yaws = [yaw_of(odometry) for odometry in odometries if height_of(odometry) > 23.0]
    turned = sorted(abs(math.remainder(yaw - planned_yaw, math.tau)) for yaw in yaws)
    assert len(turned) >= 20
    assert turned[len(turned) * 3 // 4] < math.radians(10.0)


def test_three_vehicles_fly_one_plan(start):
    """On one port, through one process: each flies its own route."""
    ground = start((1, 2, 3), rate=8.0)
    routes = routes_for(ground.air, 3, 120.0, 80.0)
    states = {name: ground.listen(topics.STATE, name) for name in routes}
    results = {name: ground.fly_as(name, route) for name, route in routes.items()}
    for name, result in results.items():
        answer = ended(ground, result)
        assert (answer.outcome, answer.error_msg) == (FlyRoute.Result.COMPLETED, ''), name
        assert answer.viewpoints_visited == len(routes[name].viewpoints)
        ground.until(
            lambda heard=states[name]: heard and heard[-1].state == VehicleState.LANDED, DEADLINE_S
        )


def late(delay_s):
    """Return a route that is begun late."""
    route = survey()
    route.delay_s = delay_s
    return route


def test_late_start_is_told_and_kept(start):
    """A drone that keeps away from others says so on the ground, then flies its whole route."""
    ground = start()
    states = ground.listen(topics.STATE)
    result = ground.fly(route=late(2.0))
    ground.until(lambda: any(state.state == VehicleState.WAITING for state in states))
    assert 'takes off in' in next(s for s in states if s.state == VehicleState.WAITING).text
    assert ended(ground, result).outcome == FlyRoute.Result.COMPLETED


@pytest.mark.parametrize('verb', ['hold', 'return_home', 'land'])
def test_late_start_is_withdrawn_by_a_command(start, verb):
    """A drone that was told to hold, return or land on the ground does not take off later."""
    ground = start()
    states = ground.listen(topics.STATE)
    result = ground.fly(route=late(30.0))
    ground.until(lambda: any(state.state == VehicleState.WAITING for state in states))
    assert ground.call(f'rav1/{verb}', Trigger).success
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.REJECTED
    assert f'its start was withdrawn: {verb.replace("_", " ")}' in answer.error_msg
    assert not ground.seen().shots_taken


def test_hold_resume_and_return(start):
    """The operator's orders are obeyed, and answered when they are."""
    ground = start()
    result = in_air(ground, survey(10))
    held = ground.call('rav1/hold', Trigger)
    assert (held.success, held.message) == (True, '')
    with ground.air.calm():
        ground.until(lambda: ground.seen().state == VehicleState.HOLDING, DEADLINE_S)
    assert ground.call('rav1/resume', Resume).success
    visited = ground.seen().viewpoints_visited
    with ground.air.calm():
        ground.until(lambda: ground.seen().viewpoints_visited > visited, DEADLINE_S)
        assert ground.call('rav1/return_home', Trigger).success
        ground.until(lambda: ground.seen().state == VehicleState.RETURNING, DEADLINE_S)
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.RETURNED_EARLY
    assert visited < answer.viewpoints_visited < 10


def test_climb_is_held(start):
    """It cannot pause yet, so it brakes; then it climbs on and flies its route."""
    ground = start()
    result = ground.fly(route=survey(3, height_m=60.0))
    ground.listen(topics.STATE)
    with ground.air.calm():
        ground.until(lambda: ground.seen().state == VehicleState.TAKING_OFF, DEADLINE_S)
        held = ground.call('rav1/hold', Trigger)
        assert (held.success, held.message) == (True, '')
        ground.until(lambda: ground.seen().state == VehicleState.HOLDING, DEADLINE_S)
        assert ground.seen().viewpoints_visited == 0
        resumed = ground.call('rav1/resume', Resume)
        assert (resumed.success, resumed.message) == (True, '')
    answer = ended(ground, result)
    assert (answer.outcome, answer.viewpoints_visited) == (FlyRoute.Result.COMPLETED, 3)


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
    ground = start(precaution='battery')
    result = in_air(ground, survey(30))
    ground.air.drain()
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.BATTERY_LOW
    assert ground.air.words['battery'] in answer.error_msg


def test_fence_ends_the_flight(start):
    """It leaves its circle, returns by itself, and is not sent out again."""
    ground = start(precaution='fence')
    result = in_air(ground, survey(12))
    ground.air.leave_fence()
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.FAILSAFE_FENCE
    assert ground.air.words['fence'] in answer.error_msg
    assert answer.viewpoints_visited < 12


def test_camera_is_triggered_by_distance(start):
    """Every 20 m between the first and the last waypoint, the counter without gaps."""
    ground = start(trigger_distance_m=20.0)
    answer = ended(ground, ground.fly(route=survey(6, step_m=40.0)))
    assert answer.outcome == FlyRoute.Result.COMPLETED
    ground.listen(topics.STATE)
    ground.until(lambda: ground.seen().state == VehicleState.LANDED, DEADLINE_S)
    # 200 m, the first at once.
    assert ground.seen().shots_taken == pytest.approx(11, abs=1)


def test_autopilot_that_starts_again_is_asked_anew(start):
    """Its rates are gone: within seconds positions come again, and nothing else was sent."""
    ground = start()
    fixes, events = ground.listen(topics.FIX), ground.listen(topics.EVENTS)
    ground.until(lambda: len(fixes) > 5 and fixes[-1].status.status >= 0, DEADLINE_S)
    told, heard = ground.air.told(), len(events)
    ground.air.restart()
    ground.until(
        lambda: any(event.kind in ('started again', 'found') for event in events[heard:]),
        DEADLINE_S,
    )
    count = len(fixes)
    ground.until(lambda: len(fixes) > count + 5 and fixes[-1].status.status >= 0, DEADLINE_S)
    # It reads settings and fence again, and asks for what it wants to hear.
    assert set(ground.air.told()[len(told) :]) <= HARMLESS


def test_lost_receiver_ends_the_flight(start):
    """No fix is published, and the flight ends by landing."""
    ground = start()
    fixes = ground.listen(topics.FIX)
    result = in_air(ground, survey(30))
    with ground.air.calm():
        ground.air.lose_gps()
        ground.until(lambda: fixes[-1].status.status == -1, DEADLINE_S)
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.FAILSAFE_POSITION
    assert ground.air.words['position'] in answer.error_msg


@pytest.fixture
def short_waits(request, monkeypatch):
    """Let a fake copter and its bridge wait less for who is silent; a real one has its time."""
    if request.node.callspec.params['make_air'] == 'fake':
        monkeypatch.setattr(fake_autopilot, 'GCS_TIMEOUT_S', 2.0)
        monkeypatch.setattr(bridge_node, 'TIMING', NodeTiming(supervisor_lease_s=1.5))
        monkeypatch.setattr(vehicle, 'STALE_AFTER_S', 1.0)
        monkeypatch.setattr(vehicle, 'LOST_AFTER_S', 3.5)


@pytest.mark.usefixtures('short_waits')
def test_heartbeats_end_with_the_supervisor(start):
    """Nobody watches any more: the vehicle returns by itself, and is not told to resume."""
    ground = start(precaution='link', rate=SLOW, needs_supervisor=True)
    ground.supervise()
    result = in_air(ground, survey(20, height_m=10.0, step_m=20.0))
    ground.abandon()
    with ground.air.calm():
        ground.until(lambda: ground.seen().state == VehicleState.RETURNING, DEADLINE_S)
    ground.supervise()
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.FAILSAFE_LINK
    assert ground.air.words['link'] in answer.error_msg


@pytest.mark.usefixtures('short_waits')
def test_autopilot_that_is_gone_is_lost(start):
    """STALE, then LOST, with the place where it should be."""
    ground = start()
    predicted = ground.listen(topics.PREDICTED_FIX)
    in_air(ground, survey(30))
    ground.air.fall_silent()
    ground.until(lambda: ground.seen().state == VehicleState.LOST, DEADLINE_S)
    assert 'silent for' in ground.seen().text
    ground.until(lambda: len(predicted) >= 3, DEADLINE_S)
    assert predicted[-1].latitude > predicted[0].latitude


def test_operator_flies_to_a_point(start):
    """There and at that height it stays; the route then goes on from where it was left."""
    ground = start()
    fixes = ground.listen(topics.FIX)
    result = in_air(ground, survey(6))
    place = offset(HOME_PLACE, 50.0, 50.0, 35.0)
    answer = ground.call('rav1/go_to', GoTo, position=point_of_position(place), height_m=35.0)
    assert (answer.success, answer.message) == (True, '')

    def is_there():
        # Without a position while it is not heard.
        fix = fixes[-1]
        if fix.status.status < 0:
            return False
        there = GeoPosition(fix.latitude, fix.longitude)
        return distance_m(there, place) < 1.5 and abs(fix.altitude - place.altitude_m) < 1.5

    ground.until(is_there, DEADLINE_S)
    far = point_of_position(offset(HOME_PLACE, 0.0, 5000.0))
    refused = ground.call('rav1/go_to', GoTo, position=far, height_m=35.0)
    assert not refused.success
    assert 'distance from home' in refused.message
    assert ground.call('rav1/resume', Resume).success
    answer = ended(ground, result)
    assert (answer.outcome, answer.error_msg) == (FlyRoute.Result.COMPLETED, '')
    assert answer.viewpoints_visited == 6
    assert told_once(ground.air.told()).count('COMMAND_LONG 300') == 1


def test_operator_changes_the_speed(start):
    """It flies at the new one; a speed that is none is refused."""
    ground = start()
    velocities = ground.listen(topics.VELOCITY)
    result = in_air(ground, survey(3, step_m=100.0))
    answer = ground.call('rav1/set_speed', SetSpeed, speed_mps=4.0)
    assert (answer.success, answer.message) == (True, '')

    def is_steady():
        speeds = [math.hypot(v.twist.linear.x, v.twist.linear.y) for v in velocities[-5:]]
        return all(3.5 < speed < 4.4 for speed in speeds)

    ground.until(is_steady, DEADLINE_S)
    assert not ground.call('rav1/set_speed', SetSpeed, speed_mps=0.0).success
    assert ended(ground, result).outcome == FlyRoute.Result.COMPLETED


def test_operator_lands_it(start):
    """The flight ends early, by name, and nothing resumes it."""
    ground = start()
    result = in_air(ground, survey(10))
    assert ground.call('rav1/land', Trigger).success
    with ground.air.calm():
        ground.until(lambda: ground.seen().state == VehicleState.LANDING, DEADLINE_S)
    answer = ended(ground, result)
    assert answer.outcome == FlyRoute.Result.RETURNED_EARLY
    assert 1 <= answer.viewpoints_visited < 10
    assert not ground.air.is_armed()


def test_cancelled_goal_holds(start):
    """The vehicle stays in the air where it is; the goal is over."""
    ground = start()
    result = in_air(ground, survey(10))
    with ground.air.calm():
        ground.until(ground.goal.cancel_goal_async().done, DEADLINE_S)
        ground.until(result.done, DEADLINE_S)
    assert result.result().result.outcome == FlyRoute.Result.CANCELLED
    ground.until(lambda: ground.seen().state == VehicleState.HOLDING, DEADLINE_S)
    assert ground.air.is_armed()


def test_fence_and_rally_points_are_pushed(start):
    """They lie on the vehicle, and a route that leaves the fence is refused until it is gone."""
    ground = start()
    ground.listen(topics.STATE)
    ground.until(lambda: ground.seen().state == VehicleState.DISARMED, DEADLINE_S)
    corners = [(-100, -100), (100, -100), (100, 100), (-100, 100)]
    ring = GeoPolygon(points=[point_of_position(offset(HOME_PLACE, *c)) for c in corners])
    answer = ground.call('rav1/geofence/push', PushFence, inclusions=[ring])
    assert (answer.success, answer.message) == (True, '')
    points = [point_of_position(offset(HOME_PLACE, 20.0, 20.0))]
    answer = ground.call('rav1/rallypoint/push', PushRally, points=points, height_m=20.0)
    assert (answer.success, answer.message) == (True, '')
    assert [ground.air.item_count(kind) for kind in (1, 2)] == [4, 1]
    refused = ended(ground, ground.fly(route=survey(4)))
    assert refused.outcome == FlyRoute.Result.REJECTED
    assert 'within fence is 1 of 4 waypoints outside' in refused.error_msg
    two = GeoPolygon(points=ring.points[:2])
    assert '3 or more' in ground.call('rav1/geofence/push', PushFence, inclusions=[two]).message
    answer = ground.call('rav1/geofence/push', PushFence)
    assert (answer.success, answer.message) == (True, '')
    assert ground.air.item_count(1) == 0
    in_air(ground, survey(4))
