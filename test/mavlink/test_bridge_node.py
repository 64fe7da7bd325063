# SPDX-License-Identifier: Apache-2.0
"""The bridge between ROS and fake copters: what a vehicle's namespace offers, it offers."""

import math

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, NavSatFix
from std_srvs.srv import Trigger
from test.mavlink.airspace import Airspace
from test.mavlink.operator_post import HOME_PLACE, Ground, survey

from rocsafe_geo.position import offset
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import (
    GeoPolygon,
    VehicleEvent,
    VehicleState,
)
from rocsafe_interfaces.srv import GoTo, Preflight, PushFence, PushRally, SetSpeed
from rocsafe_ros import topics
from rocsafe_ros.conversions import point_of_position


@pytest.fixture
def air(request):
    """Give one fake copter, many times as fast as real."""
    airspace = Airspace(rate=getattr(request, 'param', 15.0))
    yield airspace
    airspace.close()


@pytest.fixture
def ground(ros, air, tmp_path):
    """Give a bridge with an operator."""
    made = Ground(ros, air, tmp_path)
    yield made
    made.close()


def in_air(ground, route=None):
    """Fly a route; return the future of its result when it is in the air on its way."""
    result = ground.fly(route=route)
    ground.listen(topics.STATE)
    ground.until(lambda: ground.state() is not None and ground.state().viewpoints_visited >= 1)
    return result


def test_route_is_flown_to_its_end(ground):
    """Positions, states, events and feedback come; the result says what was flown."""
    fixes, events = ground.listen(topics.FIX), ground.listen(topics.EVENTS)
    states, batteries = ground.listen(topics.STATE), ground.listen(topics.BATTERY_STATE)
    velocities, odoms = ground.listen(topics.VELOCITY), ground.listen(topics.ODOM)
    result = ground.fly()
    ground.until(result.done, 60.0)
    answer = result.result().result
    assert (answer.outcome, answer.error_msg) == (FlyRoute.Result.COMPLETED, '')
    assert answer.viewpoints_visited == 4
    assert answer.distance_flown_m == pytest.approx(240.0, abs=25.0)
    ground.until(lambda: states and states[-1].state == VehicleState.LANDED)
    seen = [state.state for state in states]
    wanted = (VehicleState.TAKING_OFF, VehicleState.FLYING, VehicleState.LANDED)
    assert [state for state in dict.fromkeys(seen) if state in wanted] == list(wanted)
    assert states[-1].viewpoints_visited == states[-1].viewpoint_count == 4
    assert states[-1].plan_id == 'p1'
    assert not states[-1].is_simulated
    wanted_kinds = {'found', 'armed', 'disarmed', 'item reached'}
    ground.until(lambda: {event.kind for event in events} >= wanted_kinds)
    known = [fix for fix in fixes if math.isfinite(fix.altitude)]
    highest = max(known, key=lambda fix: fix.altitude)
    assert highest.altitude == pytest.approx(HOME_PLACE.altitude_m + 15.0, abs=0.5)
    assert highest.status.status >= 0
    assert highest.position_covariance[0] == pytest.approx(0.09)
    assert max(odom.pose.pose.position.y for odom in odoms) == pytest.approx(120.0, abs=3.0)
    assert max(v.twist.linear.y for v in velocities) == pytest.approx(10.0, abs=0.1)
    assert batteries[-1].percentage == pytest.approx(0.8)
    indices = [feedback.viewpoint_index for feedback in ground.heard['feedback']]
    assert indices == sorted(indices)
    for kind, messages in ((NavSatFix, fixes), (Odometry, odoms), (TwistStamped, velocities)):
        assert all(isinstance(message, kind) for message in messages)
    assert isinstance(batteries[0], BatteryState)
    assert isinstance(events[0], VehicleEvent)


def test_same_route_joins_and_another_is_refused(ground):
    """What flies goes on; a goal that comes late ends with the flight."""
    first = in_air(ground)
    again = ground.fly()
    other = ground.fly('p2', survey(2))
    ground.until(other.done)
    assert other.result().result.outcome == FlyRoute.Result.REJECTED
    assert 'another route' in other.result().result.error_msg
    ground.until(lambda: first.done() and again.done(), 60.0)
    assert first.result().result == again.result().result
    late = ground.fly()
    ground.until(late.done)
    assert late.result().result.outcome == FlyRoute.Result.COMPLETED


@pytest.mark.parametrize(
    ('service', 'state'),
    [('land', VehicleState.LANDING)],
)
def test_route_is_given_up_by_request(ground, service, state):
    """The flight ends early, by name, and nothing resumes it."""
    result = in_air(ground, survey(8))
    assert ground.call(f'rav1/{service}', Trigger).success
    ground.wait_for_state(state)
    ground.until(result.done, 60.0)
    answer = result.result().result
    assert answer.outcome == FlyRoute.Result.RETURNED_EARLY
    assert 1 <= answer.viewpoints_visited < 8


def test_orders_on_the_ground_are_refused(ground):
    """The answer says why."""
    ground.listen(topics.FIX)
    ground.until(lambda: ground.heard['fix', 'rav1'])
    answer = ground.call('rav1/hold', Trigger)
    assert (answer.success, answer.message) == (False, 'rav1: the vehicle is on the ground')


