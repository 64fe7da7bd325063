# SPDX-License-Identifier: Apache-2.0
"""A real ground vehicle gets drive_route over the bridge: a fake Rover, and ArduPilot's own."""

import math

import pytest
from rclpy.action import ActionClient
from std_srvs.srv import Trigger
from test.fakes.fake_autopilot import HOME
from test.fakes.fake_rover import MANUAL, FakeRover
from test.mavlink import sitl
from test.mavlink.airspace import HARMLESS, Airspace
from test.mavlink.operator_post import HOME_PLACE, Ground

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_interfaces.action import DriveRoute
from rocsafe_interfaces.msg import GeoPoint, GroundRoute, GroundStop, VehicleState
from rocsafe_interfaces.srv import Resume
from rocsafe_mavlink.autopilots.ardupilot import COPTER, ROVER, ROVER_SMART_RTL
from rocsafe_mavlink.drone.drone import DroneSpec
from rocsafe_mavlink.flight import flight
from rocsafe_mavlink.plan.flight_limits import FlightLimits
from rocsafe_mavlink.plan.flight_plan import mission_of
from rocsafe_mavlink.vehicle_interface.drive_conversions import drive_assignment
from rocsafe_ros.conversions import point_of_position

REAL_S = 200.0
ROVERS = [
    'fake',
    pytest.param(
        'sitl',
        marks=[
            pytest.mark.skipif(
                not sitl.ROVER_BINARY, reason='ROCSAFE_SITL_ROVER names no Rover simulator'
            ),
            pytest.mark.system,
            pytest.mark.all,
        ],
    ),
]
SPEED_MPS = 1.5


def drive(*norths, vehicle='rav1', dwell_s=2.0):
    """Return a way to the north with evidence at some places, a bend, and back."""
    ways = [(0.0, ''), *((north, f'e{number}') for number, north in enumerate(norths, 1))]
    ways = [*ways, (0.5 * norths[-1], ''), (0.0, '')]
    stops = [
        GroundStop(
            position=point_of_position(offset(HOME_PLACE, 0.0, north, 0.0)),
            speed_limit_mps=SPEED_MPS if number else 0.0,
            dwell_s=dwell_s if evidence else 0.0,
            evidence=evidence,
        )
        for number, (north, evidence) in enumerate(ways)
    ]
    return GroundRoute(route_id='drive-1', vehicle=vehicle, stops=stops, dose_budget_usv=100.0)


@pytest.fixture(params=ROVERS)
def make_ground(ros, request, tmp_path):
    """Give a function that makes a bridge with one rover, and an operator."""
    made = []

    def make(precaution='', rate=10.0, **options):
        is_real = request.param == 'sitl'
        if is_real:
            air = sitl.SitlGround((1,), tmp_path, rate, precaution)
        else:
            air = Airspace((1,), kind=FakeRover)
            air.copters[1].parameters.update(sitl.ROVER_PRECAUTIONS[precaution])
        drone = {'drives': True, 'speed_mps': SPEED_MPS}
        ground = Ground(ros, air, tmp_path / 'state', drone=drone, **options)
        ground.deadline_s = REAL_S if is_real else 60.0
        ground.drives = ActionClient(ground.operator, DriveRoute, 'rav1/drive_route')
        ground.actions.append(ground.drives)
        made.append(ground)
        return ground

    yield make
    for ground in made:
        ground.close()
        ground.air.close()


@pytest.fixture
def ground(make_ground):
    """Give a bridge with one rover, and an operator."""
    return make_ground()


def sent(ground, route, **fields):
    """Send a drive; return the future of its result."""
    goal = DriveRoute.Goal(
        route=route, lease=fields.pop('lease', None) or ground.lease(), **fields
    )
    ground.until(ground.drives.server_is_ready)
    accepted = ground.drives.send_goal_async(goal)
    ground.until(accepted.done)
    ground.goal = accepted.result()
    return ground.goal.get_result_async()


