# SPDX-License-Identifier: Apache-2.0
"""A bridge that is started again in flight knows what the vehicle does not say twice."""

from dataclasses import replace

import pytest
from test.fakes.fake_autopilot import RTL
from test.mavlink.test_flight import plan
from test.mavlink.test_homeward import flying_around
from test.mavlink.test_station import ready_air
from test.mavlink.test_unknown_way import ORDERS, flying, is_refused, serve
from test.mavlink.test_verbs_by_state import obeyed

from rocsafe_mavlink.autopilots.ardupilot import AUTO, BRAKE
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.flight.flight_journal import Assignment, FlightJournal
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.wire.dialect import Message

PLANS = [
    Assignment(plan_id=f'p{count}', plan=plan(count), viewpoint_ids=tuple(range(count)))
    for count in (4, 5)
]


def started_again(air, path):
    """Serve the vehicle by a bridge that knows nothing but its journal."""
    air.until(lambda: air.drones[1].step(air.now_s) is None)
    serve(air, FlightJournal(path), VehicleSession.of((1, 1), (255, 190)))
    drone = air.drones[1]
    air.until(lambda: (drone.step(air.now_s), drone.session.is_flying)[1], 60.0)
    air.wait(10.0)
    return drone


@pytest.mark.slow
@pytest.mark.parametrize('mode', [AUTO, BRAKE])
@pytest.mark.parametrize('order', ORDERS)
def test_failsafe_that_was_announced_before_is_not_forgotten(tmp_path, order, mode):
    """By words alone, in a mode that obeys every station: orders stay refused."""
    path = tmp_path / 'flight.json'
    air = flying(FlightJournal(path))
    copter = air.copters[1]
    copter._text(2, 'Battery Failsafe')
    copter.mode = mode
    air.wait(2.0)
    started_again(air, path)
    assert 'failsafe: battery' in is_refused(air, order)


@pytest.mark.slow
def test_failsafe_after_an_order_to_return_is_not_forgotten(tmp_path):
    """The order was the first reason why it left its mission, and the failsafe another."""
    path = tmp_path / 'flight.json'
    air = flying(FlightJournal(path))
    assert obeyed(air, 'return_home') == ''
    air.copters[1]._text(2, 'Battery Failsafe')
    air.wait(2.0)
    air.copters[1].mode = BRAKE
    air.wait(2.0)
    started_again(air, path)
    assert 'failsafe: battery' in is_refused(air, 'new route')


def test_route_that_was_given_up_before_is_not_resumed(tmp_path):
    """Told to return, then to hold; then the bridge is started again."""
    path = tmp_path / 'flight.json'
    air = flying(FlightJournal(path))
    assert obeyed(air, 'return_home') == ''
    assert obeyed(air, 'hold') == ''
    drone = started_again(air, path)
    assert drone.flight.cause is FlightOutcome.ABORTED_BY_OPERATOR
    assert 'was given up' in is_refused(air, 'resume')


def test_failsafe_of_a_flight_of_somebody_else_is_not_forgotten(tmp_path):
    """The pilot flies, without any plan of ours; then the bridge is started again."""
    path, air = tmp_path / 'flight.json', ready_air()
    copter = air.copters[1]
    serve(air, FlightJournal(path), air.drones[1].session)
    copter.is_armed, copter.mode, copter.height_m = True, BRAKE, 20.0
    air.wait(3.0)
    copter._text(2, 'Battery Failsafe')
    air.wait(2.0)
    air.drones[1].step(air.now_s)
    serve(air, FlightJournal(path), VehicleSession.of((1, 1), (255, 190)))
    air.wait(10.0)
    assert 'failsafe: battery' in is_refused(air, 'go to')
    copter.is_armed, copter.height_m = False, 0.0
    air.wait(3.0)
    air.drones[1].step(air.now_s)
    assert FlightJournal(path).failsafe is None


def test_failsafe_that_cannot_be_read_counts_as_one(tmp_path):
    """Its file is damaged: nothing is commanded until the motors have stopped."""
    (tmp_path / 'failsafe.json').write_text('"FAILSAFE_BAT')
    journal = FlightJournal(tmp_path / 'flight.json')
    assert journal.failsafe is FlightOutcome.FAILSAFE_OTHER


@pytest.mark.slow
@pytest.mark.parametrize('order', ['return_home', 'land'])
def test_route_that_was_given_up_before_its_flight_was_found_is_not_resumed(tmp_path, order):
    """The new bridge is told to return or land before it has read the mission."""
    path = tmp_path / 'flight.json'
    air = flying(FlightJournal(path))
    air.until(lambda: air.drones[1].step(air.now_s) is None)
    serve(air, FlightJournal(path), VehicleSession.of((1, 1), (255, 190)))
    air.wait(3.0)
    drone = air.drones[1]
    assert drone.flight is None
    assert obeyed(air, order) == ''
    assert obeyed(air, 'hold') == ''
    air.until(lambda: (drone.step(air.now_s), drone.session.is_flying)[1], 60.0)
    air.wait(10.0)
    assert 'was given up' in is_refused(air, 'resume')


def test_flight_is_not_looked_for_while_a_heartbeat_names_another_kind(tmp_path):
    """A new bridge hears a rover once: it must not end."""
    path = tmp_path / 'flight.json'
    air = flying(FlightJournal(path))
    air.until(lambda: air.drones[1].step(air.now_s) is None)
    serve(air, FlightJournal(path), VehicleSession.of((1, 1), (255, 190)))
    drone = air.drones[1]
    air.until(lambda: drone.session.readout.mission.items is not None, 60.0)
    drone.session.telemetry = replace(drone.vehicle, vehicle_type=10)
    drone.step(air.now_s)
    assert drone.flight is None
    air.wait(3.0)
    drone.step(air.now_s)
    assert drone.session.is_flying


