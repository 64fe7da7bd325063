# SPDX-License-Identifier: Apache-2.0
"""Messages are found between whatever else there is."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as library
from test.mavlink.wire import HEARTBEAT, POSITION, frame

from rocsafe_mavlink.link.peer import Peer
from rocsafe_mavlink.wire.counters import Counters
from rocsafe_mavlink.wire.framing import LARGEST_FRAME, scan


def names(data):
    """Return the ids of the frames in a datagram."""
    return [found.message_id for found in scan(data, is_whole=True).frames]


@given(st.binary(max_size=300), st.binary(max_size=300))
def test_garbage_around_a_message_hides_nothing(before, after):
    """A good frame is found between any bytes."""
    assert 33 in names(before + frame() + after)


@pytest.mark.parametrize('start', [b'\xfd', b'\xfe', b'\xfd\xff\x00\x00\x00\x01\x01\x00\x00\x00'])
def test_false_start_swallows_nothing(start):
    """A frame that claims to be longer than the datagram leaves the one behind it."""
    assert names(start + frame()) == [33]


def test_truncated_datagram_does_not_reach_into_the_next():
    """Datagrams keep their borders."""
    peer = Peer(Counters())
    assert peer.receive(frame()[:-5], 0.0, 0.0) == []
    assert [message.name for message in peer.receive(frame(), 0.0, 0.0)] == [POSITION.name]
    assert peer.buffered == 0


@pytest.mark.parametrize('place', range(len(frame())))
def test_every_damaged_byte_is_noticed(place):
    """No frame with a changed byte passes."""
    data = bytearray(frame())
    data[place] ^= 0x41
    assert names(bytes(data)) == []


def test_unknown_flag_is_not_read():
    """A frame with an incompatibility flag that we do not know is no message."""
    data = bytearray(frame())
    data[2] = 0x02
    assert names(bytes(data)) == []


def test_mavlink_1_is_read():
    """The older format is read too."""
    sender = library.MAVLink(None, srcSystem=1, srcComponent=1)
    heartbeat = library.MAVLink_heartbeat_message(2, 3, 0, 0, 3, 3)
    assert names(heartbeat.pack(sender, force_mavlink1=True)) == [0]


@given(st.lists(st.integers(1, 40), min_size=1, max_size=60))
def test_stream_is_read_in_any_pieces(sizes):
    """Bytes without borders give the same messages however they are cut."""
    data = b'\xfd\x00noise' + frame() + frame(HEARTBEAT, 1) + b'\xfe' + frame(sequence=2)
    data += bytes(LARGEST_FRAME)
    peer = Peer(Counters(), is_stream=True)
    heard, place = [], 0
    for size in [*sizes, len(data)]:
        heard += peer.receive(data[place : place + size], 0.0, 0.0)
        place += size
        assert peer.buffered <= LARGEST_FRAME
    assert [message.name for message in heard] == [POSITION.name, 'HEARTBEAT', POSITION.name]
