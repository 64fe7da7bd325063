# SPDX-License-Identifier: Apache-2.0
"""Every order in every state of a real vehicle, and orders during the start of a flight."""

import copy
import functools

import pytest
from test.fakes.fake_autopilot import HOME
from test.fakes.verb_table import VERBS, Answer, answers
from test.mavlink.test_flight import plan
from test.mavlink.test_station import ready_air

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.ardupilot import BRAKE, LOITER
from rocsafe_mavlink.autopilots.autopilot import FlightState
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.plan.fence import Fence

PLACE = GeoPosition(*HOME)
ORDERS = {
    'hold': lambda commands, now_s: commands.hold(now_s),
    'return_home': lambda commands, now_s: commands.return_home(now_s),
    'land': lambda commands, now_s: commands.land(now_s),
    'resume': lambda commands, now_s: commands.resume(now_s),
    'go_to': lambda commands, now_s: commands.go_to(PLACE, 30.0, now_s),
    'set_speed': lambda commands, now_s: commands.change_speed(5.0, now_s),
    'fence': lambda commands, now_s: commands.push_fence(Fence(), now_s),
    'rally': lambda commands, now_s: commands.push_rally([PLACE], 30.0, now_s),
}
ANSWERS = answers(is_real=True)
STATES = sorted({state for state, _verb in ANSWERS})


def obeyed(air, order):
    """Give an order and wait until it is answered; return its error."""
    commands = air.drones[1].commands
    ORDERS[order](commands, air.now_s)
    number = commands.count
    air.until(lambda: commands.outcome(number) is not None, 60.0)
    if order in ('return_home', 'land') and not commands.outcome(number):
        air.drones[1].gave_up()
    return commands.outcome(number)


def is_uploading(air):
    """Whether the route is being sent."""
    return any(m.name == 'MISSION_ITEM_INT' for m in air.sent)


# When a flight that was begun is in a state; the others are reached by an order in the air.
BEGUN = {
    'starting': is_uploading,
    # Its motors run, but no heartbeat has shown it.
    'arming': lambda air: air.copters[1].is_armed,
    'armed': lambda air: air.drones[1].vehicle.is_armed,
    'taking off': lambda air: shown(air, 'taking off'),
}
ORDERED = {'holding': 'hold', 'returning': 'return_home', 'landing': 'land', 'landed': 'land'}


def air_in(state):
    """Return an air whose copter is in a state."""
    return copy.deepcopy(_first_air_in(state))


@functools.cache
def _first_air_in(state):
    air = ready_air()
    if state == 'waiting':
        air.drones[1].wait_until(air.now_s + 100.0)
    if state not in ('disarmed', 'waiting'):
        air.fly(count=6)
        is_there = BEGUN.get(state, lambda air: air.flight().visited >= 1)
        air.until(lambda: is_there(air))
    if state in ORDERED:
        assert obeyed(air, ORDERED[state]) == ''
    if state == 'landed':
        air.until(lambda: not air.copters[1].is_armed)
    air.loss = 1.0 if state == 'lost' else 0.0
    air.wait({'lost': 15.0, 'arming': 0.0, 'armed': 0.0}.get(state, 1.1))
    return air


def shown(air, state):
    """Whether the copter is in a state of the table."""
    seen = air.drones[1].status(air.now_s).state
    is_beginning = air.flight() is not None and air.flight().is_beginning
    return seen.name.replace('_', ' ').lower() == {'starting': 'disarmed'}.get(state, state) and (
        is_beginning is (state in ('starting', 'armed'))
    )


@pytest.mark.slow
@pytest.mark.parametrize('state', STATES)
@pytest.mark.parametrize('order', VERBS)
def test_every_order_has_its_answer_in_every_state(state, order):
    """By the table of orders and states; what is refused sends nothing."""
    air = air_in(state)
    assert shown(air, state)
    answer = ANSWERS[state, order]
    if answer is Answer.REFUSED:
        count = air.drones[1].commands.count
        with pytest.raises(CommandRefusedError):
            ORDERS[order](air.drones[1].commands, air.now_s)
        assert air.drones[1].commands.count == count
        return
    assert obeyed(air, order) == ''
    if answer is Answer.NOTHING:
        assert shown(air, state)


