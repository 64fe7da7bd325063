# SPDX-License-Identifier: Apache-2.0
"""A late answer to one command does not stand for the next command of its number."""

import pytest
from test.fakes.fake_autopilot import AUTO, BRAKE, HOME
from test.mavlink.test_station import Air

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_mavlink.protocols.answer_book import LATEST_S, AnswerBook
from rocsafe_mavlink.wire.dialect import Message

PLACES = offset(GeoPosition(*HOME), 60.0, 20.0), offset(GeoPosition(*HOME), -60.0, 20.0)


def sent(confirmation=0, **fields):
    """Return a command to set the speed."""
    return Message('COMMAND_LONG', {'command': 178, 'confirmation': confirmation, **fields}, 255)


def answer(result=0):
    """Return an answer to such a command."""
    return Message('COMMAND_ACK', {'command': 178, 'result': result}, 1, 1)


def test_as_many_answers_are_late_as_older_commands_are_owed():
    """Sent twice without an answer, then another call of equal content: the third is its own."""
    book = AnswerBook()
    book.note(sent(), 0.0)
    book.note(sent(1), 1.5)
    book.note(sent(), 3.0)
    assert [book.answers_newest(answer(), 3.1) for _ in range(3)] == [False, False, True]


def test_answered_commands_are_owed_nothing():
    """The usual case costs no time."""
    book = AnswerBook()
    for now_s in (0.0, 1.0, 2.0):
        book.note(sent(), now_s)
        assert book.answers_newest(answer(), now_s + 0.1)


def test_answers_are_not_waited_for_for_ever():
    """What was lost comes no more."""
    book = AnswerBook()
    book.note(sent(), 0.0)
    book.note(sent(), 5.0)
    assert book.answers_newest(answer(), LATEST_S + 0.1)


def test_word_on_progress_of_an_older_command_is_not_that_of_the_newest():
    """It settles nothing: the final answer is owed yet."""
    book = AnswerBook()
    book.note(sent(), 0.0)
    book.note(sent(), 1.0)
    assert [book.answers_newest(answer(5), 1.1), book.answers_newest(answer(), 1.2)] == [False] * 2
    assert book.answers_newest(answer(), 1.3)


def flying():
    """Return an air whose copter flies its mission."""
    air = Air()
    air.wait(46.0)
    air.fly(count=6)
    air.until(lambda: air.flight().visited >= 1)
    return air


def ended(air):
    """Wait for the end of an order; return its error."""
    commands = air.drones[1].commands
    number = commands.count
    air.until(lambda: commands.outcome(number) is not None, 60.0)
    return commands.outcome(number)


def with_late_answers(air, number):
    """Let the answers to a command be kept back; return those, and what lets new ones through."""
    copter, kept, is_late = air.copters[1], [], [True]
    say = copter._say

    def say_late(name, **fields):
        if name == 'COMMAND_ACK' and fields['command'] == number and is_late[0]:
            kept.append(fields)
        else:
            say(name, **fields)

    copter._say = say_late
    return kept, say


@pytest.mark.slow
def test_late_answer_to_a_speed_does_not_stand_for_the_next():
    """The first answer comes after the second order, which is lost itself."""
    air = flying()
    copter, commands = air.copters[1], air.drones[1].commands
    kept, say = with_late_answers(air, 178)
    commands.change_speed(8.0, air.now_s)
    assert 'no answer' in ended(air)
    copter._on_speed = lambda _message: 0
    obey = copter._on_command
    copter._on_command = lambda m: None if m['command'] == 178 else obey(m)
    commands.change_speed(2.0, air.now_s)
    air.wait(1.3)
    say('COMMAND_ACK', **kept[0])
    assert 'no answer' in ended(air)


@pytest.mark.slow
def test_go_to_is_obeyed_once_the_copter_tells_its_place():
    """The second is answered by the late answer to the first, and lost; then it is sent again."""
    air = flying()
    copter, commands = air.copters[1], air.drones[1].commands
    commands.go_to(PLACES[0], 30.0, air.now_s)
    assert ended(air) == ''
    air.wait(2.0)
    assert air.drones[1].vehicle.aim.altitude_msl_m == pytest.approx(518.0)
    obey, copter._on_reposition = copter._on_reposition, lambda _message: 0
    commands.go_to(PLACES[1], 30.0, air.now_s)
    assert 'heartbeats do not show it' in ended(air)
    copter._on_reposition = obey
    commands.go_to(PLACES[1], 30.0, air.now_s)
    assert ended(air) == ''


@pytest.mark.slow
@pytest.mark.parametrize('phase', [0, 3])
def test_hold_of_an_old_autopilot_is_believed_by_its_mode(phase):
    """Where no phase is told a pause cannot be seen: it is switched to BRAKE."""
    air = flying()
    copter = air.copters[1]
    if not phase:
        tell = copter._mission_current
        copter._mission_current = lambda: {**tell(), 'mission_state': 0}
        air.wait(2.0)
    air.drones[1].commands.hold(air.now_s)
    assert ended(air) == ''
    assert copter.mode == (AUTO if phase else BRAKE)
