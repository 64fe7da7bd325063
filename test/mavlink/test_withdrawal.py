# SPDX-License-Identifier: Apache-2.0
"""Commands are withdrawn where pilot or failsafe has the vehicle; only verified missions fly."""

import math
from dataclasses import replace

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from builtin_interfaces.msg import Time
from test.fakes.fake_autopilot import HOME
from test.mavlink.test_flight import plan
from test.mavlink.test_station import Air, ready_air

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.ardupilot import AUTO, BRAKE, GUIDED, LAND, LOITER, RTL
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.plan.fence import Fence
from rocsafe_mavlink.protocols.onboard_mission import MissionCondition
from rocsafe_mavlink.vehicle_interface.conversions import state_message
from rocsafe_mavlink.wire.dialect import Message, encode
from rocsafe_mavlink.wire.framing import pack_frame


def flying(count=6):
    """Return an air with a flight whose first waypoint is behind."""
    return ready_air(count)


def changes(air):
    """Return the commands that change what the copter does, as (command, mode or 0)."""
    numbers = [m for m in air.sent if m.name in ('COMMAND_LONG', 'COMMAND_INT')]
    return [(m['command'], m['param2']) for m in numbers if m['command'] != 511]


def is_uploading(air, item):
    """Whether an item of the mission was sent."""
    return any(m.name == 'MISSION_ITEM_INT' and m['seq'] == item for m in air.sent)


def replacing(air, item=3):
    """Begin to replace the route; step until so many items were sent. Return the number."""
    air.sent.clear()
    air.drones[1].commands.replace_route(plan(4), air.now_s)
    air.until(lambda: is_uploading(air, item))
    return air.drones[1].commands.count


@pytest.mark.slow
@pytest.mark.parametrize(
    ('take_over', 'words'),
    [
        (lambda copter: copter.lose_battery(), 'withdrawn: Battery 1 is low'),
        (lambda copter: setattr(copter, 'mode', LOITER), 'withdrawn: the vehicle was switched'),
        (lambda copter: setattr(copter, 'mode', RTL), 'withdrawn: the vehicle was switched'),
    ],
    ids=['failsafe', 'pilot', 'silent return'],
)
def test_new_route_is_withdrawn_when_the_vehicle_is_taken_over(take_over, words):
    """In the middle of the upload: nothing is commanded any more, whatever was uploaded."""
    air = flying()
    number = replacing(air)
    commands = air.drones[1].commands
    take_over(air.copters[1])
    mode = air.copters[1].mode
    air.until(lambda: commands.outcome(number) is not None, 60.0)
    assert words in commands.outcome(number)
    air.wait(20.0)
    assert [change for change in changes(air) if change != (176, float(BRAKE))] == []
    assert not air.copters[1].is_armed or air.copters[1].mode == mode


def test_failsafe_that_a_part_of_a_text_names_counts_at_once():
    """The rest of a long text may come late or never: nothing is sent meanwhile."""
    air = flying()
    number, commands = replacing(air), air.drones[1].commands
    text = f'{"Battery Failsafe, 10.6 V and 274 mAh used of":<50}'
    fields = {'severity': 2, 'text': text, 'id': 7, 'chunk_seq': 0}
    before = changes(air)
    air.say(pack_frame(*encode(Message('STATUSTEXT', fields)), 1, 1, 0, sign=False))
    assert 'withdrawn: Battery Failsafe' in commands.outcome(number)
    with pytest.raises(CommandRefusedError, match='not ours to command: failsafe: battery'):
        commands.replace_route(plan(4), air.now_s)
    air.wait(20.0)
    assert changes(air) == before


def test_mode_of_a_failsafe_is_not_the_late_one_of_an_order_before():
    """A return that was lost, a hold, and a failsafe that returns without a word."""
    air = flying()
    copter, commands = air.copters[1], air.drones[1].commands
    receive = copter.receive
    copter.receive = lambda message, sender: (
        None if message.name == 'COMMAND_LONG' else receive(message, sender)
    )
    commands.return_home(air.now_s)
    air.wait(0.5)
    commands.hold(air.now_s)
    air.wait(0.5)
    copter.mode, copter.status = RTL, 5
    air.wait(1.5)
    before = changes(air)
    air.wait(20.0)
    assert changes(air) == before
    assert 'withdrawn: a failsafe has the vehicle, in RTL' in commands.outcome(commands.count)


