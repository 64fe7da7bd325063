# SPDX-License-Identifier: Apache-2.0
"""Why a PX4 left its mission, in words."""

import pytest
from test.mavlink.telemetry import said

from rocsafe_mavlink.flight.flight_outcome import FlightOutcome, failsafe_of
from rocsafe_mavlink.knowledge.px4_events import event_number, text_of_event
from rocsafe_mavlink.wire.dialect import decode, encode


def event(name, *arguments, level=2):
    """Return an event as it comes, over the wire."""
    padded = [*arguments, *[0] * (40 - len(arguments))]
    sent = said('EVENT', id=event_number(name), log_levels=0x30 | level, arguments=padded)
    return decode(*encode(sent), 1, 1)


def test_numbers_are_those_of_a_real_one():
    """As a PX4 of August 2025 sends them."""
    assert event_number('commander_failsafe_enter') == 26528394
    assert event_number('check_gf_violation_max_hor_dist') == 20842799


@pytest.mark.parametrize(
    ('name', 'arguments', 'outcome'),
    [
        ('commander_failsafe_enter', (1, 0, 0, 0, 6, 2), FlightOutcome.FAILSAFE_LINK),
        (
            'commander_failsafe_enter_hold',
            (1, 0, 0, 0, 6, 5, 0, 4),
            FlightOutcome.FAILSAFE_BATTERY,
        ),
        ('commander_failsafe_enter', (1, 0, 0, 0, 6, 6), FlightOutcome.FAILSAFE_BATTERY),
        ('check_gf_violation_custom_gf', (255, 3), FlightOutcome.FAILSAFE_FENCE),
        # Whatever its cause: a PX4 that holds in a failsafe is in a mode that obeys, too.
        ('commander_failsafe_enter', (1, 0, 0, 0, 6, 1), FlightOutcome.FAILSAFE_OTHER),
        ('commander_failsafe_enter', (1, 0, 0, 0, 6, 99), FlightOutcome.FAILSAFE_OTHER),
        ('commander_failsafe_enter_generic', (1, 0, 0, 0, 6), FlightOutcome.FAILSAFE_OTHER),
        ('commander_failsafe_enter_generic_hold', (1,), FlightOutcome.FAILSAFE_OTHER),
    ],
)
def test_failsafe_is_named(name, arguments, outcome):
    """The text is for people; the outcome follows from it."""
    text = text_of_event(event(name, *arguments))
    assert (text.name, text['severity'], failsafe_of(text['text'])) == ('STATUSTEXT', 2, outcome)


@pytest.mark.parametrize(
    ('name', 'arguments'),
    [
        ('commander_failsafe_enter_generic_warn', (1,)),
        ('commander_takeoff_detected', ()),
    ],
    ids=['a warning', 'another event'],
)
def test_other_events_say_nothing(name, arguments):
    """What is not known is not guessed."""
    sent = event(name, *arguments)
    assert text_of_event(sent) is sent
