# SPDX-License-Identifier: Apache-2.0
"""A link hears whom it may, believes what can be true, and sends what is allowed."""

import math
import pickle

import numpy as np
import pytest
from test.mavlink.wire import (
    DRONE,
    FUZZ_COUNT,
    HEARTBEAT,
    NOW_S,
    POSITION,
    STRANGER,
    frame,
    open_link,
)

from rocsafe_mavlink.errors import NotAllowedError
from rocsafe_mavlink.link.link import Link, LinkIdentity, LinkRules
from rocsafe_mavlink.link.link_limits import LINK_LIMITS
from rocsafe_mavlink.wire.authority import COMPONENT_ARM_DISARM, DO_REPOSITION
from rocsafe_mavlink.wire.counters import Reason
from rocsafe_mavlink.wire.dialect import CRC_EXTRAS, Message, checksum
from rocsafe_mavlink.wire.framing import scan
from rocsafe_mavlink.wire.plausibility import LIMITS, fault_of

LARGEST_MEMORY = 64 * 1024
NUMBERS = np.array(list(CRC_EXTRAS))


def changed(message, **fields):
    """Return `message` with other fields."""
    return Message(message.name, {**message.fields, **fields})


def test_only_allowed_addresses_are_heard():
    """A stranger is counted, not heard, and no memory is spent on it."""
    link = open_link()
    assert link.receive(STRANGER, frame(), 0.0, NOW_S) == []
    assert link.counters.dropped(Reason.UNKNOWN_PEER) == 1
    assert [message.name for message in link.receive(DRONE, frame(), 0.0, NOW_S)] == [
        POSITION.name
    ]
    assert link.peers == (DRONE,)


def test_discovery_hears_who_makes_sense():
    """While discovering, a believable message introduces an address; garbage does not."""
    link = open_link(is_discovering=True)
    assert link.receive(STRANGER, b'\xfdgarbage', 0.0, NOW_S) == []
    assert link.peers == ()
    assert link.receive(STRANGER, frame(), 0.0, NOW_S)
    assert link.peers == (STRANGER,)


def test_strangers_cannot_use_up_the_table():
    """Any number of them, signed or not: a vehicle's address stays, a new one is heard."""
    link = open_link(allowed=frozenset(), is_discovering=True)
    assert link.receive(DRONE, frame(), 0.0, NOW_S)
    link.held = frozenset({DRONE})
    for port in range(1000):
        link.receive(('127.0.0.1', 20_000 + port), frame(), port, NOW_S)
    assert len(link.peers) == LINK_LIMITS.peers + 1
    assert DRONE in link.peers
    assert link.receive(('127.0.0.1', 50_000), frame(), 1000.0, NOW_S)


def test_peer_that_is_heard_is_not_forgotten():
    """The one that was heard longest ago goes first."""
    link = open_link(allowed=frozenset(), is_discovering=True)
    for port in range(LINK_LIMITS.peers):
        link.receive(('127.0.0.1', port), frame(), 0.0, NOW_S)
    link.receive(('127.0.0.1', 0), frame(), 1.0, NOW_S)
    link.receive(STRANGER, frame(), 2.0, NOW_S)
    assert ('127.0.0.1', 0) in link.peers
    assert ('127.0.0.1', 1) not in link.peers


def test_stranger_cannot_disturb_a_peer():
    """What a stranger sends changes nothing for the drone."""
    link = open_link()
    for _ in range(5000):
        link.receive(STRANGER, frame(), 0.0, NOW_S)
    assert link.receive(DRONE, frame(), 0.0, NOW_S)


@pytest.mark.parametrize(
    'message',
    [
        changed(POSITION, lat=900000001),
        changed(POSITION, lon=-1800000001),
        changed(POSITION, alt=20_000_001),
        changed(POSITION, alt=-500_001),
        changed(POSITION, vx=30_001),
        Message('ATTITUDE', {'roll': math.nan}),
        Message('ATTITUDE', {'yaw': math.inf}),
        Message('CAMERA_FEEDBACK', {'alt_msl': math.nan}),
        Message('MISSION_CURRENT', {'seq': 65_535}),
        Message('BATTERY_STATUS', {'battery_remaining': 101}),
    ],
    ids=lambda message: message.name,
)
def test_what_cannot_be_true_is_dropped(message):
    """A right checksum does not make a number true."""
    link = open_link()
    assert link.receive(DRONE, frame(message), 0.0, NOW_S) == []
    assert link.counters.dropped(Reason.IMPLAUSIBLE) == 1


def test_what_nobody_reads_is_dropped():
    """Messages of other kinds are counted."""
    link = open_link()
    assert link.receive(DRONE, frame(Message('FILE_TRANSFER_PROTOCOL', {})), 0.0, NOW_S) == []
    assert link.counters.dropped(Reason.UNUSED) == 1


def test_oversized_datagram_is_not_read():
    """No more than a few packets' worth is looked at."""
    link = open_link()
    assert link.receive(DRONE, frame() + bytes(LINK_LIMITS.datagram_bytes), 0.0, NOW_S) == []
    assert link.counters.dropped(Reason.OVERSIZE) == 1