def test_operator_flies_to_a_point_and_changes_speed(ground):
    """Then the route goes on from where it was left."""
    result = in_air(ground, survey(6))
    point = point_of_position(offset(HOME_PLACE, 50.0, 50.0))
    assert ground.call('rav1/set_speed', SetSpeed, speed_mps=12.0).success
    assert ground.call('rav1/go_to', GoTo, position=point, height_m=35.0).success
    ground.until(lambda: math.dist(ground.air.copters[1].place, (50.0, 50.0)) < 1.0)
    far = point_of_position(offset(HOME_PLACE, 0.0, 5000.0))
    refused = ground.call('rav1/go_to', GoTo, position=far, height_m=35.0)
    assert not refused.success
    assert 'distance from home' in refused.message
    assert not ground.call('rav1/set_speed', SetSpeed, speed_mps=0.0).success
    assert ground.call('rav1/resume', Trigger).success
    ground.until(result.done, 60.0)
    assert result.result().result.outcome == FlyRoute.Result.COMPLETED
    assert ground.air.copters[1].commands.count(300) == 1


def test_cancelled_goal_holds(ground):
    """The vehicle stays in the air where it is; the goal is over."""
    result = in_air(ground, survey(8))
    ground.until(ground.goal.cancel_goal_async().done)
    ground.until(result.done)
    assert result.result().result.outcome == FlyRoute.Result.CANCELLED
    assert ground.air.copters[1].is_paused


def test_fence_and_rally_points_are_pushed(ground):
    """They lie on the vehicle, and a route that leaves the fence is refused."""
    corners = [(-100, -100), (100, -100), (100, 100), (-100, 100)]
    ring = GeoPolygon(points=[point_of_position(offset(HOME_PLACE, *c)) for c in corners])
    ground.listen(topics.FIX)
    ground.until(lambda: ground.heard['fix', 'rav1'])
    assert ground.call('rav1/geofence/push', PushFence, inclusions=[ring]).success
    points = [point_of_position(offset(HOME_PLACE, 20.0, 20.0))]
    assert ground.call('rav1/rallypoint/push', PushRally, points=points, height_m=20.0).success
    assert [len(items) for items in ground.air.copters[1].missions.stored.values()] == [0, 4, 1]
    drone = ground.bridge._interfaces[0].drone
    ground.until(lambda: drone._line.station.member((1, 1)).fence is not None)
    result = ground.fly(route=survey(4))
    ground.until(result.done)
    assert 'within fence is 1 of 4 waypoints outside' in result.result().result.error_msg
    two = GeoPolygon(points=ring.points[:2])
    assert '3 or more' in ground.call('rav1/geofence/push', PushFence, inclusions=[two]).message


def test_preflight_lists_the_checks(ground):
    """Settings are read in the spelling that the vehicle has."""
    member = ground.bridge._interfaces[0].drone._line.station.member((1, 1))
    ground.until(lambda: member.reader is not None and member.reader.is_over)
    ground.until(lambda: member.vehicle.home is not None)
    answer = ground.call('rav1/preflight', Preflight)
    checks = {check.name: check for check in answer.checks}
    assert answer.may_fly
    assert checks['link-loss action'].value == 'FS_GCS_ENABLE = 0'
    assert checks['contact'].value == 'fresh'


@pytest.mark.parametrize('air', [8.0], indirect=True)
def test_silent_vehicle_is_predicted(ground):
    """STALE keeps its state and says where it should be; heard again, nothing is sent."""
    result = in_air(ground, survey(12))
    predicted = ground.listen(topics.PREDICTED_FIX)
    copter = ground.air.copters[1]
    commands = list(copter.commands)
    copter.is_silent = True
    ground.until(lambda: predicted, 10.0)
    assert 'silent for' in ground.state().text
    assert ground.state().state == VehicleState.FLYING
    assert predicted[-1].status.status == -1
    copter.is_silent = False
    ground.until(result.done, 60.0)
    assert result.result().result.outcome == FlyRoute.Result.COMPLETED
    assert [number for number in copter.commands if number != 511] == [
        number for number in commands if number != 511
    ]


def test_restarted_bridge_picks_up_the_flight(ros, air, tmp_path):
    """Plan, mission and progress are known again before anything is sent."""
    first = Ground(ros, air, tmp_path)
    in_air(first, survey(10))
    first.close()
    commands = list(air.copters[1].commands)
    second = Ground(ros, air, tmp_path)
    second.listen(topics.STATE)
    second.until(lambda: second.state() is not None and second.state().viewpoints_visited >= 1)
    assert second.state().plan_id == 'p1'
    joined = second.fly(route=survey(10))
    second.until(joined.done, 60.0)
    answer = joined.result().result
    assert (answer.outcome, answer.viewpoints_visited) == (FlyRoute.Result.COMPLETED, 10)
    sent = [number for number in air.copters[1].commands[len(commands) :] if number != 511]
    assert sent == []
    second.close()