def test_route_that_was_given_up_after_a_restart_of_the_autopilot_is_not_resumed():
    """The restart was the first reason why it left its mission; the order counts all the same."""
    air = flying()
    air.drones[1].session.flight = air.flight().restarted()
    assert obeyed(air, 'return_home') == ''
    assert obeyed(air, 'hold') == ''
    assert 'was given up' in is_refused(air, 'resume')


@pytest.mark.slow
def test_new_route_after_one_that_was_given_up_may_be_resumed():
    """Its end is its own, too: the order to return was for the one before."""
    air = flying()
    drone = air.drones[1]
    assert obeyed(air, 'return_home') == ''
    assert obeyed(air, 'hold') == ''
    drone.replace_route(PLANS[0], air.now_s)
    number = drone.commands.count
    air.until(lambda: drone.commands.outcome(number) is not None)
    assert drone.commands.outcome(number) == ''
    drone.switch_to(PLANS[0])
    assert obeyed(air, 'hold') == ''
    assert obeyed(air, 'resume') == ''
    air.until(lambda: drone.flight.is_over)
    assert drone.flight.outcome is FlightOutcome.COMPLETED


def unfound(air, path):
    """Serve the vehicle by a new bridge that cannot read the mission on it."""
    air.until(lambda: air.drones[1].step(air.now_s) is None)
    copter = air.copters[1]
    receive = copter.receive

    def receive_all_but(message, sender):
        is_reading = message.name.startswith('MISSION_REQUEST')
        if not is_reading or message.fields.get('mission_type'):
            receive(message, sender)

    copter.receive = receive_all_but
    serve(air, FlightJournal(path), VehicleSession.of((1, 1), (255, 190)))
    air.wait(60.0)
    assert air.drones[1].flight is None


@pytest.mark.slow
def test_exclusions_hold_where_no_flight_is_found(tmp_path):
    """Its mission cannot be read: a return flies around them all the same."""
    path = tmp_path / 'flight.json'
    air = flying_around(FlightJournal(path))
    copter = air.copters[1]
    copter.mode = BRAKE
    unfound(air, path)
    air.drones[1].commands.return_home(air.now_s)
    assert air.drones[1].session.sequence.name == 'return home'
    air.wait(5.0)
    assert copter.mode != RTL


@pytest.mark.slow
def test_failsafe_that_is_announced_where_no_flight_is_found_is_kept(tmp_path):
    """Its mission cannot be read, a failsafe is announced, and the bridge is started once more."""
    path = tmp_path / 'flight.json'
    air = flying_around(FlightJournal(path))
    air.copters[1].mode = BRAKE
    unfound(air, path)
    air.copters[1]._text(2, 'Battery Failsafe')
    air.wait(2.0)
    unfound(air, path)
    air.drones[1].step(air.now_s)
    assert air.drones[1].session.custody.failsafe is FlightOutcome.FAILSAFE_BATTERY


@pytest.mark.slow
def test_exclusions_hold_for_a_vehicle_that_was_given_up_as_lost():
    """It is heard again after eleven minutes, where it was."""
    air = flying_around()
    copter, drone = air.copters[1], air.drones[1]
    copter.mode = BRAKE
    air.loss = 1.0
    air.until(lambda: (drone.step(air.now_s), drone.flight.is_over)[1], 700.0)
    assert drone.flight.outcome is FlightOutcome.LOST
    air.loss = 0.0
    air.wait(60.0)
    assert 'exclusion 1 lies on the way' in is_refused(air, 'go to')
    drone.commands.return_home(air.now_s)
    assert drone.session.sequence.steps[0].modes != {RTL}


@pytest.mark.slow
def test_clock_that_goes_back_does_not_end_a_flight_as_lost():
    """A restart of the autopilot in the air, by its clock alone: it was heard a second ago."""
    air = flying()
    copter = air.copters[1]
    for _ in range(30):
        copter._boot_s = air.now_s
        said = {**copter._global_position_int(), 'time_boot_ms': 10}
        air.drones[1].take(Message('GLOBAL_POSITION_INT', said, 1, 1), air.now_s)
        air.drones[1].session.tick(air.now_s)
        assert not air.flight().is_over
        air.wait(0.3)
    assert air.flight().outcome is None


def flying_up():
    """Return an air whose copter climbs, says that it is on the ground, and refuses the start."""
    air = ready_air()
    copter = air.copters[1]
    step = copter.step

    def step_on_ground(now_s):
        was_low = copter.height_m < 9.0
        said = step(now_s)
        if was_low and copter.height_m >= 9.0:
            copter._say('COMMAND_ACK', command=300, result=4)
        for message in said:
            if message.name == 'EXTENDED_SYS_STATE' and copter.height_m < 29.0:
                message.fields['landed_state'] = 1
        return said

    copter.step = step_on_ground
    # In progress; that it failed is said later.
    copter._on_start = lambda _message: 5
    air.fly(count=3)
    return air


@pytest.mark.slow
def test_motors_are_not_stopped_in_the_air():
    """The start is refused as late as in the air, and the landed state is wrong."""
    air = flying_up()
    copter, drone = air.copters[1], air.drones[1]
    air.until(lambda: drone.flight.stage.name == 'FLYING', 120.0)
    assert 400 not in copter.commands[copter.commands.index(300) :]
    assert drone.flight.cause is FlightOutcome.REJECTED
    air.until(lambda: drone.flight.is_over, 400.0)