def test_flood_is_limited():
    """Beyond two thousand messages a second the rest is dropped, a second later heard again."""
    link = open_link()
    count = int(LINK_LIMITS.messages_per_s)
    heard = sum(len(link.receive(DRONE, frame(), 0.0, NOW_S)) for _ in range(count + 100))
    assert heard == count
    assert link.counters.dropped(Reason.RATE) == 100
    assert link.receive(DRONE, frame(), 1.0, NOW_S)


def test_missing_sequence_numbers_are_counted():
    """A gap counts as lost, also over the end of the numbers; a restart does not."""
    link = open_link()
    for sequence in (253, 255, 0, 1, 4, 200):
        link.receive(DRONE, frame(sequence=sequence), 0.0, NOW_S)
    assert link.counters.lost == 1 + 2
    assert link.counters.by_name() == {'received': 6, 'lost': 3}


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (Message('PARAM_SET', {}), 'PARAM_SET is not among'),
        (Message('COMMAND_LONG', {'command': 185}), 'command 185 is not among'),
        (Message('COMMAND_LONG', {'command': 246}), 'command 246 is not among'),
        (
            Message('COMMAND_LONG', {'command': COMPONENT_ARM_DISARM, 'param2': 21196.0}),
            'force is not allowed',
        ),
        (Message('MISSION_ITEM_INT', {'z': math.nan}), 'z = nan must be a finite number'),
        (Message('COMMAND_LONG', {'command': 178, 'param2': math.inf}), 'param2 = inf'),
    ],
    ids=['parameter', 'terminate', 'reboot', 'force', 'nan height', 'infinite speed'],
)
def test_what_may_not_be_sent_is_refused(message, words):
    """The last check before the wire names what it refuses."""
    link = open_link()
    with pytest.raises(NotAllowedError, match=words):
        link.pack(message, 0.0, NOW_S)
    assert link.counters.sent == 0


def test_ten_commands_a_second_are_sent():
    """The eleventh is refused, a heartbeat never."""
    link = open_link()
    order = Message('COMMAND_INT', {'command': DO_REPOSITION, 'param4': math.nan})
    for _ in range(10):
        link.pack(order, 0.0, NOW_S)
    with pytest.raises(NotAllowedError, match='more than 10 commands a second'):
        link.pack(order, 0.05, NOW_S)
    assert link.pack(HEARTBEAT, 0.05, NOW_S)
    assert link.pack(order, 0.2, NOW_S)


def test_sent_frames_are_numbered_and_named():
    """Sequence numbers turn over; the sender is who we said."""
    link = Link(LinkRules(), LinkIdentity(system=254, component=191))
    for _ in range(256):
        link.pack(HEARTBEAT, 0.0, NOW_S)
    (sent,) = scan(link.pack(HEARTBEAT, 0.0, NOW_S), is_whole=True).frames
    assert (sent.system, sent.component, sent.sequence) == (254, 191, 0)
    with pytest.raises(ValueError, match='system = 0 must be within'):
        LinkIdentity(system=0)


def random_bytes(source):
    """Return bytes without any sense."""
    return source.bytes(int(source.integers(0, 300)))


def mutated(source):
    """Return a good frame with some bytes changed."""
    data = bytearray(frame(sequence=int(source.integers(256))))
    for _ in range(int(source.integers(1, 5))):
        data[int(source.integers(len(data)))] = int(source.integers(256))
    return bytes(data)


def repaired(source):
    """Return a frame of any kind and any content, its checksum right."""
    number = int(source.choice(NUMBERS))
    payload = source.bytes(int(source.integers(1, 256)))
    head = bytes([0xFD, len(payload), 0, 0, 7, 1, 1]) + number.to_bytes(3, 'little')
    crc = checksum(head[1:] + payload + CRC_EXTRAS[number])
    return head + payload + crc.to_bytes(2, 'little')


def truncated(source):
    """Return the beginning of a good frame."""
    return frame()[: int(source.integers(len(frame())))]


KINDS = [random_bytes, mutated, repaired, truncated]


@pytest.mark.slow
@pytest.mark.parametrize('is_stream', [False, True], ids=['datagrams', 'stream'])
@pytest.mark.parametrize('kind', KINDS, ids=lambda kind: kind.__name__)
def test_fuzz(kind, is_stream):
    """No exception, bounded memory, true numbers only, and a good message is always heard."""
    source = np.random.default_rng([7, KINDS.index(kind)])
    link = open_link(is_stream=is_stream)
    link.receive(DRONE, frame(), 0.0, NOW_S)
    # A stream may wait for the end of a frame that a false start promised.
    good = frame(HEARTBEAT) + (bytes(300) if is_stream else b'')
    for step in range(FUZZ_COUNT // (2 * len(KINDS))):
        for message in link.receive(DRONE, kind(source), step, NOW_S):
            assert message.name in LIMITS
            assert not fault_of(message)
        if step % 16 == 0:
            heard = link.receive(DRONE, good, step, NOW_S)
            assert 'HEARTBEAT' in {message.name for message in heard}
    assert len(pickle.dumps(link)) < LARGEST_MEMORY
