# SPDX-License-Identifier: Apache-2.0
"""The bridge between ROS and fake copters: what a vehicle's namespace offers, it offers."""

import json
import math
import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from sensor_msgs.msg import BatteryState, NavSatFix
from std_srvs.srv import Trigger
from test.mavlink.airspace import Airspace
from test.mavlink.operator_post import HOME_PLACE, Ground, survey

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import VehicleEvent, VehicleState
from rocsafe_interfaces.srv import Lease, Preflight, Resume, SetSpeed
from rocsafe_mavlink.autopilots.ardupilot import GUIDED, LOITER
from rocsafe_mavlink.bridge_node import BridgeNode
from rocsafe_mavlink.knowledge import telemetry as vehicle
from rocsafe_ros.interfaces import topics
from rocsafe_ros.parameters import ParameterError
from rocsafe_ros.plan_digest import route_digest

# SET_MESSAGE_INTERVAL: it changes nothing of what a vehicle does.
ASK_FOR_A_RATE = 'COMMAND_LONG 511'


@pytest.fixture
def air(request):
    """Give one fake copter, many times as fast as real; it speaks without being asked."""
    airspace = Airspace(streams=getattr(request, 'param', True))
    yield airspace
    airspace.close()


@pytest.fixture
def ground(ros, air, tmp_path):
    """Give a bridge with an operator."""
    made = Ground(ros, air, tmp_path)
    yield made
    made.close()


@pytest.mark.parametrize('air', [False], indirect=True, ids=['silent until asked'])
def test_route_is_flown_to_its_end(ground):
    """Positions, states, events and feedback come; the result says what was flown."""
    fixes, events = ground.listen(topics.FIX), ground.listen(topics.EVENTS)
    states, batteries = ground.listen(topics.STATE), ground.listen(topics.BATTERY_STATE)
    velocities, odoms = ground.listen(topics.VELOCITY), ground.listen(topics.ODOM)
    result = ground.fly()
    # Here every message counts: an operator on a busy machine drops some of a faster flight.
    with ground.air.calm(8.0):
        answer = ground.ended(result)
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
    first = ground.in_air()
    again = ground.fly()
    other = ground.fly('p2', survey(2))
    ground.until(other.done)
    assert other.result().result.outcome == FlyRoute.Result.REJECTED
    assert 'another route' in other.result().result.error_msg
    ground.until(lambda: first.done() and again.done())
    assert first.result().result == again.result().result
    late = ground.fly()
    ground.until(late.done)
    assert late.result().result.outcome == FlyRoute.Result.COMPLETED


def test_orders_on_the_ground(ground):
    """Whom nothing moves is told to hold, return or land without harm; others say why not."""
    ground.listen(topics.FIX)
    ground.until(lambda: ground.heard['fix', 'rav1'])
    for verb in ('hold', 'return_home', 'land'):
        answer = ground.call(f'rav1/{verb}', Trigger)
        assert (answer.success, answer.message) == (True, '')
    answer = ground.call('rav1/resume', Resume)
    assert (answer.success, answer.message) == (False, 'rav1: the vehicle is on the ground')


@pytest.mark.parametrize('verb', ['hold', 'return_home', 'land', 'cancel'])
def test_start_is_called_off(ground, verb):
    """As soon as the goal has come, before and during the upload: it never takes off."""
    ground.listen(topics.STATE)
    result = ground.fly()
    if verb == 'cancel':
        ground.until(ground.goal.cancel_goal_async().done)
    else:
        assert ground.call(f'rav1/{verb}', Trigger).success
    ground.until(result.done)
    assert result.result().result.outcome != FlyRoute.Result.COMPLETED
    copter = ground.air.copters[1]
    ground.listen_for(3.0)
    assert not copter.is_armed