@pytest.mark.slow
@pytest.mark.parametrize('order', ['hold', 'return_home', 'land'])
@pytest.mark.parametrize('state', ['waiting', 'starting', 'arming'])
def test_who_is_told_to_stay_before_it_takes_off_stays(state, order):
    """Also where its motors run already: they are stopped, and the flight is over."""
    air = air_in(state)
    assert obeyed(air, order) == ''
    assert not air.copters[1].is_armed
    air.wait(120.0)
    copter, drone = air.copters[1], air.drones[1]
    assert not copter.is_armed
    assert not copter.is_flying
    assert not drone.is_waiting
    assert drone.status(air.now_s).state is FlightState.DISARMED
    if state != 'waiting':
        assert air.flight().outcome is FlightOutcome.ABORTED_BY_OPERATOR


def test_order_that_meets_the_take_off_is_obeyed_in_the_air():
    """The autopilot refuses to stop its motors, since it has left the ground: it brakes."""
    air = air_in('armed')
    copter = air.copters[1]
    air.until(lambda: 300 in copter.commands)
    copter._on_arm = lambda _message: 4
    assert obeyed(air, 'hold') == ''
    assert (copter.is_armed, copter.mode) == (True, BRAKE)


def test_hold_is_not_withdrawn_by_what_an_order_before_it_does():
    """The mode of a resume shows only after the hold was given: nobody else has the vehicle."""
    air = air_in('holding')
    commands, copter = air.drones[1].commands, air.copters[1]
    copter.mode = BRAKE
    air.wait(2.0)
    ORDERS['resume'](commands, air.now_s)
    air.until(lambda: copter.mode != BRAKE)
    on_command, lost = copter._on_command, []
    copter._on_command = lambda message: on_command(message) if lost else lost.append(message)
    assert obeyed(air, 'hold') == ''
    assert lost
    air.wait(3.0)
    assert air.drones[1].status(air.now_s).state is FlightState.HOLDING


def test_route_that_was_given_up_is_not_resumed():
    """A vehicle that was told to return and then to hold does not fly its old route."""
    air = air_in('returning')
    assert obeyed(air, 'hold') == ''
    with pytest.raises(CommandRefusedError, match='was given up'):
        ORDERS['resume'](air.drones[1].commands, air.now_s)
    air.drones[1].commands.replace_route(plan(4), air.now_s)


def unheard(air):
    """Let nothing reach the copter or come from it."""
    air.loss = 1.0


def unanswered(air):
    """Let the copter say nothing to commands."""
    air.copters[1]._on_command = lambda _message: None


def in_progress(air):
    """Let the copter answer for ever that it is at work."""
    copter = air.copters[1]
    copter._on_command = lambda message: copter._say(
        'COMMAND_ACK', command=message['command'], result=5
    )


# A call and its alternative, 30 s each, and 3.5 s until a mode shows: as docs/bridge.md says.
ANSWERED_S = 64.0


@pytest.mark.slow
@pytest.mark.parametrize('order', ['hold', 'return_home', 'land'])
@pytest.mark.parametrize('state', ['flying', 'holding', 'arming', 'starting'])
@pytest.mark.parametrize('misfortune', [None, unheard, unanswered, in_progress])
def test_orders_that_end_a_flight_and_cancels_are_answered_in_time(state, order, misfortune):
    """A cancelled goal is a hold. Whatever the autopilot does, it is known how it ended."""
    air = air_in(state)
    if misfortune is not None:
        misfortune(air)
    commands = air.drones[1].commands
    ORDERS[order](commands, air.now_s)
    number = commands.count
    air.until(lambda: commands.outcome(number) is not None, ANSWERED_S)
    if misfortune is None:
        assert commands.outcome(number) == ''


@pytest.mark.parametrize('is_late', [True, False])
def test_start_that_waits_is_withdrawn_when_somebody_else_uses_the_vehicle(is_late):
    """The pilot starts the motors, flies and lands: it does not take off beside him then."""
    air = air_in('waiting' if is_late else 'disarmed')
    drone, copter = air.drones[1], air.copters[1]
    before = drone.session.withdrawals
    copter.be_flown(LOITER)
    air.wait(2.0)
    assert (drone.is_waiting, drone.session.withdrawals) == (False, before + 1)
    assert 'somebody else' in drone.session.withdrawn_by
    copter.be_landed()
    air.wait(2.0)
    assert drone.session.withdrawals == before + 2


def test_own_motors_withdraw_no_start():
    """Those that a flight of ours starts, and stops at its end."""
    air = air_in('disarmed')
    before = air.drones[1].session.withdrawals
    air.fly(count=2)
    air.until(lambda: air.flight().is_over)
    assert air.flight().outcome is FlightOutcome.COMPLETED
    assert air.drones[1].session.withdrawals == before