def under_way(ground, route):
    """Drive; return the future of the result when the first evidence is behind."""
    result = sent(ground, route)
    ground.until(lambda: result.done() or ground.seen().viewpoints_visited >= 1, ground.deadline_s)
    assert not result.done(), result.result().result.error_msg
    return result


def test_rover_drives_to_the_evidence_and_back(ground):
    """It stands, photographs and comes home; its motors are off at the end."""
    result = ground.ended(sent(ground, drive(10.0, 20.0)), ground.deadline_s)
    assert result.outcome == DriveRoute.Result.COMPLETED, result.error_msg
    assert list(result.evidence_taken) == ['e1', 'e2']
    assert result.distance_driven_m == pytest.approx(40.0, abs=8.0)
    assert result.duration_s > 0.0
    here = GeoPosition(result.position.latitude, result.position.longitude)
    assert abs(here.latitude_deg - HOME[0]) < 5e-5
    ground.until(lambda: not ground.air.is_armed(), ground.deadline_s)
    ground.wait_for_state(VehicleState.LANDED)


def test_rover_holds_and_goes_on(ground):
    """Within its way; the evidence behind it stays behind."""
    result = under_way(ground, drive(8.0, 40.0))
    assert ground.call('rav1/hold', Trigger).success
    ground.wait_for_state(VehicleState.HOLDING)
    ground.until(lambda: ground.seen().speed_mps < 0.3, ground.deadline_s)
    assert ground.seen().viewpoints_visited == 1
    assert ground.call('rav1/resume', Resume).success
    done = ground.ended(result, ground.deadline_s)
    assert done.outcome == DriveRoute.Result.COMPLETED, done.error_msg


def test_rover_returns_on_its_own_tracks(ground):
    """Before its last evidence; the drive ends at home, switched off."""
    result = under_way(ground, drive(8.0, 60.0))
    assert ground.call('rav1/return_home', Trigger).success
    done = ground.ended(result, ground.deadline_s)
    assert done.outcome == DriveRoute.Result.RETURNED_EARLY, done.error_msg
    assert list(done.evidence_taken) == ['e1']
    ground.until(lambda: not ground.air.is_armed(), ground.deadline_s)


def test_drive_that_is_sent_again_joins_the_one_under_way(ground):
    """Both goals end with the drive, as those of a flight do."""
    route = drive(8.0, 20.0)
    first = under_way(ground, route)
    again = ground.ended(sent(ground, route), ground.deadline_s)
    assert again.outcome == DriveRoute.Result.COMPLETED, again.error_msg
    assert list(again.evidence_taken) == ['e1', 'e2']
    assert ground.ended(first, ground.deadline_s).outcome == DriveRoute.Result.COMPLETED


def orders(ground):
    """Return the orders that reached the rover so far."""
    ground.air.hear_all()
    return [order for order in ground.air.told() if order not in HARMLESS]


def refused(ground, *names):
    """Assert that orders are refused, and that none of them reaches the rover."""
    before = orders(ground)
    for name in names:
        kind = Resume if name == 'resume' else Trigger
        answer = ground.call(f'rav1/{name}', kind)
        assert not answer.success
        assert 'not ours to command' in answer.message
    other = drive(30.0)
    other.route_id = 'drive-2'
    replaced = ground.ended(sent(ground, other, replace=True))
    assert replaced.outcome == DriveRoute.Result.REJECTED
    assert 'not ours to command' in replaced.error_msg
    assert orders(ground) == before


def test_rover_that_stands_by_its_battery_is_not_driven_on(make_ground, monkeypatch):
    """It says so by one text; its mode obeys, and its status is that of each stand.

    After a while its drive ends, so that nobody waits for a vehicle that nobody may order.
    """
    monkeypatch.setattr(flight, 'STOOD_S', 20.0)
    ground = make_ground('battery holds')
    result = under_way(ground, drive(8.0, 60.0))
    ground.air.drain()
    ground.until(lambda: 'failsafe: battery' in ground.seen().text, ground.deadline_s)
    refused(ground, 'resume')
    done = ground.ended(result, ground.deadline_s)
    assert done.outcome == DriveRoute.Result.BATTERY_LOW, done.error_msg
    assert 'its motors are on' in done.error_msg
    assert ground.air.is_armed()