def test_preflight_lists_the_checks(ground):
    """Settings are read in the spelling that the vehicle has."""
    session = ground.bridge._interfaces[0].drone.session
    ground.until(
        lambda: (found := session.readout.settings.parameters) is not None and found.is_over
    )
    ground.until(lambda: session.telemetry.home is not None)
    answer = ground.call('rav1/preflight', Preflight)
    checks = {check.name: check for check in answer.checks}
    assert answer.may_fly
    assert checks['link-loss action'].value == 'FS_GCS_ENABLE = 0'
    assert checks['contact'].value == 'fresh'


def test_silent_vehicle_is_predicted(ground, monkeypatch):
    """STALE keeps its state and says where it should be; heard again, nothing is sent."""
    monkeypatch.setattr(vehicle, 'STALE_AFTER_S', 1.5)
    result = ground.in_air(survey(12))
    predicted = ground.listen(topics.PREDICTED_FIX)
    copter, told = ground.air.copters[1], ground.air.told()
    with ground.air.calm(1.0):
        copter.is_silent = True
        ground.until(lambda: predicted and 'silent for' in ground.seen().text)
        assert ground.seen().state == VehicleState.FLYING
        assert predicted[-1].status.status == -1
        copter.is_silent = False
    assert ground.ended(result).outcome == FlyRoute.Result.COMPLETED
    assert set(ground.air.told()[len(told) :]) <= {ASK_FOR_A_RATE}


def test_restarted_bridge_picks_up_the_flight(ros, air, tmp_path):
    """Plan, mission and progress are known again before anything is sent."""
    first = Ground(ros, air, tmp_path)
    first.in_air(survey(10))
    first.close()
    told = air.told()
    second = Ground(ros, air, tmp_path)
    second.listen(topics.STATE)
    with air.calm():
        second.until(lambda: second.seen().viewpoints_visited >= 1)
        assert second.seen().plan_id == 'p1'
        joined = second.fly(route=survey(10))
    answer = second.ended(joined)
    assert (answer.outcome, answer.viewpoints_visited) == (FlyRoute.Result.COMPLETED, 10)
    assert set(air.told()[len(told) :]) <= {ASK_FOR_A_RATE}
    second.close()


def test_delay_of_a_route_does_not_count_again_after_a_restart(ros, air, tmp_path):
    """The mission sends the route again: it is due when it was before."""
    route, due_s = survey(), []
    route.delay_s = 600.0
    for _ in range(2):
        post = Ground(ros, air, tmp_path)
        post.listen(topics.STATE)
        post.fly(route=route)
        post.until(lambda post=post: post.seen().state == VehicleState.WAITING)
        (kept,) = tmp_path.rglob('late_start.json')
        due_s.append(json.loads(kept.read_text())['due_s'])
        post.close()
    assert due_s[0] == due_s[1]


def test_goal_without_the_lease_ends_no_wait_of_another(ground):
    """Nor does it wait itself: it is refused before its delay counts."""
    route = survey()
    route.delay_s = 600.0
    waiting = ground.fly(route=route)
    ground.listen(topics.STATE)
    ground.until(lambda: ground.seen().state == VehicleState.WAITING)
    for delay_s in (0.0, 5.0):
        foreign = survey(4)
        foreign.delay_s = delay_s
        goal = FlyRoute.Goal(route=foreign, plan_id='other', lease='')
        refused = ground.ended(ground.send(goal))
        assert refused.outcome == FlyRoute.Result.REJECTED
        assert 'led by operator' in refused.error_msg
    assert not waiting.done()
    assert ground.seen().state == VehicleState.WAITING


