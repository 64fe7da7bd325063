# SPDX-License-Identifier: Apache-2.0
"""A command ends accepted, refused with the autopilot's words, or unanswered."""

import pytest
from test.mavlink.sky import TARGET, US

from rocsafe_mavlink.protocols.command_call import (
    CallStage,
    CommandCall,
    HeardText,
    arm,
    change_speed,
    set_interval,
)
from rocsafe_mavlink.wire.dialect import Message


def begun(now_s=10.0, heard=()):
    """Return a call for arming that was sent."""
    call, sent = CommandCall(command=arm(TARGET), us=US).begin(now_s, heard)
    assert [message['confirmation'] for message in sent] == [0]
    return call


def answer(result, *, number=400, system=1, **fields):
    """Return an answer of the autopilot."""
    return Message('COMMAND_ACK', {'command': number, 'result': result, **fields}, system, 1)


def text(words):
    """Return a text of the autopilot."""
    return Message('STATUSTEXT', {'severity': 3, 'text': words}, 1, 1)


@pytest.mark.parametrize('fields', [{}, {'target_system': 255, 'target_component': 190}])
def test_accepted(fields):
    """With or without our name in it."""
    call = begun().on_message(answer(0, **fields), 10.1)
    assert (call.stage, call.error, call.is_over) == (CallStage.ACCEPTED, '', True)


@pytest.mark.parametrize(
    'message',
    [
        answer(0, number=176),
        answer(0, system=2),
        answer(0, target_system=254, target_component=190),
        answer(0, target_system=255, target_component=1),
    ],
    ids=['other command', 'other vehicle', 'other station', 'other component'],
)
def test_answer_to_another_is_none(message):
    """Only the answer to this command, of this vehicle, to us."""
    assert begun().on_message(message, 10.1) == begun()


def test_refusal_carries_the_words_around_it():
    """Half a second before to a second and a half after; older words belong to something else."""
    call = begun(10.0, [HeardText(3.0, 'old'), HeardText(9.8, 'just before')])
    call = call.on_message(text('while waiting'), 10.1).on_message(answer(4), 10.2)
    assert not call.is_over
    call = call.on_message(text('Arm: Need Position Estimate'), 11.0)
    assert not call.on_tick(11.6)[0].is_over
    call, sent = call.on_tick(11.71)
    assert (call.stage, sent) == (CallStage.REFUSED, [])
    assert call.error == (
        'command 400 failed; just before; while waiting; Arm: Need Position Estimate'
    )


def test_words_of_a_long_wait_are_forgotten():
    """What was said two seconds before a refusal is no reason."""
    call = begun().on_message(text('chatter'), 10.1).on_message(answer(2), 12.1)
    assert call.on_tick(13.7)[0].error == 'command 400 denied'


def test_silence_repeats_and_ends():
    """Three repetitions, 1.5 s apart, counted; then an end."""
    call, times, now_s = begun(), [], 10.0
    while not call.is_over:
        now_s += 0.125
        call, sent = call.on_tick(now_s)
        times += [(now_s, message['confirmation']) for message in sent]
    assert times == [(11.5, 1), (13.0, 2), (14.5, 3)]
    assert (call.stage, call.error) == (CallStage.UNANSWERED, 'no answer to command 400')
    assert now_s == 16.0


def test_progress_extends_the_wait():
    """A command under way is not repeated for ten seconds."""
    call = begun().on_message(answer(5), 10.1)
    assert call.on_tick(20.0) == (call, [])
    assert call.on_message(answer(0), 19.0).stage is CallStage.ACCEPTED


def test_late_answer_changes_nothing():
    """What is over stays as it is."""
    done = begun().on_message(answer(0), 10.1)
    assert done.on_message(answer(4), 10.2) is done
    assert done.on_tick(99.0) == (done, [])


def test_parameters_are_in_their_places():
    """Speed over ground is kind 1; an interval is in microseconds."""
    speed, rate = change_speed(TARGET, 4.0), set_interval(TARGET, 33, 10.0)
    assert (speed['param1'], speed['param2']) == (1.0, 4.0)
    assert (rate['param1'], rate['param2']) == (33.0, 100_000.0)