def test_hold_is_not_given_against_a_failsafe_that_goes_on_with_an_ordered_return():
    """Without a word, in the same mode: the critical status comes between order and command."""
    air = flying()
    copter, commands = air.copters[1], air.drones[1].commands
    commands.return_home(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None)
    air.until(lambda: copter.mode == RTL)
    air.wait(2.0)
    before = changes(air)
    commands.hold(air.now_s)
    copter.status = 5
    beat = {'type': 2, 'autopilot': 3, 'base_mode': 0x80, 'custom_mode': RTL, 'system_status': 5}
    air.say(pack_frame(*encode(Message('HEARTBEAT', beat)), 1, 1, 0, sign=False))
    air.wait(20.0)
    assert changes(air) == before
    assert 'withdrawn: a failsafe has the vehicle, in RTL' in commands.outcome(commands.count)


def test_critical_status_withdraws_all_but_what_makes_the_flight_safer():
    """Without a text and in the same mode: a new route is withdrawn, a hold is obeyed."""
    air = flying()
    commands, copter = air.drones[1].commands, air.copters[1]
    number = replacing(air)
    copter.status = 5
    air.until(lambda: commands.outcome(number) is not None, 60.0)
    assert commands.outcome(number) == 'new route: withdrawn: a failsafe has the vehicle, in BRAKE'
    air = flying()
    commands = air.drones[1].commands
    commands.hold(air.now_s)
    air.copters[1].status = 5
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    assert commands.outcome(commands.count) == ''


def test_new_route_is_withdrawn_from_a_vehicle_that_has_landed():
    """It falls silent in the middle of the upload, and stands on the ground when it is heard."""
    air = flying()
    number = replacing(air)
    commands, copter = air.drones[1].commands, air.copters[1]
    copter.is_silent = True
    air.wait(3.5)
    copter.is_armed = False
    copter.is_silent = False
    before = changes(air)
    air.until(lambda: commands.outcome(number) is not None, 60.0)
    assert 'withdrawn: the motors were stopped' in commands.outcome(number)
    assert changes(air) == before


def test_new_route_is_refused_while_a_failsafe_has_the_vehicle():
    """Nor is one begun at all: the vehicle returns and lands."""
    air = flying()
    air.copters[1].lose_battery()
    air.until(lambda: air.flight().cause is FlightOutcome.FAILSAFE_BATTERY)
    before = changes(air)
    with pytest.raises(CommandRefusedError, match='not ours to command: failsafe: battery'):
        air.drones[1].commands.replace_route(plan(4), air.now_s)
    air.until(lambda: air.flight().is_over)
    assert changes(air) == before


def test_new_route_is_refused_while_the_pilot_has_the_vehicle():
    """He flies in a mode into which nothing of ours brings a vehicle."""
    air = flying()
    air.copters[1].mode = LOITER
    air.wait(2.0)
    with pytest.raises(CommandRefusedError, match='not ours to command: it is in LOITER'):
        air.drones[1].commands.replace_route(plan(4), air.now_s)


def test_start_is_not_repeated_against_the_pilot():
    """The answer to MISSION_START is lost and the pilot takes over: he keeps the vehicle."""
    air = ready_air()
    copter = air.copters[1]
    say = copter._say

    def say_less(name, **fields):
        if name != 'COMMAND_ACK' or fields['command'] != 300:
            say(name, **fields)

    copter._say = say_less
    # It does not even show that it flies.
    copter._on_start = lambda _message: 0
    air.fly()
    air.until(lambda: 300 in copter.commands)
    copter.mode = LOITER
    before = len(copter.commands)
    air.wait(20.0)
    assert [number for number in copter.commands[before:] if number != 511] == []
    assert copter.mode == LOITER
    assert air.flight().cause is FlightOutcome.ABORTED_BY_OPERATOR
    assert 'withdrawn' in air.flight().reason


def test_route_that_reads_back_wrong_is_not_resumed():
    """An item is stored 300 m high, every time: the vehicle stands, and is not sent on with it."""
    air = flying()
    copter = air.copters[1]
    keep = copter.missions._keep
    copter.missions._keep = lambda message, kind: keep(
        type(message)(message.name, {**message.fields, 'z': 300.0}), kind
    )
    commands, number = air.drones[1].commands, replacing(air)
    air.until(lambda: commands.outcome(number) is not None, 120.0)
    assert 'z_m is 300' in commands.outcome(number)
    assert air.drones[1].session.readout.mission.condition is MissionCondition.TORN
    assert copter.mode == BRAKE
    with pytest.raises(CommandRefusedError, match='was not verified: send a route again'):
        commands.resume(air.now_s)
    copter.missions._keep = keep
    again = replacing(air)
    air.until(lambda: commands.outcome(again) is not None, 60.0)
    assert commands.outcome(again) == ''
    assert air.drones[1].session.readout.mission.condition is MissionCondition.VERIFIED
    assert copter.mode == AUTO