def test_rover_that_its_battery_brings_home_is_left_on(make_ground):
    """The drive ends there; nothing is ordered, not even that its motors stop."""
    ground = make_ground('battery')
    result = under_way(ground, drive(8.0, 60.0))
    before = orders(ground)
    ground.air.drain()
    done = ground.ended(result, ground.deadline_s)
    assert done.outcome == DriveRoute.Result.BATTERY_LOW, done.error_msg
    assert 'its motors are on' in done.error_msg
    assert ground.air.is_armed()
    assert orders(ground) == before


def test_rover_that_its_pilot_takes_is_his(ground):
    """By any mode of his, until he switches it off; the drive ends then."""
    result = under_way(ground, drive(8.0, 60.0))
    ground.air.be_switched(MANUAL)
    ground.until(lambda: 'MANUAL' in ground.seen().text, ground.deadline_s)
    refused(ground, 'hold', 'resume', 'return_home', 'land')
    before = orders(ground)
    ground.air.be_switched_off()
    done = ground.ended(result, ground.deadline_s)
    assert done.outcome == DriveRoute.Result.RETURNED_EARLY, done.error_msg
    assert orders(ground) == before


def test_rover_that_its_pilot_sends_home_is_left_on(ground):
    """Whoever chose the way home is the one who switches it off."""
    result = under_way(ground, drive(8.0, 60.0))
    before = orders(ground)
    ground.air.be_switched(ROVER_SMART_RTL)
    done = ground.ended(result, ground.deadline_s)
    assert done.outcome == DriveRoute.Result.RETURNED_EARLY, done.error_msg
    assert 'its pilot brought it back' in done.error_msg
    assert ground.air.is_armed()
    assert orders(ground) == before


def test_drive_after_one_that_was_switched_off_begins_at_its_begin(ground):
    """The rover keeps the item at which it was, and would leave out the way to it."""
    route = drive(8.0, 16.0, 40.0, dwell_s=1.0)
    result = sent(ground, route)
    ground.until(lambda: ground.seen().viewpoints_visited >= 2, ground.deadline_s)
    ground.air.be_switched_off()
    assert ground.ended(result, ground.deadline_s).outcome != DriveRoute.Result.COMPLETED
    other = drive(12.0, 4.0, 10.0, dwell_s=1.0)
    other.route_id = 'drive-2'
    done = ground.ended(sent(ground, other), ground.deadline_s)
    assert done.outcome == DriveRoute.Result.COMPLETED, done.error_msg
    assert list(done.evidence_taken) == ['e1', 'e2', 'e3']
    # From 14 m or more to 12, 4, 10, 5 and 0 m; without the first places 20 m or less.
    assert done.distance_driven_m > 21.0


def test_another_drive_takes_the_place_of_the_first(ground):
    """The rover stands, is sent the way, and drives it from its first place."""
    first = under_way(ground, drive(8.0, 60.0))
    other = drive(14.0, 6.0)
    other.route_id = 'drive-2'
    done = ground.ended(sent(ground, other, replace=True), ground.deadline_s)
    assert done.outcome == DriveRoute.Result.COMPLETED, done.error_msg
    assert list(done.evidence_taken) == ['e1', 'e2']
    assert ground.ended(first).outcome == DriveRoute.Result.ABORTED


def test_rover_whose_station_falls_silent_comes_back(make_ground):
    """By its own failsafe, on its tracks; the bridge that comes back orders nothing."""
    ground = make_ground('link', 3.0, needs_supervisor=True)
    ground.supervise()
    result = under_way(ground, drive(8.0, 60.0))
    before = orders(ground)
    ground.abandon()
    with ground.air.calm():
        ground.until(lambda: ground.seen().state == VehicleState.RETURNING, ground.deadline_s)
    ground.supervise()
    refused(ground, 'resume')
    done = ground.ended(result, ground.deadline_s)
    assert done.outcome == DriveRoute.Result.ABORTED, done.error_msg
    # A Rover names any of its failsafes.
    assert 'Failsafe' in done.error_msg
    assert orders(ground) == before