@pytest.mark.parametrize('delay_s', [0.0, 600.0])
def test_start_that_waits_ends_when_a_pilot_uses_the_vehicle(ground, delay_s):
    """He flies and lands: it does not take off when he walks up to it."""
    copter = ground.air.copters[1]
    ground.listen(topics.STATE)
    ground.until(lambda: ground.seen().state == VehicleState.DISARMED)
    if not delay_s:
        copter.be_flown(LOITER)
        ground.until(lambda: ground.seen().state != VehicleState.DISARMED)
    route = survey()
    route.delay_s = delay_s
    waiting = ground.fly(route=route)
    ground.listen_for(0.5)
    if delay_s:
        copter.be_flown(LOITER)
    else:
        copter.be_landed()
    answer = ground.ended(waiting)
    assert answer.outcome == FlyRoute.Result.REJECTED
    assert 'withdrawn: somebody else switched its motors' in answer.error_msg


@pytest.mark.parametrize('delay_s', [math.nan, math.inf, -1.0, 1e308])
def test_delay_that_is_no_time_is_refused(ground, delay_s):
    """Others are kept away by it: without one the vehicle must not begin at once."""
    route = survey()
    route.delay_s = delay_s
    answer = ground.ended(ground.fly(route=route))
    assert answer.outcome == FlyRoute.Result.REJECTED
    assert 'delay_s is' in answer.error_msg
    assert not ground.air.copters[1].is_armed


def test_clock_that_is_set_in_flight_moves_no_time_stamp_of_a_signature(ground, monkeypatch):
    """Stamps of the future would lock other stations out, also after the clock is right again."""
    heard = []
    (station,) = ground.bridge._stations.values()
    for name in ('take', 'tick'):
        called = getattr(station, name)

        def noted(now_s, time_s, called=called, **options):
            heard.append(time_s)
            called(now_s, time_s, **options)

        monkeypatch.setattr(station, name, noted)
    before_s = time.time()
    monkeypatch.setattr(time, 'time', lambda: before_s + 1e8)
    ground.listen(topics.FIX)
    ground.until(lambda: ground.heard['fix', 'rav1'] and len(heard) > 20)
    assert all(before_s - 60.0 < time_s < before_s + 600.0 for time_s in heard)


def test_old_parameters_are_refused_with_the_new_name(ros):
    """A parameter file that was written before there was a drones file."""
    old = Parameter('links', value=['udp://127.0.0.1:14550'])
    line = 'parameter links is now link of a drone in the file that drones_file names'
    with pytest.raises(ParameterError, match=line):
        BridgeNode(context=ros.context, parameter_overrides=[old])


def test_take_off_must_be_confirmed_for_this_route(ground):
    """A refusal names the confirmation; that of another route does not count."""
    route, other = survey(), survey(count=3)
    goal = FlyRoute.Goal(route=route, plan_id='p1', lease=ground.lease())
    for wrong in ('', 'yes', route_digest('p1', other), route_digest('p2', route)):
        goal.confirmation = wrong
        answer = ground.ended(ground.send(goal))
        assert answer.outcome == FlyRoute.Result.REJECTED
        wanted = f'send this goal with confirmation {route_digest("p1", route)}'
        assert answer.error_msg.endswith(wanted)
    assert not ground.air.copters[1].is_flying


def test_takeover_makes_the_lease_void_until_it_is_taken_again(ground):
    """Another station switches to GUIDED, a mode that obeys us, too: our orders are refused."""
    controls = ground.listen(topics.CONTROL)
    ground.in_air()
    lease = controls[-1].lease
    with ground.air.calm():
        ground.air.copters[1].mode = GUIDED
        ground.until(lambda: not controls[-1].lease)
        assert 'is void: taken over: switched to GUIDED' in controls[-1].text
        refused = ground.call('rav1/set_speed', SetSpeed, speed_mps=4.0, lease=lease)
        assert 'the lease of operator is void: taken over' in refused.message
        renewed = ground.call('rav1/lease', Lease, request=Lease.Request.RENEW, lease=lease)
        assert not renewed.success
        # Hold needs no lease; who takes it again is obeyed again.
        assert ground.call('rav1/hold', Trigger).success
        answer = ground.call('rav1/set_speed', SetSpeed, speed_mps=4.0)
        assert 'void' not in answer.message
