# SPDX-License-Identifier: Apache-2.0
"""An item that came back is compared by what it means, its place exactly."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_mavlink.protocols.mission_item import MissionItem, difference, item_of
from rocsafe_mavlink.wire.dialect import decode, encode

WAYPOINT = MissionItem(
    command=16, x_e7=473979219, y_e7=85458589, z_m=50.0, parameters=(2.0, 0.0, 0.0, 0.1)
)


def over_the_wire(item):
    """Return what arrives when `item` is sent."""
    number, payload = encode(item.message(7, (1, 1), 0))
    return item_of(decode(number, payload, 1, 1))


places = st.integers(-(2**31), 2**31 - 1)
numbers = st.floats(-1e4, 1e4)


@given(places, places, numbers, st.tuples(numbers, numbers, numbers, numbers))
def test_what_is_sent_comes_back_the_same(x_e7, y_e7, z_m, parameters):
    """The wire's precision is no difference."""
    item = MissionItem(command=16, x_e7=x_e7, y_e7=y_e7, z_m=z_m, parameters=parameters)
    assert difference(item, over_the_wire(item)) == ''


@pytest.mark.parametrize(
    'back',
    [
        replace(WAYPOINT, frame=3),
        replace(WAYPOINT, z_m=50.01),
        replace(WAYPOINT, parameters=(2.0, 0.0, 0.0, 0.105)),
    ],
    ids=['older frame', 'centimetres', 'two decimals'],
)
def test_same_meaning_is_no_difference(back):
    """Autopilots store less than they were sent."""
    assert difference(WAYPOINT, back) == ''


@pytest.mark.parametrize(
    ('back', 'words'),
    [
        (replace(WAYPOINT, x_e7=WAYPOINT.x_e7 + 1), 'x_e7 is 473979220, sent was 473979219'),
        (replace(WAYPOINT, command=20), 'command is 20, sent was 16'),
        (replace(WAYPOINT, frame=0), 'frame is 0, sent was 3'),
        (replace(WAYPOINT, z_m=51.0), 'z_m is 51, sent was 50'),
        (replace(WAYPOINT, parameters=(0.0, 0.0, 0.0, 0.1)), 'param1 is 0, sent was 2'),
    ],
)
def test_other_meaning_is_told(back, words):
    """Each field that matters is compared, and named."""
    assert difference(WAYPOINT, back) == words


def test_item_without_a_place_is_compared_without_one():
    """Return-to-launch comes back with any frame and place."""
    back = MissionItem(command=20, frame=0, x_e7=5, y_e7=5, z_m=9.0)
    assert difference(MissionItem(command=20), back) == ''


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'z_m': math.nan}, 'z_m is nan'),
        ({'parameters': (0.0, math.inf, 0.0, 0.0)}, 'param2 is inf'),
        ({'x_e7': 2**31}, 'x_e7 is'),
        ({'command': 0}, 'command is 0'),
    ],
)
def test_wrong_item_is_not_made(changes, words):
    """NaN in a mission has stopped an autopilot."""
    with pytest.raises(ValueError, match=words):
        replace(WAYPOINT, **changes)


def test_open_parameters_count_as_zero():
    """An autopilot may answer NaN for what it does not use."""
    message = WAYPOINT.message(1, (1, 1), 0)
    opened = replace(message, fields={**message.fields, 'param4': math.nan, 'param2': math.inf})
    assert item_of(opened).parameters == (2.0, 0.0, 0.0, 0.0)