def test_cancelled_drive_stands(ground):
    """The vehicle holds where it is."""
    result = under_way(ground, drive(8.0, 60.0))
    ground.until(ground.goal.cancel_goal_async().done, ground.deadline_s)
    done = ground.ended(result, ground.deadline_s)
    assert done.outcome == DriveRoute.Result.CANCELLED
    ground.wait_for_state(VehicleState.HOLDING)


def test_cancelled_new_drive_is_not_driven(ground):
    """While it takes the place of another: the vehicle holds."""
    first = under_way(ground, drive(8.0, 60.0))
    other = drive(30.0)
    other.route_id = 'drive-2'
    result = sent(ground, other, replace=True)
    ground.until(lambda: any('MISSION_COUNT' in one for one in ground.air.told()[-3:]))
    answer = ground.goal.cancel_goal_async()
    ground.until(answer.done)
    assert answer.result().goals_canceling
    ground.wait_for_state(VehicleState.HOLDING)
    assert ground.ended(result, ground.deadline_s).outcome != DriveRoute.Result.COMPLETED
    assert not first.done()


@pytest.mark.parametrize(
    ('route', 'text'),
    [
        (drive(10.0, vehicle='rgv7'), 'the route is for rgv7'),
        (GroundRoute(vehicle='rav1'), 'must be 2 or more'),
        (drive(9000.0), 'distance'),
    ],
)
def test_drive_that_cannot_be_is_refused_before_anything_moves(ros, tmp_path, route, text):
    """With the reason; the motors stay off."""
    air = Airspace((1,), kind=FakeRover)
    made = Ground(ros, air, tmp_path / 'state', drone={'drives': True})
    made.drives = ActionClient(made.operator, DriveRoute, 'rav1/drive_route')
    made.actions.append(made.drives)
    try:
        done = made.ended(sent(made, route))
        assert done.outcome == DriveRoute.Result.REJECTED
        assert text in done.error_msg
        assert not air.is_armed()
        without = made.ended(sent(made, drive(10.0), lease='none'))
        assert without.outcome == DriveRoute.Result.REJECTED
    finally:
        made.close()
        air.close()


def test_rover_gets_no_flight_and_a_drone_no_drive():
    """A route of the wrong kind is refused by what the heartbeat says, not by the file."""
    spec = DroneSpec(name='rav1', target=(1, 1), frame=None, limits=FlightLimits())
    plan = drive_assignment(drive(10.0), spec).plan
    with pytest.raises(ValueError, match='must get its routes by fly_route'):
        mission_of(plan, COPTER)
    items = mission_of(plan, ROVER).items
    # Home, speed, the evidence with its stand, the shutter, the bend, the start: no return.
    assert [item.command for item in items] == [16, 178, 16, 203, 16, 16]
    assert items[1].parameters[1] == SPEED_MPS
    assert items[2].parameters[0] == 2.0


@pytest.mark.parametrize(
    ('changes', 'text'),
    [
        ({'speed_limit_mps': math.nan}, 'speed_mps'),
        ({'speed_limit_mps': -1.0}, 'speed_mps'),
        ({'dwell_s': 1e6}, 'hold_s'),
        ({'position': GeoPoint(latitude=math.nan, longitude=8.5)}, 'latitude'),
    ],
)
def test_stop_that_no_vehicle_can_drive_is_refused(changes, text):
    """Before it becomes an item of a mission."""
    route = drive(10.0, 20.0)
    for name, value in changes.items():
        setattr(route.stops[1], name, value)
    spec = DroneSpec(name='rav1', target=(1, 1), frame=None, limits=FlightLimits())
    with pytest.raises(ValueError, match=text):
        drive_assignment(route, spec)
