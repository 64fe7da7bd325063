# SPDX-License-Identifier: Apache-2.0
"""MessagePack-RPC: whatever comes is a call, or one error; nothing hangs or is allocated."""

import random
import tracemalloc
from contextlib import suppress

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_airsim.errors import ProtocolError
from rocsafe_airsim.protocol.wire import DEEPEST, LARGEST_BYTES, Call, CallReader, answer, refusal

FRAMES = 20_000


def test_calls_come_out_of_any_pieces():
    """Two calls and a notification, byte by byte and at once."""
    data = b''.join(
        map(msgpack.packb, ([0, 7, 'ping', []], [2, 'note', [1]], [0, 8, 'land', [60, 'rav1']]))
    )
    expected = [
        Call(call_id=7, method='ping', arguments=()),
        Call(call_id=None, method='note', arguments=(1,)),
        Call(call_id=8, method='land', arguments=(60, 'rav1')),
    ]
    assert list(CallReader().feed(data)) == expected
    reader = CallReader()
    assert [call for byte in data for call in reader.feed(bytes([byte]))] == expected


def test_answers_are_as_clients_read_them():
    """The error comes before the result."""
    assert msgpack.unpackb(answer(3, {'x_val': 1.5})) == [1, 3, None, {'x_val': 1.5}]
    assert msgpack.unpackb(refusal(4, 'land: no')) == [1, 4, 'land: no', None]
    assert msgpack.unpackb(answer(5, b'\x00\xff')) == [1, 5, None, b'\x00\xff']


def test_an_array_is_a_list_of_its_floats():
    """Wherever it lies; what is beside it is packed as ever."""
    depth = np.linspace(0.0, 100.0, 70_000, dtype=np.float32)
    sent = [{'width': 3, 'data': depth, 'more': [b'\x00', None, 'text', depth[:2]]}]
    _, _, _, (found,) = msgpack.unpackb(answer(9, sent))
    assert found['data'] == depth.tolist()
    assert (found['width'], found['more']) == (3, [b'\x00', None, 'text', depth[:2].tolist()])
    with pytest.raises(TypeError):
        answer(9, [object()])


@pytest.mark.parametrize(
    'message',
    [
        17, 'text', None, [], [0, 1, 'ping'], [1, 1, None, 2], [0, -1, 'ping', []],
        [0, 2**33, 'ping', []], [0, True, 'ping', []], [0, 'x', 'ping', []],
        [0, 1, 5, []], [0, 1, 'p' * 101, []], [0, 1, 'ping', {}], [2, 'ping', 3],
    ],
)  # fmt: skip
def test_what_is_no_call_is_named(message):
    """One error, after which the connection is closed."""
    with pytest.raises(ProtocolError, match='must be'):
        list(CallReader().feed(msgpack.packb(message)))


def test_nesting_has_a_limit():
    """Also deep in maps."""
    deep = {}
    for _ in range(DEEPEST + 1):
        deep = {'a': deep}
    with pytest.raises(ProtocolError, match='nested'):
        list(CallReader().feed(msgpack.packb([0, 1, 'ping', [deep]])))


@pytest.mark.parametrize(
    'head',
    [
        b'\xdd\xff\xff\xff\xff',
        b'\xdf\xff\xff\xff\xff',
        b'\xc6\xff\xff\xff\xff',
        b'\xdb\xff\xff\xff\xff',
        b'\xdd\x00\x10\x00\x00' * 50,
    ],
    ids=['array', 'map', 'bytes', 'text', 'nested arrays'],
)
def test_a_forged_length_allocates_nothing(head):
    """Of 4 GiB; the memory stays below 2 MB."""
    tracemalloc.start()
    try:
        with suppress(ProtocolError):
            assert not list(CallReader().feed(head))
        assert tracemalloc.get_traced_memory()[1] < 2_000_000
    finally:
        tracemalloc.stop()


def test_a_message_beyond_the_limit_ends_the_connection():
    """Bytes that belong to a forged length are not kept for ever."""
    reader = CallReader()
    assert not list(reader.feed(b'\xc6\xff\xff\xff\xff'))
    pieces = [bytes(1_000_000)] * (LARGEST_BYTES // 1_000_000 + 2)
    with pytest.raises(ProtocolError):
        all(list(reader.feed(piece)) == [] for piece in pieces)


def test_any_bytes_are_calls_or_one_error():
    """Random frames and damaged calls; the same each time."""
    rng = random.Random(1)
    whole = msgpack.packb([0, 1, 'moveToPosition', [1.0, 2.0, -3.0, 4.0, {'is_rate': True}]])
    for number in range(FRAMES):
        frame = bytearray(whole if number % 2 else rng.randbytes(rng.randrange(1, 40)))
        for _ in range(rng.randrange(4)):
            frame[rng.randrange(len(frame))] = rng.randrange(256)
        with suppress(ProtocolError):
            assert all(isinstance(call, Call) for call in CallReader().feed(bytes(frame)))


@given(st.binary(max_size=200))
def test_drawn_bytes_are_calls_or_one_error(data):
    """As above, drawn."""
    with suppress(ProtocolError):
        assert all(isinstance(call, Call) for call in CallReader().feed(data))