def test_route_whose_upload_was_preempted_is_not_resumed():
    """Somebody holds the vehicle in the middle of the upload: a part of each route lies on it."""
    air = flying()
    commands = air.drones[1].commands
    replacing(air)
    commands.hold(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    with pytest.raises(CommandRefusedError, match='was not verified'):
        commands.resume(air.now_s)


def test_mission_that_another_station_overwrote_is_not_resumed():
    """It is read again after a lost link, and is another one."""
    air = flying()
    commands, copter = air.drones[1].commands, air.copters[1]
    commands.hold(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    copter.is_silent = True
    air.wait(15.0)
    del copter.missions.stored[0][-2:]
    copter.is_silent = False
    air.wait(5.0)
    assert air.drones[1].session.readout.mission.condition is MissionCondition.UNKNOWN
    with pytest.raises(CommandRefusedError, match='another mission lies on it'):
        commands.resume(air.now_s)


def test_own_mission_is_resumed_as_soon_as_it_is_read_again():
    """No moment lies between reading it and knowing whose it is."""
    air = flying()
    session, commands = air.drones[1].session, air.drones[1].commands
    commands.hold(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    # Read, and no time has passed since.
    session.readout.mission = session.readout.mission.read(session.flight.mission.items)
    commands.resume(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    assert commands.outcome(commands.count) == ''
    assert session.readout.mission.condition is MissionCondition.VERIFIED


def held():
    """Return an air with a vehicle that holds in BRAKE, its mission verified."""
    air = flying()
    air.copters[1].missions.stored[0] = list(air.copters[1].missions.stored[0])
    commands = air.drones[1].commands
    commands.hold(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    return air


def test_mission_of_the_same_length_by_another_station_is_not_resumed():
    """Nothing tells of it but reading it again, which every resume does."""
    air = held()
    commands, stored = air.drones[1].commands, air.copters[1].missions.stored[0]
    stored[-2] = replace(stored[-2], x_e7=stored[-2].x_e7 + 9000)
    before = changes(air)
    commands.resume(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    assert 'mission not that of its plan: item' in commands.outcome(commands.count)
    assert changes(air) == before
    # It is read again, and known to be another one.
    air.wait(10.0)
    with pytest.raises(CommandRefusedError, match='another mission lies on it'):
        commands.resume(air.now_s)


def test_mission_that_is_changed_while_it_is_resumed_is_not_flown():
    """After it was read again, before the order: the vehicle tells another number of items."""
    air = held()
    commands, copter = air.drones[1].commands, air.copters[1]
    before = changes(air)
    commands.resume(air.now_s)
    air.until(lambda: air.drones[1].session.sequence.verified_mission is not None, 60.0)
    del copter.missions.stored[0][-2:]
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    assert 'another station has changed it' in commands.outcome(commands.count)
    assert changes(air) == before


def test_mission_that_is_changed_before_its_start_starts_no_motors():
    """Between its verification and the order to arm."""
    air = ready_air()
    air.fly()
    air.until(lambda: air.flight().sequence.verified_mission is not None)
    del air.copters[1].missions.stored[0][-2:]
    air.until(lambda: air.flight().is_over, 120.0)
    assert 'another station has changed it' in air.flight().reason
    assert 400 not in air.copters[1].commands


@pytest.mark.slow
def test_flight_that_would_begin_in_the_middle_starts_no_motors():
    """Another station chooses an item between verification and arming; a moment does not count."""
    air = ready_air()
    air.fly()
    air.until(lambda: air.flight().sequence.verified_mission is not None)
    air.copters[1].current = 4
    air.until(lambda: air.flight().is_over, 120.0)
    assert 'it would begin with item 4' in air.flight().reason
    assert 400 not in air.copters[1].commands
    air.fly(count=4)
    air.wait(3.0)
    air.copters[1].current = 0
    air.until(lambda: air.flight().is_over, 400.0)
    assert air.flight().outcome is FlightOutcome.COMPLETED


@pytest.mark.slow
@pytest.mark.parametrize('is_shorter', [True, False])
def test_mission_that_another_station_changes_in_flight_is_told(is_shorter):
    """At once where its length changes, else with the next reading; a hold is offered."""
    air = flying(count=40)
    stored = air.copters[1].missions.stored[0]
    if is_shorter:
        del stored[-2:]
    else:
        stored[-2] = replace(stored[-2], x_e7=stored[-2].x_e7 + 9000)

    def status():
        return air.drones[1].status(air.now_s)

    air.until(lambda: status().advice == 'hold', 10.0 if is_shorter else 100.0)
    assert 'it flies another mission than that of its plan' in status().text


@pytest.mark.slow
def test_mission_whose_reading_fails_stays_as_it_was_known():
    """A part of a list is no other mission."""
    air = flying(count=40)
    session = air.drones[1].session
    missions = air.copters[1].missions
    air.until(lambda: session.mission_condition() is MissionCondition.VERIFIED)
    answer, missions._on_request = missions._on_request, lambda *_: []
    air.wait(90.0)
    assert session.mission_condition() is MissionCondition.VERIFIED
    missions._on_request = answer


def test_flight_whose_autopilot_restarts_during_the_upload_is_refused():
    """What was checked before may no longer hold: it is checked again with the next route."""
    air = ready_air()
    air.fly()
    air.until(lambda: is_uploading(air, 2))
    air.copters[1].reboot()
    air.until(lambda: air.flight().is_over)
    assert air.flight().outcome is FlightOutcome.REJECTED
    assert 'the autopilot was started again' in air.flight().reason
    assert 400 not in air.copters[1].commands


ORDERS = {
    'hold': lambda commands, now_s: commands.hold(now_s),
    'resume': lambda commands, now_s: commands.resume(now_s),
    'return home': lambda commands, now_s: commands.return_home(now_s),
    'land': lambda commands, now_s: commands.land(now_s),
    'speed': lambda commands, now_s: commands.change_speed(5.0, now_s),
    'go to': lambda commands, now_s: commands.go_to(GeoPosition(*HOME), 30.0, now_s),
    'new route': lambda commands, now_s: commands.replace_route(plan(4), now_s),
    'fence': lambda commands, now_s: commands.push_fence(Fence(), now_s),
    'rally': lambda commands, now_s: commands.push_rally([GeoPosition(*HOME)], 30.0, now_s),
}


@pytest.mark.slow
@pytest.mark.parametrize('order', ORDERS)
@pytest.mark.parametrize(
    ('take_over', 'words'),
    [
        (lambda copter: setattr(copter, 'mode', LOITER), 'it is in LOITER'),
        (lambda copter: setattr(copter, 'mode', RTL), 'it is in RTL'),
        (lambda copter: copter.lose_battery(), 'failsafe: battery, in RTL'),
    ],
    ids=['pilot', 'silent return', 'failsafe'],
)
def test_every_command_is_refused_while_somebody_else_has_the_vehicle(order, take_over, words):
    """With the name of the mode; nothing at all is sent that changes anything."""
    air = flying()
    take_over(air.copters[1])
    air.wait(2.0)
    before = changes(air)
    with pytest.raises(CommandRefusedError, match=f'not ours to command: {words}'):
        ORDERS[order](air.drones[1].commands, air.now_s)
    air.wait(5.0)
    assert changes(air) == before


@pytest.mark.slow
@pytest.mark.parametrize('order', ['hold', 'resume', 'return home', 'land', 'speed', 'go to'])
def test_no_command_is_repeated_against_the_pilot(order):
    """Its answer is lost, and the pilot takes over before it is repeated."""
    air = flying()
    commands, copter = air.drones[1].commands, air.copters[1]
    if order == 'resume':
        commands.hold(air.now_s)
        air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    ignored = []
    copter._on_command = lambda message: message['command'] != 511 and ignored.append(message)
    ORDERS[order](commands, air.now_s)
    air.until(lambda: ignored, 5.0)
    copter.mode = LOITER
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    assert 'withdrawn: the vehicle was switched to LOITER' in commands.outcome(commands.count)
    assert len(ignored) == 1


@pytest.mark.slow
@pytest.mark.parametrize('order', ['hold', 'return home', 'land', 'speed', 'go to'])
def test_no_command_is_sent_or_repeated_without_a_heartbeat_since_the_last(order):
    """Other messages come, and nobody knows its mode: a pilot may have taken it meanwhile."""
    air = flying()
    commands, copter = air.drones[1].commands, air.copters[1]
    ignored = []
    copter._on_command = lambda message: message['command'] != 511 and ignored.append(message)
    air.until(lambda: air.drones[1].vehicle.heartbeat_s == air.now_s)
    due = copter._due
    copter._due = lambda name, *rest: None if name == 'HEARTBEAT' else due(name, *rest)
    ORDERS[order](commands, air.now_s)
    air.wait(2.5)
    is_urgent = order in ('hold', 'return home', 'land')
    assert len(ignored) == (1 if is_urgent else 0)
    assert commands.outcome(commands.count) is None
    copter._due = due
    air.wait(2.5)
    assert len(ignored) > is_urgent


@pytest.mark.parametrize(('order', 'mode'), [('land', LAND), ('return home', RTL)])
def test_mode_that_shows_is_not_ordered_again(order, mode):
    """The answer is lost, and a failsafe has chosen the same mode: nothing is repeated."""
    air = flying()
    commands, copter = air.drones[1].commands, air.copters[1]
    ignored = []
    copter._on_command = lambda message: message['command'] != 511 and ignored.append(message)
    ORDERS[order](commands, air.now_s)
    air.until(lambda: ignored, 5.0)
    copter.mode = mode
    air.wait(10.0)
    assert len(ignored) == 1
    assert commands.outcome(commands.count) == ''


@pytest.mark.slow
@pytest.mark.parametrize('order', ['hold', 'return home', 'land', 'speed', 'go to'])
def test_order_to_a_vehicle_that_falls_silent_is_not_given_when_it_is_heard_again(order):
    """Ten seconds later nobody knows what it did meanwhile: the order is withdrawn."""
    air = flying()
    commands, copter = air.drones[1].commands, air.copters[1]
    ignored = []
    copter._on_command = lambda message: message['command'] != 511 and ignored.append(message)
    ORDERS[order](commands, air.now_s)
    air.until(lambda: ignored, 5.0)
    copter.is_silent = True
    air.wait(11.0)
    assert 'withdrawn: the vehicle is not heard' in commands.outcome(commands.count)
    sent = len(ignored)
    copter.is_silent = False
    air.wait(10.0)
    assert len(ignored) == sent


def test_motors_that_the_pilot_started_are_left_to_him():
    """He arms by his stick while the mission is sent: the flight begins with no command."""
    air = ready_air()
    air.fly()
    air.until(lambda: is_uploading(air, 2))
    air.copters[1].is_armed = True
    air.copters[1]._armed_s = air.now_s + 60.0
    air.wait(30.0)
    assert changes(air) == []
    assert 'somebody else started the motors' in air.flight().reason


def test_nothing_is_disarmed_in_a_mode_of_the_pilot():
    """The answer to "arm" is lost, and he takes another mode: his motors may run by now."""
    air = ready_air()
    copter = air.copters[1]
    asked = []
    on_command = copter._on_command
    copter._on_command = lambda message: (
        asked.append(message['param1']) if message['command'] == 400 else on_command(message)
    )
    air.fly()
    air.until(lambda: asked, 60.0)
    copter.mode = LOITER
    air.until(lambda: air.flight().is_over, 60.0)
    assert 0.0 not in asked
    assert 'switched to LOITER before it was armed' in air.flight().reason


def test_mode_of_the_pilot_is_not_ours_because_a_transfer_ended_in_it():
    """A fence is pushed, and before the next heartbeat he has started the motors."""
    air = ready_air()
    commands, copter = air.drones[1].commands, air.copters[1]
    copter.mode = LOITER
    air.wait(2.0)
    commands.push_fence(Fence(), air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 60.0)
    copter.is_armed, copter.height_m = True, 20.0
    # It is the very next message.
    told = Message('HEARTBEAT', copter._heartbeat())
    air.say(pack_frame(*encode(told), 1, 1, 0, sign=False))
    air.wait(2.0)
    assert air.drones[1].vehicle.is_armed
    for order in ('hold', 'return home', 'land', 'go to'):
        with pytest.raises(CommandRefusedError, match='not ours to command: it is in LOITER'):
            ORDERS[order](commands, air.now_s)


def test_checks_are_repeated_before_the_motors_start():
    """The autopilot fails its self-test from the middle of the upload on: no flight begins."""
    air = ready_air()
    air.fly()
    air.until(lambda: is_uploading(air, 2))
    air.copters[1]._sys_status = lambda: {'battery_remaining': 20}
    air.until(lambda: air.flight().is_over, 60.0)
    assert 400 not in air.copters[1].commands
    assert 'self-test is not passed' in air.flight().reason
    assert 'charge is 20%' in air.flight().reason


@pytest.mark.slow
@pytest.mark.parametrize(
    ('mode', 'words'),
    [
        (LOITER, 'taken over: switched to LOITER by its pilot or another station'),
        (GUIDED, 'taken over: switched to GUIDED by its pilot or another station'),
        (RTL, 'switched to RTL by itself, its pilot or another station'),
    ],
)
def test_takeover_is_told(mode, words):
    """The published text names the mode, and says that it was not ours; a hold is ours."""
    air = flying()
    commands, drone = air.drones[1].commands, air.drones[1]
    commands.hold(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    assert drone.status(air.now_s).text.startswith(('mode AUTO; alt', 'mode BRAKE; alt'))
    air.copters[1].mode = mode
    air.wait(2.0)
    assert words in drone.status(air.now_s).text
    assert drone.status(air.now_s).text.startswith('mode ')


def test_position_and_speed_of_a_vehicle_that_has_not_told_them_are_nan():
    """As the contract says: zeros are a place in the sea."""
    status = Air().drones[1].status(0.0)
    message = state_message(status, 'rav1', Time(), (0, 0))
    assert math.isnan(message.position.latitude)
    assert math.isnan(message.speed_mps)


@pytest.mark.parametrize(('station', 'is_ours'), [((255, 190), True), ((250, 190), False)])
def test_upload_of_a_bridge_that_is_gone_is_cancelled_at_its_next_request(station, is_ours):
    """The autopilot still waits for an item: it is told that none comes, and is not asked then."""
    air = ready_air()
    air.sent.clear()
    system, component = station
    air.copters[1]._say(
        'MISSION_REQUEST_INT',
        target_system=system,
        target_component=component,
        seq=0,
        mission_type=0,
    )
    air.wait(0.5)
    cancels = [m for m in air.sent if m.name == 'MISSION_ACK' and m['type'] == 15]
    assert len(cancels) == is_ours


def test_nothing_is_read_while_the_autopilot_waits_for_an_upload_that_is_gone():
    """A PX4 that is asked for a list then refuses every upload."""
    air = Air()

    def lists():
        return [m for m in air.sent if m.name == 'MISSION_REQUEST_LIST']

    for _ in range(150):
        air.copters[1]._say(
            'MISSION_REQUEST_INT', target_system=255, target_component=190, seq=0, mission_type=0
        )
        air.wait(0.3)
    assert lists() == []
    air.wait(30.0)
    assert lists()


@pytest.mark.parametrize(
    ('happens', 'holder'),
    [
        (lambda _copter: None, ''),
        (lambda copter: setattr(copter, 'mode', LOITER), 'pilot'),
        (lambda copter: copter.lose_battery(), 'failsafe'),
    ],
    ids=['nothing', 'pilot', 'failsafe'],
)
def test_who_has_the_vehicle_is_told_in_its_state(happens, holder):
    """A mission gives no orders to one that others have; our own hold is no takeover."""
    air = flying()
    commands = air.drones[1].commands
    commands.hold(air.now_s)
    air.until(lambda: commands.outcome(commands.count) is not None, 30.0)
    happens(air.copters[1])
    air.wait(2.0)
    assert air.drones[1].status(air.now_s).taken_by == holder


def test_order_that_another_station_undid_is_not_repeated():
    """Its answer is lost; the copter returns, and is switched back to where the order found it."""
    air = flying()
    copter, commands = air.copters[1], air.drones[1].commands
    say = copter._say
    copter._say = lambda name, **said: None if name == 'COMMAND_ACK' else say(name, **said)
    commands.return_home(air.now_s)
    air.until(lambda: copter.mode == RTL, 5.0)
    for mode in (RTL, AUTO):
        copter.mode = mode
        copter._sent.pop('HEARTBEAT')
        air.until(lambda mode=mode: air.drones[1].vehicle.custom_mode == mode, 0.5)
    number = commands.count
    air.until(lambda: commands.outcome(number) is not None, 30.0)
    assert 'withdrawn: the vehicle was switched to AUTO' in commands.outcome(number)
    assert copter.mode == AUTO
    assert sum(change == (176, float(RTL)) for change in changes(air)) == 1
